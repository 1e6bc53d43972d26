"""Resonance tracking of a transducer: a lock, steps, and the settings found for its display."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.rendering.displays.carrier import CarrierSettings
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.transducer.digilent import AnalogDiscovery
from tactogram.workflows.rendering.carrier_tracking import SIMULATED, CarrierTracking
from tactogram.workflows.rendering.requests import TrackRequest
from tactogram.workflows.request import takes


@takes(TrackRequest)
def track(request: TrackRequest) -> dict[str, Any]:
    """Find a transducer's resonance, and keep the carrier at it.

    Keys of the result: ``resonance_hz``, ``q``, ``r1_ohm``, ``c0_farad`` (of the last lock's sweep), ``carrier_hz`` (at
    the end), ``lowest_hz``, ``highest_hz``, ``measured``, ``repeated`` (measurements with lost samples), ``lost``
    (those repeated in vain), ``steps``, ``locks`` (more than one: the resonance was lost and found again),
    ``interrupted``, ``simulated``, ``settings`` for the display, ``file``.

    Raises `ParameterError` if the display or the changes do not fit; `TrackingError`, `DeviceError` or
    `MissingExtraError` if there is no resonance, or a device fails; it is at 0 V then, and the log is written all the
    same.
    """
    out, status = request.out, request.status
    if out is not None and Path(out).suffix.lower() != ".csv":
        raise ParameterError(f"{out}: a log's suffix must be .csv, got {Path(out).suffix!r}")
    known = open_display(request.display).settings
    if not isinstance(known, CarrierSettings):
        raise ParameterError(f"{request.display}: has no carrier; choose a display with a resonance")
    probes = {name: getattr(request, name) for name in ("volts_per_volt", "skew_s", "share")}
    given = {"amps_per_volt": request.amps_per_volt, "log": out}
    simulated = request.generator == SIMULATED
    tracking = CarrierTracking(
        known,
        {
            **probes,
            **{name: value for name, value in given.items() if value is not None},
            **(request.changes or {}),
        },
        serial=SIMULATED if simulated else request.generator.partition(":")[2],
        channel=request.channel,
        opened=request.opened or AnalogDiscovery,
        seed=request.seed,
        felt=False,
    )
    interrupted = False
    # Twice the time of all steps: the device then stops by itself.
    longest_s = 2 * request.steps * (2 * tracking.each_s + request.every_s)
    try:
        with tracking.generator(longest_s=longest_s) as device:
            if status is not None:
                status(f"locked at {tracking.tracker.frequency_hz:.1f} Hz")
            for step in range(request.steps):
                tracking.step(device)
                point = tracking.tracker.log[-1]
                if status is not None:
                    status(
                        f"{step + 1:6} of {request.steps}  {point.state:6}  {point.next_hz:9.1f} Hz  "
                        f"{1e3 * point.conductance_s:.3f} mS"
                    )
                if request.every_s:
                    time.sleep(request.every_s)
    except KeyboardInterrupt:
        interrupted = True
    result = _result(tracking, interrupted=interrupted, simulated=simulated)
    return result | ({"file": str(out)} if out is not None else {})


def _result(tracking: CarrierTracking, *, interrupted: bool, simulated: bool) -> dict[str, Any]:
    tracker, measure = tracking.tracker, tracking.measure
    found, followed = tracker.fitted, [p for p in tracker.log if p.state in ("lock", "track", "frozen")]
    facts: dict[str, Any] = {
        **{name: getattr(measure, name, 0) for name in ("measured", "repeated", "lost")},
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
