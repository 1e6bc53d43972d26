"""Admittance of a transducer from samples of voltage and current, on a simulated bench."""

import numpy as np
import pytest

from tactogram.errors import DeviceError, ParameterError
from tactogram_playback.transducer.admittance import (
    MeasuredAdmittance,
    MeasurementTiming,
    ProbeSettings,
    lock_in,
)
from tactogram_playback.transducer.circuit import Transducer
from tactogram_playback.transducer.resonance_tracking import ResonanceTracker, TrackingSettings
from tactogram_playback.transducer.simulation import BenchSettings, SimulatedBench


def bench(*, transducer=None, seed=0, **values):
    return SimulatedBench(BenchSettings(**values), transducer=transducer, rng=np.random.default_rng(seed))


def measuring(on, *, skew_s=0.0, **timing):
    return MeasuredAdmittance(
        on, on, ProbeSettings(amps_per_volt=1 / 10, skew_s=skew_s), MeasurementTiming(**timing)
    )


@pytest.mark.parametrize("away_hz", [-300, -47, 0, 47, 300])
def test_what_is_measured_is_the_circuits_admittance(away_hz):
    on = bench()
    frequency = on.transducer.resonance_hz + away_hz
    wanted = complex(on.transducer.admittance(frequency))
    assert abs(measuring(on)(frequency) / wanted - 1) < 0.01


def test_a_current_that_is_taken_later_is_turned_back():
    on = bench(skew_s=4e-6)  # a multiplexed converter at 250,000 samples/s: 41 degrees
    frequency = on.transducer.resonance_hz
    wanted = complex(on.transducer.admittance(frequency))
    assert abs(measuring(on, skew_s=4e-6)(frequency) / wanted - 1) < 0.01
    assert np.degrees(np.angle(measuring(on)(frequency) / wanted)) == pytest.approx(40.6, abs=1)


def test_too_short_a_wait_measures_the_last_frequency_too():
    on = bench(transducer=Transducer(q=800))
    at, far = on.transducer.resonance_hz, on.transducer.resonance_hz + 500
    wanted = complex(on.transducer.admittance(far))
    measuring(on)(at)
    assert abs(measuring(on, settle_s=0.0, window_s=0.005)(far) / wanted - 1) > 0.3
    measuring(on)(at)
    assert abs(measuring(on)(far) / wanted - 1) < 0.05


@pytest.mark.parametrize("seed", range(3))
def test_the_loop_closed_over_converter_and_shunt_follows_a_drift(seed):
    on = bench(drift_hz_per_s=5.0, seed=seed)
    tracker = ResonanceTracker(measuring(on), TrackingSettings())
    tracker.lock()
    away = []
    for _ in range(40):
        tracker.step()
        away.append(tracker.frequency_hz - on.transducer.resonance_hz)
    moved = on.transducer.resonance_hz - 28_200
    assert moved > 30
    # The carrier is where the resonance was one step, 0.35 Hz, and the lag of half a step's gain ago.
    assert np.abs(away[10:]).max() < 1.5


class Recorded:
    """A converter that returns given samples."""

    name, rate, full_scale = "recorded", 250_000.0, (1.0, 1.0)

    def __init__(self, *takes):
        self.takes, self.tuned = list(takes), []

    def retune(self, carrier_hz):
        self.tuned.append(carrier_hz)

    def take(self, seconds, *, after_s):
        x = self.takes.pop(0)
        t = np.arange(round(seconds * self.rate)) / self.rate
        return x * np.sin(2 * np.pi * 28_000 * t), 0.5 * np.sin(2 * np.pi * 28_000 * t)


def test_lost_samples_are_measured_again_and_then_are_no_number():
    on = Recorded(np.nan, 0.5, np.nan, np.nan, np.nan)
    measure = measuring(on)
    assert measure(28_000) == pytest.approx(0.1)
    assert np.isnan(measure(28_000).real)
    assert (measure.measured, measure.repeated, on.tuned) == (1, 4, [28_000, 28_000])


def test_what_cannot_be_measured_is_one_line():
    with pytest.raises(DeviceError, match="voltage reaches its full scale of 1 V"):
        measuring(Recorded(1.0))(28_000)
    with pytest.raises(DeviceError, match="check the amplifier"):
        measuring(Recorded(0.0))(28_000)
    with pytest.raises(
        ParameterError, match="10000 samples/s are too few; a carrier of 28000 Hz needs 61600"
    ):
        measuring(bench(rate=10_000))(28_000)


def test_a_lock_in_measures_the_admittance_of_samples():
    rate, f, y = 1_000_000, 28_200, 0.01 - 0.002j
    t = np.arange(5000) / rate
    v, i = np.cos(2 * np.pi * f * t), np.real(y * np.exp(2j * np.pi * f * t))
    assert lock_in(v, i, rate=rate, frequency_hz=f) == pytest.approx(y, rel=1e-4)
    with pytest.raises(ParameterError, match="no voltage at 28200 Hz"):
        lock_in(np.zeros(5000), i, rate=rate, frequency_hz=f)
