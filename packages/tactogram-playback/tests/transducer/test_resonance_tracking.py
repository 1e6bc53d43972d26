import csv
from functools import cache

import numpy as np
import pytest
from benchmarks.experiments.simulated_transducer import (
    DriftingTransducer,
    SimulatedAdmittance,
    SimulatedTouch,
    track,
)
from pydantic import ValidationError

from tactogram_playback.transducer.circuit import PRESETS
from tactogram_playback.transducer.resonance_tracking import (
    ResonanceTracker,
    TrackingError,
    TrackingSettings,
)
from tactogram_playback.transducer.simulation import TransducerSimulation

METHODS = ["climb_admittance", "dither_admittance", "dither_conductance", "motional_phase"]
DRIFTING = DriftingTransducer(PRESETS["plate"])


class SettlingAdmittance(SimulatedAdmittance):
    """Lets the carrier ring in at each frequency for 50 ms before it measures."""

    def __init__(self, drifting, *, noise, rng):
        super().__init__(drifting, noise=noise, rng=rng)
        self._simulation = TransducerSimulation(drifting.at(0), rate=4000, carrier_hz=28_200)

    def __call__(self, frequency):
        self._simulation.change(transducer=self.transducer, carrier_hz=frequency)
        _, current = self._simulation.process(np.ones(200))
        wrong = self._rng.standard_normal(2) * self.noise
        return complex(current[-50:].mean()) * complex(1 + wrong[0], wrong[1])


def measured(drifting=DRIFTING, *, noise=0.01, seed=0):
    return SimulatedAdmittance(drifting, noise=noise, rng=np.random.default_rng(seed))


@cache
def through_the_drift(method, name="plate"):
    return track(measured(DriftingTransducer(PRESETS[name])), TrackingSettings(method=method), steps=300)


@pytest.mark.parametrize("name", ["free", "plate", "finger", "damped"])
def test_a_lock_is_at_the_resonance(name):
    tracker = ResonanceTracker(measured(DriftingTransducer(PRESETS[name])))
    assert tracker.lock().next_hz == pytest.approx(28_200, abs=0.02 * 28_200 / PRESETS[name].q + 1)
    assert tracker.fitted.q == pytest.approx(PRESETS[name].q, rel=0.05)
    assert [point.state for point in tracker.log].count("sweep") == 81


@pytest.mark.parametrize(
    ("method", "mean", "most"),
    [
        ("climb_admittance", -3.2, 25),
        ("dither_admittance", -3.4, 11),
        ("dither_conductance", -0.27, 4),
        ("motional_phase", -0.27, 1.5),
    ],
)
def test_a_drift_of_80_hz_is_followed(method, mean, most):
    summary = through_the_drift(method).summary()
    assert summary["mean_hz"] == pytest.approx(mean, abs=3 if method == "climb_admittance" else 0.6)
    assert summary["max_hz"] < most
    assert through_the_drift(method).carrier_hz[-1] == pytest.approx(28_280, abs=most)


def test_the_largest_admittance_lies_below_the_resonance_and_the_phase_does_not():
    """Hatori & Takemura 2023, Sec. III-C: "adjusting the driving frequency until the admittance … was maximized"."""
    by_admittance = through_the_drift("dither_admittance", "finger").summary()["mean_hz"]
    by_phase = through_the_drift("motional_phase", "finger").summary()["mean_hz"]
    assert by_admittance == pytest.approx(-27.3, abs=3)
    assert by_phase == pytest.approx(0, abs=1)


@pytest.mark.parametrize("method", METHODS)
def test_a_touch_does_not_lose_it(method):
    touched = DriftingTransducer(PRESETS["plate"], touches=[SimulatedTouch(100, 200)])
    result = track(measured(touched), TrackingSettings(method=method), steps=300)
    states = {point.state for point in result.tracker.log}
    bias = {"climb_admittance": 70, "dither_admittance": 45}.get(method, 8)
    assert "lost" not in states
    assert np.abs(result.errors_hz[150:200]).max() < bias
    assert np.abs(result.errors_hz[250:]).max() < (30 if method == "climb_admittance" else 10)


def test_a_frozen_carrier_stays_and_the_log_goes_on():
    result = track(measured(), TrackingSettings(), steps=200, frozen=range(50, 150))
    held = result.carrier_hz[50:150]
    assert len(set(held)) == 1
    assert [point.state for point in result.tracker.log].count("frozen") == 100
    assert abs(result.errors_hz[149]) > 20
    assert abs(result.errors_hz[199]) < 2


