"""Actuator calibration: friction by person, a transducer's circuit; and playback on a device."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.drive.friction_calibration import calibrated, read_pairs, write_calibrations
from tactogram.rendering.drive.modulation import carrier_of
from tactogram.rendering.drive.safety import safe
from tactogram.rendering.transducer.circuit import fitted_transducer, read_sweep
from tactogram.rendering.transducer.digilent import AnalogDiscovery, generator
from tactogram.signal.io import read_signal
from tactogram.workflows.rendering.requests import CalibrationRequest, PlayRequest
from tactogram.workflows.request import takes

LEAST_HZ = 1000.0
"""Transducers of ultrasonic displays resonate above it."""
CIRCUIT = (
    *("resonance_hz", "q", "r1_ohm", "l1_henry", "c1_farad", "c0_farad"),
    *("antiresonance_hz", "coupling", "envelope_cutoff_hz"),
)


@takes(CalibrationRequest)
def calibrate(request: CalibrationRequest) -> dict[str, Any]:
    """Fit voltage to friction, person by person, and write the settings of an electrovibration display.

    Keys of the result: ``file``, ``people`` (the fit by name, with ``square_law_holds`` and ``settings``) and
    ``spread``: largest over least k_e of the people.

    Raises `DataError` or `ParameterError` if the table cannot be read, or a person's pairs determine nothing. Nothing
    is written then.
    """
    if Path(request.out).suffix != ".toml":
        raise ParameterError(f"`out` must end in .toml, got {request.out}")
    pairs = read_pairs(request.pairs, normal_force_n=request.normal_force_n)
    found = [calibrated(one, confidence=request.confidence) for one in pairs]
    constants = [one.newton_per_v2 for one in found]
    return {
        "file": str(write_calibrations(request.out, found)),
        "people": {
            one.person: {
                **one.model_dump(mode="json"),
                "square_law_holds": one.square_law_holds,
                "settings": one.settings(),
            }
            for one in found
        },
        "spread": max(constants) / min(constants),
    }


def transducer(sweep: Path | str) -> dict[str, Any]:
    """Return the circuit fitted to a measured admittance, with the settings of a display.

    ``sweep``: CSV with columns ``frequency_hz``, ``conductance_s``, ``susceptance_s``.

    Raises `DataError` or `ParameterError` if the table cannot be read, too much of it was lost, or it holds no
    resonance.

    Returns
    -------
    dict
        The circuit: `CIRCUIT` and ``settling_ms``; ``residual`` (largest, over the
        largest admittance), ``points`` (fitted to), ``lost`` (no numbers in the table), ``settings`` for a display.
    """
    frequency, admittance = read_sweep(sweep)
    if frequency.max() < LEAST_HZ:
        raise ParameterError(
            f"{sweep}: its frequencies end at {frequency.max():g} Hz, far below ultrasound: are they in kHz?"
        )
    found = fitted_transducer(frequency, admittance)
    lost = np.isnan(admittance)
    away, measured = (found.admittance(frequency) - admittance)[~lost], admittance[~lost]
    return {
        **{name: getattr(found, name) for name in CIRCUIT},
        "settling_ms": 1e3 * found.settling_s,
        "residual": float(abs(away).max() / abs(measured).max()),
        "points": len(measured),
        "lost": int(lost.sum()),
        "settings": {"carrier_hz": found.resonance_hz, "q": found.q},
    }


@takes(PlayRequest)
def play(request: PlayRequest) -> dict[str, Any]:
    """Play a rendered envelope on a device that makes the carrier itself.

    The file is a drive rendered for a display whose output is ``envelope``: one axis, V. It is streamed once, and faded
    where it does not begin and end at 0 V; with ``loop_s`` it repeats from the device's own buffer.

    Returns
    -------
    dict
        Samples sent and lost, see `AnalogDiscovery.facts`.

    Raises
    ------
    ParameterError
        If the display's carrier is not the device's, or the file is not a drive of it.
    MissingExtraError, DeviceError
        If the library, driver or device is missing.
    """
    file, loop_s = request.file, request.loop_s
    kind, _, serial = request.device.partition(":")
    if kind != "digilent":
        raise ParameterError(f"device must be digilent or digilent:SERIAL, got {request.device!r}")
    known = open_display(request.display)
    settings = carrier_of(known)
    drive = read_signal(Path(file))
    if drive.unit != known.unit or len(drive.axes) != 1 or drive.domain != "time":
        raise ParameterError(
            f"{file}: is not a drive of {known.name}: expected one axis over time in {known.unit}, got "
            f"{len(drive.axes)} over {drive.domain} in {drive.unit}"
        )
    highest = float(drive.samples.max())
    if highest > known.limit * (1 + 1e-4) or drive.samples.min() < -1e-4 * known.limit:
        raise ParameterError(
            f"{file}: goes from {drive.samples.min():.4g} to {highest:.4g} V, outside of 0 to {known.limit:g} V of "
            f"{known.name}: render it for this display"
        )
    drive = drive.with_samples(drive.samples.clip(0, known.limit))
    ends = float(max(drive.samples[0, 0], drive.samples[0, -1]))
    if loop_s is None and ends > 0.01 * known.limit:
        drive, _ = safe(drive.with_samples(drive.samples, axes=known.channels), known.of(rate=drive.rate))
    opened = request.opened or AnalogDiscovery
    with opened(generator(settings, channel=request.channel, serial=serial)) as output:
        if loop_s is None:
            output.play(drive)
        else:
            output.loop(drive, loop_s)
        return output.facts()
