"""Resonance tracking of a transducer: generator, converter and tracker together."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.capture.catalogue import open_source
from tactogram.capture.stream.axis_pair import PairRecorder
from tactogram.errors import ParameterError
from tactogram.rendering.displays.carrier import CarrierSettings
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.transducer.admittance import (
    Carrier,
    MeasuredAdmittance,
    MeasurementTiming,
    ProbeSettings,
    Recorder,
)
from tactogram.rendering.transducer.digilent import AnalogDiscovery, generator
from tactogram.rendering.transducer.digilent_scope import DigilentRecorder, ScopeSettings
from tactogram.rendering.transducer.resonance_tracking import ResonanceTracker, TrackingSettings
from tactogram.rendering.transducer.simulation import BenchSettings, SimulatedBench
from tactogram.signal.io.writable import check_writable
from tactogram.validation import validated

BAND = 0.03
"""Share of the carrier below and above which it is looked for, unless asked otherwise."""

StatusCallback = Callable[[str], None]


@dataclass(frozen=True)
class TrackSettings:
    """Settings of resonance tracking.

    Parameters
    ----------
    generator : str
        ``digilent``, ``digilent:SERIAL``, or ``simulated``: a bench, generator and converter in one.
    source : str, optional
        Of voltage and current: an address of `tactogram.capture.catalogue`, or ``scope``, the generator's own inputs.
    steps : int
        After the lock.
    every_s : float
        From one step to the next; 0 is as quickly as it can be measured.
    share : float
        Of the largest voltage that the display allows: what the transducer is measured at.
    channel : int
        Of the generator, from 1.
    seed : int
        Of the simulated bench's noise.
    """

    generator: str = "simulated"
    source: str = "scope"
    steps: int = 100
    every_s: float = 0.0
    share: float = 0.25
    channel: int = 1
    seed: int = 0

    def __post_init__(self) -> None:
        if self.generator.partition(":")[0] not in ("digilent", "simulated"):
            raise ParameterError(
                f"generator must be digilent, digilent:SERIAL or simulated, got {self.generator!r}"
            )
        if self.generator == "simulated" and self.source != "scope":
            raise ParameterError("the simulated generator has its own converter: leave out --source")
        if not 0 < self.share <= 1:
            raise ParameterError(f"share must be > 0 and at most 1, got {self.share:g}")
        if not (1 <= self.steps <= 1_000_000 and 0 <= self.every_s <= 3600):
            raise ParameterError(
                f"steps must be 1 to a million, every 0 to 3600 s, got {self.steps} and {self.every_s:g}"
            )
        if self.seed < 0:
            raise ParameterError(f"seed must be >= 0, got {self.seed}")


def track(
    display: str,
    settings: TrackSettings | None = None,
    *,
    amps_per_volt: float | None = None,
    volts_per_volt: float = 1.0,
    skew_s: float = 0.0,
    axes: tuple[str, str] | None = None,
    changes: Mapping[str, Any] | None = None,
    out: Path | str | None = None,
    status: StatusCallback | None = None,
    opened: Callable[..., AnalogDiscovery] = AnalogDiscovery,
) -> dict[str, Any]:
    """Look for a transducer's resonance, and keep the carrier at it.

    Parameters
    ----------
    display : str
        Ultrasonic, its output an envelope: its carrier and its limits are used.
    settings : TrackSettings, optional
    amps_per_volt, volts_per_volt, skew_s
        See `tactogram.rendering.transducer.admittance.ProbeSettings`; the first must be known of a real bench.
    axes : tuple of str, optional
        Voltage and current among the source's axes; by default its first two.
    changes : mapping, optional
        Values of `TrackingSettings`, `MeasurementTiming` (``timing.settle_s``), `ScopeSettings` (``scope.rate``) and
        of the
        simulated `BenchSettings` (``bench.drift_hz_per_s``), by key.
    out : Path, optional
        Log of everything measured, as CSV; `tactogram transducer` reads its sweep.
    status : callable, optional
        Told a line now and then.
    opened : callable
        What opens the device; in tests.

    Returns
    -------
    dict
        ``resonance_hz``, ``q``, ``r1_ohm``, ``c0_farad`` (of the last lock's sweep), ``carrier_hz`` (at the end),
        ``lowest_hz``, ``highest_hz``, ``measured``, ``repeated`` (measurements with lost samples), ``lost`` (those
        that were repeated in vain), ``steps``, ``locks`` (more than one: the resonance was lost and found again),
        ``interrupted``, ``simulated``, ``settings`` for the display, ``file``.

    Raises
    ------
    ParameterError
        If something asked for does not fit.
    TrackingError, DeviceError, MissingExtraError
        If there is no resonance, or a device fails; it is at 0 V then, and the log is written all the same.
    """
    settings = settings or TrackSettings()
    if out is not None:
        if Path(out).suffix.lower() != ".csv":
            raise ParameterError(f"{out}: a log's suffix must be .csv, got {Path(out).suffix!r}")
        check_writable(Path(out))
    known = open_display(display).settings
    if not isinstance(known, CarrierSettings) or not known.resonant or known.output != "envelope":
        raise ParameterError(
            f"{display}: its generator must make the carrier: give a display with a resonance and output = 'envelope'"
        )
    tables = _tables(changes or {})
    low, high = known.carrier_hz * (1 - BAND), known.carrier_hz * (1 + BAND)
    tracking = validated(TrackingSettings, {"low_hz": low, "high_hz": high, **tables[""]}, where="tracking")
    timing = validated(MeasurementTiming, tables["timing"], where="timing")
    bench = validated(BenchSettings, tables["bench"], where="bench")
    simulated = settings.generator == "simulated"
    if amps_per_volt is None:
        if not simulated:
            raise ParameterError("--amps-per-volt must be known: 1 over the resistance of the shunt, in ohm")
        amps_per_volt, skew_s = 1 / bench.shunt_ohm, skew_s or bench.skew_s
    factors = {"amps_per_volt": amps_per_volt, "volts_per_volt": volts_per_volt, "skew_s": skew_s}
    probes = validated(ProbeSettings, factors, where="probes")
    with ExitStack() as stack:
        carrier: Carrier
        recorder: Recorder
        if simulated:
            carrier = recorder = SimulatedBench(bench, rng=np.random.default_rng(settings.seed))
        else:
            inputs = validated(ScopeSettings, tables["scope"], where="scope")
            serial = settings.generator.partition(":")[2]
            device = stack.enter_context(opened(generator(known, channel=settings.channel, serial=serial)))
            if settings.source == "scope":
                recorder = DigilentRecorder(*device.opened_device, inputs, name=device.name)
            else:
                recorder = PairRecorder(stack.enter_context(open_source(settings.source)), axes)
            device.hold(settings.share * known.peak_v, longest_s=_longest_s(settings, tracking, timing))
            carrier = device
        measure = MeasuredAdmittance(carrier, recorder, probes, timing)
        tracker = ResonanceTracker(measure, tracking)
        try:
            interrupted = _followed(tracker, settings, status)
        finally:
            if out is not None and tracker.log:
                tracker.write_log(out)
    return _result(tracker, measure, interrupted, simulated) | ({"file": str(out)} if out is not None else {})


def _followed(tracker: ResonanceTracker, settings: TrackSettings, status: StatusCallback | None) -> bool:
    """Lock and follow; return whether the keyboard ended it."""
    try:
        point = tracker.lock()
        if status is not None:
            status(f"locked at {point.next_hz:.1f} Hz")
        for step in range(settings.steps):
            point = tracker.step()
            if status is not None:
                status(
                    f"{step + 1:6} of {settings.steps}  {point.state:6}  {point.next_hz:9.1f} Hz  "
                    f"{1e3 * point.conductance_s:.3f} mS"
                )
            if settings.every_s:
                time.sleep(settings.every_s)
    except KeyboardInterrupt:
        return True
    return False


def _result(
    tracker: ResonanceTracker, measure: MeasuredAdmittance, interrupted: bool, simulated: bool
) -> dict[str, Any]:
    found, followed = tracker.fitted, [p for p in tracker.log if p.state in ("lock", "track", "frozen")]
    facts: dict[str, Any] = {
        "measured": measure.measured,
        "repeated": measure.repeated,
        "lost": measure.lost,
        "steps": sum(p.state != "lock" for p in followed),
        "locks": sum(p.state == "lock" for p in followed),
        "interrupted": interrupted,
        "simulated": simulated,
    }
    if found is None or not followed:
        return facts
    visited = [p.next_hz for p in followed]
    return facts | {
        "carrier_hz": tracker.frequency_hz,
        "lowest_hz": min(visited),
        "highest_hz": max(visited),
        "resonance_hz": found.resonance_hz,
        "q": found.q,
        "r1_ohm": found.r1_ohm,
        "c0_farad": found.c0_farad,
        "settings": {"carrier_hz": tracker.frequency_hz, "q": found.q},
    }


def _longest_s(settings: TrackSettings, tracking: TrackingSettings, timing: MeasurementTiming) -> float:
    """Return after what time a device may stop by itself: twice what all of it and two more sweeps should take."""
    each = timing.settle_s + timing.window_s + 0.05
    measured = 3 * (tracking.sweep_points + 1) + 2 * settings.steps
    return 10 + 2 * (measured * each + settings.steps * settings.every_s)


def _tables(changes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return changes by the table that their key begins with; the tracking's own have none."""
    tables: dict[str, dict[str, Any]] = {"": {}, "timing": {}, "bench": {}, "scope": {}}
    for key, value in changes.items():
        table, dot, name = key.partition(".")
        if dot and table not in tables:
            raise ParameterError(f"{key}: must be a key of tracking, or begin with timing., scope. or bench.")
        tables[table if dot else ""][name if dot else key] = value
    return tables