def test_a_carrier_that_must_ring_in_is_followed_too():
    slow = SettlingAdmittance(DRIFTING, noise=0.01, rng=np.random.default_rng(0))
    assert track(slow, TrackingSettings(), steps=300).summary()["max_hz"] < 1.5


def test_a_jump_is_lost_and_found_again():
    far = DriftingTransducer(PRESETS["free"], drift_hz=400, steps=1)
    result = track(measured(far), TrackingSettings(), steps=20)
    assert "lost" in {point.state for point in result.tracker.log}
    assert abs(result.errors_hz[-1]) < 2


def test_a_jump_is_found_again_after_a_lock_that_was_no_number():
    count, true = 0, PRESETS["free"]

    def measure(frequency):
        nonlocal count, true
        count += 1
        if count == 82:
            true = true.shifted(400.0)
            return complex("nan")
        return true.admittance(frequency)

    tracker = ResonanceTracker(measure)
    tracker.lock()
    [tracker.step() for _ in range(4)]
    assert tracker.frequency_hz == pytest.approx(28_600, abs=2)


def test_nothing_to_lock_on_is_said():
    with pytest.raises(TrackingError, match="no lock"):
        ResonanceTracker(lambda f: 2j * np.pi * f * 3.8e-9).lock()
    with pytest.raises(TrackingError, match=r"call lock\(\) first"):
        ResonanceTracker(measured()).step()


def test_a_dead_probe_ends_the_tracking_and_one_bad_value_does_not():
    source = measured()
    broken = False
    tracker = ResonanceTracker(lambda f: complex("nan") if broken else source(f))
    tracker.lock()
    broken = True
    before = tracker.frequency_hz
    tracker.step()
    assert tracker.frequency_hz == before
    with pytest.raises(TrackingError, match="in a row failed"):
        [tracker.step() for _ in range(5)]


@pytest.mark.parametrize("name", ["free", "damped"])
@pytest.mark.parametrize("lost", [{41}, set(range(2, 82, 2))], ids=["the-one-at-resonance", "half"])
def test_a_lock_does_without_points_that_were_lost(name, lost):
    source, count = measured(DriftingTransducer(PRESETS[name])), 0

    def measure(frequency):
        nonlocal count
        count += 1
        return complex("nan") if count in lost else source(frequency)

    tracker = ResonanceTracker(measure)
    assert tracker.lock().next_hz == pytest.approx(28_200, abs=0.02 * 28_200 / PRESETS[name].q)
    assert tracker.fitted.q == pytest.approx(PRESETS[name].q, rel=0.05)
    assert sum(np.isnan(point.admittance) for point in tracker.log) == len(lost)


def test_a_lock_says_at_once_that_nothing_is_measured_and_in_the_end_that_too_much_was_lost():
    dead = ResonanceTracker(lambda frequency: complex("nan"))
    with pytest.raises(TrackingError, match="no lock: 5 measurements in a row failed: check the probe"):
        dead.lock()
    assert len(dead.log) == 5
    source, count = measured(), 0

    def two_of_three_lost(frequency):
        nonlocal count
        count += 1
        return complex("nan") if count % 3 else source(frequency)

    with pytest.raises(
        TrackingError, match="no lock: 54 of the sweep's 81 measurements were lost: check the probe"
    ):
        ResonanceTracker(two_of_three_lost).lock()


def test_the_frequency_never_leaves_its_band():
    away = DriftingTransducer(PRESETS["plate"], drift_hz=300)
    band = TrackingSettings(low_hz=28_000, high_hz=28_300, sweep_points=60)
    result = track(measured(away), band, steps=250)
    assert max(result.carrier_hz) <= 28_300


def test_the_log_is_a_table_with_a_line_per_measurement(tmp_path):
    tracker = ResonanceTracker(measured())
    tracker.lock()
    tracker.step()
    with tracker.write_log(tmp_path / "log.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 83
    assert rows[-1]["state"] == "track"
    assert float(rows[-1]["next_hz"]) == tracker.frequency_hz
    assert (
        complex(float(rows[0]["conductance_s"]), float(rows[0]["susceptance_s"])) == tracker.log[0].admittance
    )


def test_a_band_upside_down_is_refused():
    with pytest.raises(ValidationError, match="low_hz must be below"):
        TrackingSettings(low_hz=29_000, high_hz=28_000)
