"""A carrier that is kept at a simulated transducer's resonance while a generator plays."""

import numpy as np
import pytest
from scipy import signal as dsp

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram_playback.transducer.circuit import PRESETS
from tactogram_playback.transducer.simulation import BenchSettings, SimulatedGenerator
from tactogram_playback.workflows.carrier_tracking import CarrierTracking

DISPLAY = open_display("ultrasonic-envelope")


class Texture:
    """Envelopes of noise around 140 Hz at full depth, as of a rough surface, in blocks of 5 ms."""

    def __init__(self, seed=0):
        self._rng, self._state = np.random.default_rng(seed), np.zeros(2)

    def block(self):
        white = self._rng.standard_normal(80)
        x, self._state = dsp.lfilter([0.02], [1, -1.96, 0.9634], white, zi=self._state)
        return DISPLAY.limit / 2 * (1 + np.clip(x, -1, 1))


@pytest.mark.parametrize("preset", ["plate", "finger"])
def test_the_carrier_follows_the_resonance_while_a_texture_plays(preset):
    """A drift of 10 Hz/s for five seconds, measured every 0.25 s on the modulated carrier."""
    texture, away = Texture(), []
    simulated = SimulatedGenerator(
        BenchSettings(drift_hz_per_s=10.0),
        gain=DISPLAY.settings.amplifier_gain,
        transducer=PRESETS[preset],
        rng=np.random.default_rng(0),
        waits=False,
    )
    tracking = CarrierTracking(DISPLAY.settings, {}, simulated=simulated)
    with tracking.generator() as device:
        device.start(DISPLAY.rate)
        begun_hz = device.transducer.resonance_hz
        for _ in range(20):
            for _ in range(50):
                device.advance(texture.block())
            tracking.step(device)
            away.append(device.carrier_hz - device.transducer.resonance_hz)
        assert device.transducer.resonance_hz - begun_hz == pytest.approx(50, abs=1)
    # The lock's sweep took six seconds of the drift; steps of at most 5 Hz catch up, and lag by one step's drift.
    assert np.abs(away[-8:]).max() < 4
    facts = tracking.facts()
    assert (facts["steps"], facts["skipped"], facts["error"]) == (20, 0, None)
    assert facts["carrier_hz"] - facts["locked_hz"] > 50


def test_at_rest_nothing_is_measured_and_the_carrier_stays():
    tracking = CarrierTracking(DISPLAY.settings, {}, serial="simulated")
    tracking._simulated._waits = False
    with tracking.generator() as device:
        before = device.carrier_hz
        device.start(DISPLAY.rate)
        for _ in range(50):
            device.advance(np.zeros(80))
        tracking.step(device)
        assert device.carrier_hz == before
    assert (tracking.facts()["steps"], tracking.skipped) == (0, 1)


def test_the_next_stream_begins_where_the_last_one_ended(tmp_path):
    log = tmp_path / "track.csv"
    tracking = CarrierTracking(DISPLAY.settings, {"log": str(log)}, serial="simulated")
    for _ in range(2):
        with tracking.generator() as device:
            assert device.carrier_hz == tracking.tracker.frequency_hz
    assert [point.state for point in tracking.tracker.log].count("lock") == 1
    assert len(log.read_text().splitlines()) == len(tracking.tracker.log) + 1


@pytest.mark.parametrize(
    ("display", "changes", "says"),
    [
        ("ultrasonic", {}, "output = 'envelope'"),
        ("electrovibration", {}, "a display with a resonance"),
        ("ultrasonic-envelope", {}, "amps_per_volt must be known"),
        ("ultrasonic-envelope", {"every": 1}, "every"),
    ],
)
def test_what_cannot_be_tracked_is_refused(display, changes, says):
    with pytest.raises(ParameterError, match=says):
        CarrierTracking(open_display(display).settings, changes)
