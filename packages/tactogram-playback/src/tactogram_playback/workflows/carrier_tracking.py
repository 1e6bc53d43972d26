"""Tracking of a carrier: generator, converter and tracker together, alone or while a generator plays."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from tactogram.errors import DeviceError, ParameterError, TactogramError
from tactogram.rendering import CarrierSettings
from tactogram.signal.io import check_writable
from tactogram.validation import FrozenModel, validated
from tactogram_playback.transducer.admittance import (
    DigilentRecorder,
    MeasuredAdmittance,
    MeasurementTiming,
    NoVoltageError,
    ProbeSettings,
    Recorder,
    ScopeSettings,
)
from tactogram_playback.transducer.digilent import AnalogDiscovery, generator
from tactogram_playback.transducer.resonance_tracking import ResonanceTracker, TrackingSettings
from tactogram_playback.transducer.simulation import BenchSettings, SimulatedGenerator

SIMULATED = "simulated"
"""Name of the generator that is simulated, with its transducer and its converter."""
BAND = 0.03
"""Share of the carrier below and above it that is searched by default."""
MOST_HZ = 5.0
"""Longest step while somebody feels it, Hz: at Q 300 it changes the amplitude by less than 1 %."""
LEAST_SHARE = 0.05
"""Share of the largest voltage below which nothing is measured: the display is at rest."""
NEVER_LOST = 1e-9
"""No new sweep while somebody feels it, however low the conductance."""
ENDING_S = 5.0
"""Wait for the last measurement, s."""


class FollowingSettings(FrozenModel):
    """Probes, converter and pace of the tracking while something is played."""

    amps_per_volt: float | None = Field(default=None, gt=0)
    """1 over the resistance of the shunt in ohm; known of the simulated generator."""
    volts_per_volt: float = Field(default=1.0, gt=0)
    skew_s: float = 0.0
    share: float = Field(default=0.25, gt=0, le=1)
    """Of the largest voltage, for the lock."""
    every_s: float = Field(default=0.25, ge=0.05, le=3600)
    """From step to step."""
    log: Path | None = None
    """CSV file of all measurements."""


class CarrierTracking:
    """Carrier of one display, kept at its transducer's resonance from one stream to the next.

    ``changes`` are values of `FollowingSettings`, `TrackingSettings`, `MeasurementTiming` (``timing.settle_s``),
    `ScopeSettings` (``scope.rate``) and of the simulated `BenchSettings` (``bench.drift_hz_per_s``), by key. A
    ``simulated`` generator replaces the device of ``serial``, which ``opened`` opens; ``seed`` is that of its noise. Of
    a display that is ``felt`` meanwhile, steps are short, and nothing is swept again or measured without voltage.

    Raises `ParameterError` if the display has no resonance, its generator does not make the carrier, or a value is
    wrong.
    """

    def __init__(
        self,
        known: CarrierSettings,
        changes: Mapping[str, Any],
        *,
        serial: str = "",
        channel: int = 1,
        opened: Callable[..., AnalogDiscovery] = AnalogDiscovery,
        simulated: SimulatedGenerator | None = None,
        seed: int = 0,
        felt: bool = True,
    ) -> None:
        if not known.resonant or known.output != "envelope":
            raise ParameterError(
                "tracking needs a generator that makes the carrier: choose a display with a resonance and "
                "output = 'envelope'"
            )
        own = {key: value for key, value in changes.items() if key in FollowingSettings.model_fields}
        tables = tables_of({key: value for key, value in changes.items() if key not in own})
        self.settings = validated(FollowingSettings, own, where="tracking")
        low, high = known.carrier_hz * (1 - BAND), known.carrier_hz * (1 + BAND)
        careful = {"most_hz": MOST_HZ, "lost_share": NEVER_LOST} if felt else {}
        values = {"low_hz": low, "high_hz": high, **careful, **tables[""]}
        tracking = validated(TrackingSettings, values, where="tracking")
        self._timing = validated(MeasurementTiming, tables["timing"], where="timing")
        self._scope = validated(ScopeSettings, tables["scope"], where="scope")
        bench = validated(BenchSettings, tables["bench"], where="bench")
        self._known, self._opened = known, opened
        self._generator = generator(known, channel=channel, serial=serial)
        self._simulated = simulated
        if serial == SIMULATED and simulated is None:
            self._simulated = SimulatedGenerator(
                bench, gain=known.amplifier_gain, rng=np.random.default_rng(seed)
            )
        amps, skew_s = self.settings.amps_per_volt, self.settings.skew_s
        if self._simulated is not None and amps is None:
            amps, skew_s = 1 / self._simulated.settings.shunt_ohm, skew_s or self._simulated.settings.skew_s
        if amps is None:
            raise ParameterError.must("amps_per_volt", "be known: 1 over the resistance of the shunt, in ohm")
        if self.settings.log is not None:
            check_writable(self.settings.log)
        factors = {"amps_per_volt": amps, "volts_per_volt": self.settings.volts_per_volt, "skew_s": skew_s}
        self._probes = validated(ProbeSettings, factors, where="probes")
        self._least_v = LEAST_SHARE * known.peak_v * known.amplifier_gain if felt else 0.0
        self.tracker = ResonanceTracker(self._measured, tracking)
        self.measure: MeasuredAdmittance | None = None
        """Of the generator that was opened last."""
        self.skipped = 0
        """Steps without enough voltage to measure: the display was at rest."""
        self.error: str | None = None
        """Why the tracking ended while it played; the carrier stays where it was."""

    @contextmanager
    def generator(self, *, longest_s: float = 0.0) -> Iterator[AnalogDiscovery | SimulatedGenerator]:
        """Open the generator at the tracked frequency; the first time it locks before anything is played.

        From then on it holds the carrier for ``longest_s`` at most.

        Raises `TrackingError`, `DeviceError` or `MissingExtraError` if there is no resonance, or a device fails or is
        missing; the log is written all the same.
        """
        with ExitStack() as stack:
            device: AnalogDiscovery | SimulatedGenerator
            recorder: Recorder
            if self._simulated is not None:
                device = recorder = stack.enter_context(self._simulated)
            else:
                device = stack.enter_context(self._opened(self._generator))
                recorder = DigilentRecorder(*device.opened_device, self._scope, name=device.name)
            self.measure = MeasuredAdmittance(
                device, recorder, self._probes, self._timing, least_v=self._least_v
            )
            try:
                if self.tracker.fitted is None:
                    volts = self.settings.share * self._known.peak_v
                    locking_s = 10 + 6 * (self.tracker.settings.sweep_points + 1) * self.each_s
                    device.hold(volts, longest_s=locking_s + longest_s)
                    self.tracker.lock()
                device.retune(self.tracker.frequency_hz)
                yield device
            finally:
                if self.settings.log is not None and self.tracker.log:
                    self.tracker.write_log(self.settings.log)

    @contextmanager
    def following(self, device: AnalogDiscovery | SimulatedGenerator) -> Iterator[None]:
        """Take a step every ``every_s`` in a thread, while the open generator plays."""
        ended = threading.Event()

        def follow() -> None:
            while not ended.wait(self.settings.every_s):
                try:
                    self.step(device)
                except TactogramError as error:
                    self.error = str(error)
                    return

        thread = threading.Thread(target=follow, name="tracking", daemon=True)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join(ENDING_S)

    def step(self, device: AnalogDiscovery | SimulatedGenerator) -> None:
        """Measure once and move the carrier; of a display at rest, without voltage, nothing is measured."""
        try:
            self.tracker.step()
        except NoVoltageError:
            if not self._least_v:
                raise
            self.skipped += 1
            return
        device.retune(self.tracker.frequency_hz)

    def facts(self) -> dict[str, Any]:
        """Return where the carrier was and is, and how often it was measured, as JSON values."""
        followed = [point for point in self.tracker.log if point.state in ("lock", "track", "frozen")]
        visited = [point.next_hz for point in followed]
        fitted = self.tracker.fitted
        return {
            "locked_hz": visited[0] if visited else None,
            "carrier_hz": None if math.isnan(self.tracker.frequency_hz) else self.tracker.frequency_hz,
            "lowest_hz": min(visited, default=None),
            "highest_hz": max(visited, default=None),
            "q": None if fitted is None else fitted.q,
            "steps": sum(point.state != "lock" for point in followed),
            "locks": sum(point.state == "lock" for point in followed),
            "skipped": self.skipped,
            "error": self.error,
        }

    @property
    def each_s(self) -> float:
        """Longest usual time of a measurement, s."""
        return self._timing.settle_s + self._timing.window_s + 0.05

    def _measured(self, frequency: float) -> complex:
        if self.measure is None:
            raise DeviceError("the generator is not open")
        return self.measure(frequency)


def tables_of(changes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return changes by table, the prefix of their keys; those of tracking have none."""
    tables: dict[str, dict[str, Any]] = {"": {}, "timing": {}, "bench": {}, "scope": {}}
    for key, value in changes.items():
        table, dot, name = key.partition(".")
        if dot and table not in tables:
            raise ParameterError(key, "must be a key of tracking, or begin with timing., scope. or bench.")
        tables[table if dot else ""][name if dot else key] = value
    return tables
