"""Actuators: friction calibrated by person, a transducer's circuit, its tracked carrier; playback on a device."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from annotated_types import Ge, Gt, Le

from tactogram.errors import ParameterError, Remedy
from tactogram.parameters import Settings, Share, checked

if TYPE_CHECKING:
    from tactogram_playback.transducer.digilent import AnalogDiscovery
    from tactogram_playback.workflows.carrier_tracking import CarrierTracking

PositiveShare = Annotated[float, Gt(0), Le(1)]
Steps = Annotated[int, Ge(1), Le(1_000_000)]
StepTime = Annotated[float, Ge(0), Le(3600)]
LoopTime = Annotated[float, Gt(0), Le(1e6)]
Seed = Annotated[int, Ge(0)]
LEAST_HZ = 1000.0
"""Transducers of ultrasonic displays resonate above it."""
CIRCUIT = (
    *("resonance_hz", "q", "r1_ohm", "l1_henry", "c1_farad", "c0_farad"),
    *("antiresonance_hz", "coupling", "envelope_cutoff_hz"),
)


@checked
def calibrate(
    pairs: Path | str, out: Path | str, *, normal_force_n: float | None = None, confidence: float = 0.95
) -> dict[str, Any]:
    """Fit voltage to friction, person by person, for an electrovibration display.

    Parameters
    ----------
    pairs : Path or str
        CSV with the columns voltage_v_rms, friction; person and normal_force_n if known.
    out : Path or str
        Settings of the display, .toml.
    normal_force_n : float, optional
        Normal force, N, where the table does not state it.
    confidence : float
        Confidence of the intervals.

    Returns
    -------
    dict
        ``file``, ``people`` (the fit by name, with ``square_law_holds`` and ``settings``) and ``spread``: largest over
        least k_e of the people.

    Raises
    ------
    DataError, ParameterError
        If the table cannot be read, or a person's pairs determine nothing; nothing is written then.
    """
    from tactogram_playback.friction_fit import calibrated, read_pairs, write_calibrations

    if Path(out).suffix != ".toml":
        raise ParameterError.must("out", "end in .toml", out)
    calibrations = [
        calibrated(data, confidence=confidence) for data in read_pairs(pairs, normal_force_n=normal_force_n)
    ]
    constants = [calibration.newton_per_v2 for calibration in calibrations]
    return {
        "file": str(write_calibrations(out, calibrations)),
        "people": {
            calibration.person: {
                **calibration.model_dump(mode="json"),
                "square_law_holds": calibration.square_law_holds,
                "settings": calibration.settings(),
            }
            for calibration in calibrations
        },
        "spread": max(constants) / min(constants),
    }


@checked
def transducer(sweep: Path | str) -> dict[str, Any]:
    """Identify a transducer's resonance and Q from its measured admittance.

    Parameters
    ----------
    sweep : Path or str
        CSV with the columns frequency_hz, conductance_s, susceptance_s; or a log of `track`, whose sweep is read.

    Returns
    -------
    dict
        The circuit: `CIRCUIT` and ``settling_ms``; ``residual`` (largest, over the largest admittance), ``points``
        (fitted to), ``lost`` (no numbers in the table), ``settings`` for a display.

    Raises
    ------
    DataError, ParameterError
        If the table cannot be read, too much of it was lost, or it holds no resonance.
    """
    import numpy as np

    from tactogram_playback.transducer.circuit import fitted_transducer, read_sweep

    frequency, admittance = read_sweep(sweep)
    if frequency.max() < LEAST_HZ:
        problem = f"its frequencies end at {frequency.max():g} Hz, far below ultrasound: are they in kHz?"
        raise ParameterError(sweep, problem)
    circuit = fitted_transducer(frequency, admittance)
    lost = np.isnan(admittance)
    away, measured = (circuit.admittance(frequency) - admittance)[~lost], admittance[~lost]
    return {
        **{name: getattr(circuit, name) for name in CIRCUIT},
        "settling_ms": 1e3 * circuit.settling_s,
        "residual": float(abs(away).max() / abs(measured).max()),
        "points": len(measured),
        "lost": int(lost.sum()),
        "settings": {"carrier_hz": circuit.resonance_hz, "q": circuit.q},
    }


@checked
def track(
    *,
    display: str,
    generator: str = "simulated",
    amps_per_volt: float | None = None,
    volts_per_volt: float = 1.0,
    skew_s: float = 0.0,
    share: PositiveShare = 0.25,
    steps: Steps = 100,
    every_s: StepTime = 0.0,
    channel: int = 1,
    seed: Seed = 0,
    changes: Settings | None = None,
    out: Path | str | None = None,
    status: Callable[[str], None] | None = None,
    opened: Callable[..., AnalogDiscovery] | None = None,
) -> dict[str, Any]:
    """Keep a carrier at a transducer's resonance, by its measured voltage and current.

    ``status`` receives a line now and then; ``opened`` opens the generator, in tests.

    Parameters
    ----------
    display : str
        An ultrasonic one with output = 'envelope', by name or file.
    generator : str
        digilent[:SERIAL], or simulated with its own bench.
    amps_per_volt : float, optional
        1 over the shunt's resistance in ohm.
    volts_per_volt : float
        Factor of the voltage probe.
    skew_s : float
        Delay of the current's sample after the voltage's, s.
    share : float
        Share of the largest voltage.
    steps : int
        Steps after the lock.
    every_s : float
        Seconds from step to step; 0 is as fast as possible.
    channel : int
        Channel of the generator.
    seed : int
        Seed of the simulated bench.
    changes : dict, optional
        Values of `CarrierTracking`, e.g. method=dither_conductance, timing.settle_s=0.1, scope.rate=200000,
        bench.drift_hz_per_s=1.
    out : Path or str, optional
        Log of everything measured, .csv.

    Returns
    -------
    dict
        ``resonance_hz``, ``q``, ``r1_ohm``, ``c0_farad`` (of the last lock's sweep), ``carrier_hz`` (at the end),
        ``lowest_hz``, ``highest_hz``, ``measured``, ``repeated`` (measurements with lost samples), ``lost`` (those
        repeated in vain), ``steps``, ``locks`` (more than one: the resonance was lost and found again),
        ``interrupted``, ``simulated``, ``settings`` for the display, ``file``.

    Raises
    ------
    ParameterError
        If the display or the changes do not fit.
    TrackingError, DeviceError, MissingExtraError
        If there is no resonance, or a device fails; it is at 0 V then, and the log is written all the same.
    """
    from tactogram.rendering import CarrierSettings, open_display
    from tactogram_playback.transducer.digilent import AnalogDiscovery
    from tactogram_playback.workflows.carrier_tracking import SIMULATED, CarrierTracking

    kind, _, serial = generator.partition(":")
    if kind not in ("digilent", SIMULATED):
        raise ParameterError.must("generator", "be digilent, digilent:SERIAL or simulated", generator)
    if out is not None and Path(out).suffix.lower() != ".csv":
        raise ParameterError.must("out", "end in .csv", out)
    known = open_display(display).settings
    if not isinstance(known, CarrierSettings):
        raise ParameterError.must("display", "have a carrier at its resonance", display)
    options = {
        "amps_per_volt": amps_per_volt,
        "volts_per_volt": volts_per_volt,
        "skew_s": skew_s,
        "share": share,
        "log": out,
    }
    simulated = generator == SIMULATED
    tracking = CarrierTracking(
        known,
        {name: value for name, value in options.items() if value is not None} | dict(changes or {}),
        serial=SIMULATED if simulated else serial,
        channel=channel,
        opened=opened or AnalogDiscovery,
        seed=seed,
        felt=False,
    )
    interrupted = False
    # Twice the time of all steps: the device then stops by itself.
    longest_s = 2 * steps * (2 * tracking.each_s + every_s)
    try:
        with tracking.generator(longest_s=longest_s) as device:
            if status is not None:
                status(f"locked at {tracking.tracker.frequency_hz:.1f} Hz")
            for step in range(steps):
                tracking.step(device)
                point = tracking.tracker.log[-1]
                if status is not None:
                    status(
                        f"{step + 1:6} of {steps}  {point.state:6}  {point.next_hz:9.1f} Hz  "
                        f"{1e3 * point.conductance_s:.3f} mS"
                    )
                if every_s:
                    time.sleep(every_s)
    except KeyboardInterrupt:
        interrupted = True
    result = _result(tracking, interrupted=interrupted, simulated=simulated)
    return result | ({"file": str(out)} if out is not None else {})


def _result(tracking: CarrierTracking, *, interrupted: bool, simulated: bool) -> dict[str, Any]:
    fitted, facts = tracking.tracker.fitted, tracking.facts()
    result: dict[str, Any] = {
        **{name: getattr(tracking.measure, name, 0) for name in ("measured", "repeated", "lost")},
        **{name: facts[name] for name in ("steps", "locks")},
        "interrupted": interrupted,
        "simulated": simulated,
    }
    if fitted is None or not facts["locks"]:
        return result
    return result | {
        **{name: facts[name] for name in ("carrier_hz", "lowest_hz", "highest_hz")},
        **{name: getattr(fitted, name) for name in ("resonance_hz", "q", "r1_ohm", "c0_farad")},
        "settings": {"carrier_hz": facts["carrier_hz"], "q": fitted.q},
    }


@checked
def play(
    file: Path | str,
    *,
    display: str,
    device: str = "digilent",
    channel: int = 1,
    loop_s: LoopTime | None = None,
    strength: Share = 1.0,
    full_scale: float | None = None,
    opened: Callable[..., AnalogDiscovery] | None = None,
) -> dict[str, Any]:
    """Play a rendered drive on a sound card, or an envelope on a generator that makes the carrier itself.

    A Digilent streams an envelope once, faded where it does not begin and end at 0 V, or repeats it from its own
    buffer; ``opened`` opens it, in tests. On a sound card Ctrl-C fades the drive out.

    Parameters
    ----------
    file : Path or str
        The drive, as `render` wrote it for the display.
    display : str
        That display, by name or file; a Digilent needs an envelope's: one axis, V.
    device : str
        digilent[:SERIAL], audio[:NAME], or null, with no actuator connected.
    channel : int
        Channel of the Digilent.
    loop_s : float, optional
        Repeat the drive for this time, s.
    strength : float
        Share of the drive, on audio and null.
    full_scale : float, optional
        Voltage of the amplifier at the sound card's full scale, for a display driven in V.

    Returns
    -------
    dict
        Samples sent and lost, see `AnalogDiscovery.facts`; or ``file`` and `Playback.facts`.

    Raises
    ------
    ParameterError
        If the display's carrier is not the device's, or the file is not a drive of it.
    MissingExtraError, DeviceError
        If the library, driver or device is missing.
    """
    from tactogram.rendering import carrier_of, open_display, safe
    from tactogram.signal.io import read_signal
    from tactogram_playback.transducer.digilent import AnalogDiscovery, generator
    from tactogram_playback.workflows.playback import Playback, play_to_end

    kind, _, serial = device.partition(":")
    if kind in ("audio", "null"):
        drive, known = read_signal(Path(file)), open_display(display)
        playing = Playback(
            drive, known, device=device, strength=strength, loop_s=loop_s, full_scale=full_scale
        )
        return {"file": str(file), **play_to_end(playing)}
    if kind != "digilent":
        raise ParameterError.must("device", "be null, audio, audio:NAME, digilent or digilent:SERIAL", device)
    known = open_display(display)
    try:
        settings = carrier_of(known)
    except ParameterError as error:
        raise ParameterError(error, remedy=Remedy("for a sound card give", "device", "audio")) from None
    drive = read_signal(Path(file))
    if drive.unit != known.unit or len(drive.axes) != 1 or drive.domain != "time":
        raise ParameterError(
            file,
            f"is not a drive of {known.name}: expected one axis over time in {known.unit}, got "
            f"{len(drive.axes)} over {drive.domain} in {drive.unit}",
        )
    highest = float(drive.samples.max())
    if highest > known.limit * (1 + 1e-4) or drive.samples.min() < -1e-4 * known.limit:
        raise ParameterError(
            file,
            f"goes from {drive.samples.min():.4g} to {highest:.4g} V, outside of 0 to {known.limit:g} V of "
            f"{known.name}",
            remedy="render it for this display",
        )
    drive = drive.with_samples(drive.samples.clip(0, known.limit))
    ends = float(max(drive.samples[0, 0], drive.samples[0, -1]))
    if loop_s is None and ends > 0.01 * known.limit:
        drive, _ = safe(drive.with_samples(drive.samples, axes=known.channels), known.of(rate=drive.rate))
    with (opened or AnalogDiscovery)(generator(settings, channel=channel, serial=serial)) as output:
        if loop_s is None:
            output.play(drive)
        else:
            output.loop(drive, loop_s)
        return output.facts()
