"""Resonance tracking of a transducer: generator, converter and tracker together."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

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
from tactogram.workflows.rendering.requests import TrackRequest
from tactogram.workflows.request import takes

BAND = 0.03
"""Share of the carrier below and above it that is searched by default."""


@takes(TrackRequest)
def track(request: TrackRequest) -> dict[str, Any]:
    """Find a transducer's resonance, and keep the carrier at it.

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
    display, out = request.display, request.out
    if out is not None:
        if Path(out).suffix.lower() != ".csv":
            raise ParameterError(f"{out}: a log's suffix must be .csv, got {Path(out).suffix!r}")
        check_writable(Path(out))
    known = open_display(display).settings
    if not isinstance(known, CarrierSettings) or not known.resonant or known.output != "envelope":
        raise ParameterError(
            f"{display}: its generator must make the carrier: choose a display with a resonance and output = 'envelope'"
        )
    tables = tables_of(request.changes or {})
    low, high = known.carrier_hz * (1 - BAND), known.carrier_hz * (1 + BAND)
    tracking = validated(TrackingSettings, {"low_hz": low, "high_hz": high, **tables[""]}, where="tracking")
    timing = validated(MeasurementTiming, tables["timing"], where="timing")
    bench = validated(BenchSettings, tables["bench"], where="bench")
    simulated = request.generator == "simulated"
    amps_per_volt, skew_s = request.amps_per_volt, request.skew_s
    if amps_per_volt is None:
        if not simulated:
            raise ParameterError("amps_per_volt must be known: 1 over the resistance of the shunt, in ohm")
        amps_per_volt, skew_s = 1 / bench.shunt_ohm, skew_s or bench.skew_s
    factors = {"amps_per_volt": amps_per_volt, "volts_per_volt": request.volts_per_volt, "skew_s": skew_s}
    probes = validated(ProbeSettings, factors, where="probes")
    with ExitStack() as stack:
        carrier: Carrier
        recorder: Recorder
        if simulated:
            carrier = recorder = SimulatedBench(bench, rng=np.random.default_rng(request.seed))
        else:
            inputs = validated(ScopeSettings, tables["scope"], where="scope")
            serial = request.generator.partition(":")[2]
            opened = request.opened or AnalogDiscovery
            device = stack.enter_context(opened(generator(known, channel=request.channel, serial=serial)))
            recorder = DigilentRecorder(*device.opened_device, inputs, name=device.name)
            device.hold(request.share * known.peak_v, longest_s=_longest_s(request, tracking, timing))
            carrier = device
        measure = MeasuredAdmittance(carrier, recorder, probes, timing)
        tracker = ResonanceTracker(measure, tracking)
        try:
            interrupted = _followed(tracker, request)
        finally:
            if out is not None and tracker.log:
                tracker.write_log(out)
    return _result(tracker, measure, interrupted, simulated) | ({"file": str(out)} if out is not None else {})


def _followed(tracker: ResonanceTracker, request: TrackRequest) -> bool:
    """Lock and follow; return whether the keyboard ended it."""
    status = request.status
    try:
        point = tracker.lock()
        if status is not None:
            status(f"locked at {point.next_hz:.1f} Hz")
        for step in range(request.steps):
            point = tracker.step()
            if status is not None:
                status(
                    f"{step + 1:6} of {request.steps}  {point.state:6}  {point.next_hz:9.1f} Hz  "
                    f"{1e3 * point.conductance_s:.3f} mS"
                )
            if request.every_s:
                time.sleep(request.every_s)
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


def _longest_s(request: TrackRequest, tracking: TrackingSettings, timing: MeasurementTiming) -> float:
    """Return when a device may stop by itself: after twice the time of all steps and two more sweeps."""
    each = timing.settle_s + timing.window_s + 0.05
    measured = 3 * (tracking.sweep_points + 1) + 2 * request.steps
    return 10 + 2 * (measured * each + request.steps * request.every_s)


def tables_of(changes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return changes by table, the prefix of their keys; those of tracking have none."""
    tables: dict[str, dict[str, Any]] = {"": {}, "timing": {}, "bench": {}, "scope": {}}
    for key, value in changes.items():
        table, dot, name = key.partition(".")
        if dot and table not in tables:
            raise ParameterError(f"{key}: must be a key of tracking, or begin with timing., scope. or bench.")
        tables[table if dot else ""][name if dot else key] = value
    return tables
