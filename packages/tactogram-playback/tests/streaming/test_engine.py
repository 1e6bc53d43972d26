"""Engine: continuity, mixes of constant power, and lost connections."""

import numpy as np
import pytest
from quiet_engine import engine, peak_hz
from seams import seam_excess_db

from tactogram.errors import ParameterError
from tactogram.rendering.motion.finger_state import MixWeights, MotionSettings
from tactogram.rendering.motion.recorded_motion import SimulatedHand
from tactogram.signal import Signal
from tactogram.signal.texture_map import TextureMap
from tactogram_playback.streaming.engine import Engine
from tactogram_playback.streaming.texture_table import TextureTable
from tactogram_playback.streaming.textures import AutoregressiveTexture

RATE, MOST = 8000.0, 40


@pytest.mark.parametrize("speed", [50.0, 100.0, 240.0])
def test_pitch_and_level_are_those_of_speed_and_force(texture, script, rendered, speed):
    samples, _ = rendered(engine([texture()], script(lambda t: speed * t, lambda t: 0.6)), 6.0)
    settled = samples[0, 4000:]
    assert peak_hz(settled) == pytest.approx(2 * speed, abs=8)
    assert settled.std() == pytest.approx(1.6, rel=0.15)


def test_the_same_seed_gives_the_same_samples(texture, rendered):
    made = [rendered(engine([texture(seed=5)], SimulatedHand(1, seed=2)), 1.0)[0] for _ in range(2)]
    assert np.array_equal(*made)


def test_how_the_time_is_cut_into_blocks_does_not_show(texture, rendered):
    """Under the strokes, rests and lifts of a hand, jumps at the seams are no larger than at any other place."""
    samples, _ = rendered(engine([texture()], SimulatedHand(10, seed=1)), 10.0)
    found = Signal(samples, RATE, "m/s^2")
    excess = [seam_excess_db(found, range(MOST + k, len(found), MOST)) for k in range(0, MOST, 4)]
    assert excess[0] <= max(excess[1:]) + 0.1


def test_a_measured_jump_in_speed_and_force_makes_no_jump(texture, script, rendered):
    hop = script(
        None, lambda t: 0.2 if t < 1 else 1.0, speed=lambda t: 50.0 if int(8 * t) % 2 else 300.0, rate=200.0
    )
    samples, _ = rendered(engine([texture()], hop), 4.0)
    found = Signal(samples[:, 800:], RATE, "m/s^2")
    assert seam_excess_db(found, range(MOST, len(found), MOST)) < 0.5


def test_at_rest_a_vibration_fades_and_comes_back(texture, script, rendered):
    place = lambda t: 100 * min(t, 0.5) if t < 1.0 else 50 + 100 * (t - 1.0)  # noqa: E731
    samples, _ = rendered(engine([texture()], script(place)), 1.5)
    level = samples[0].reshape(-1, 400).std(axis=1)  # by 50 ms
    assert level[4:10].min() > 0.5
    assert level[14:20].max() == 0
    assert level[-4:].min() > 0.5


def test_a_mix_has_the_weighted_mean_of_the_powers(texture, script, rendered):
    pair = [texture("a", 1), texture("b", 2)]
    moving = engine(pair, script(lambda t: 100 * t, lambda t: 0.6), weights={"a": 0.3, "b": 0.7})
    samples, _ = rendered(moving, 8.0)
    assert samples[0, 2000:].std() == pytest.approx(1.6, rel=0.12)


def test_weights_glide_while_it_plays(resonance, script, rendered):
    made = [
        AutoregressiveTexture(
            name, TextureTable(TextureMap([resonance(f)], [[100.0, 0.5]])), rate=RATE, most=MOST, seed=1
        )
        for name, f in (("low", 100), ("high", 1000))
    ]

    class Changing(script):
        def poll(self, now_s):
            return [*super().poll(now_s), *([MixWeights({"low": 0.0, "high": 1.0})] if now_s == 2.0 else [])]

    moving = engine(made, Changing(lambda t: 100 * t), weights={"low": 1.0, "high": 0.0})
    samples, _ = rendered(moving, 4.0)
    assert peak_hz(samples[0, 2000:15_000]) == pytest.approx(100, abs=10)
    assert peak_hz(samples[0, 18_000:]) == pytest.approx(1000, abs=30)
    assert moving.weights == {"low": 0.0, "high": 1.0}


def test_an_unknown_name_in_a_mix_that_comes_with_the_motion_is_counted(texture, script):
    class Wrong(script):
        def poll(self, now_s):
            return [MixWeights({"nothing": 1.0})]

    moving = engine([texture()], Wrong(lambda t: 0.0))
    moving.render(0.0)
    assert moving.finger.counts.invalid == 1


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"rate": 500.0}, "at least 1000 Hz"),
        ({"most": 41}, "1 to 40 samples"),
        ({"weights": {"q": 1.0}}, "mix must be one of slope, got 'q'"),
        ({"weights": {"slope": -1.0}}, "mix must give slope a weight >= 0"),
    ],
)
def test_what_makes_no_engine_is_refused(texture, script, change, says):
    options = {"rate": RATE, "most": MOST} | change
    with pytest.raises(ParameterError, match=says):
        Engine([texture()], script(lambda t: 0.0), **options)


def test_a_lost_connection_fades_to_silence_and_comes_back(texture, script, rendered):
    class Gap(script):
        def poll(self, now_s):
            return [s for s in super().poll(now_s) if not 0.5 < s.time_s < 1.0]

    moving = engine([texture()], Gap(lambda t: 100 * t), settings=MotionSettings(lost_s=0.1))
    samples, _ = rendered(moving, 1.5)
    level = samples[0].reshape(-1, 400).std(axis=1)  # by 50 ms
    assert level[5:10].min() > 0.5
    assert level[13:20].max() == 0
    assert level[-6:].min() > 0.5
    assert moving.finger.counts.lost_connections == 1
    assert moving.blocks["lost"] > 70


def test_a_device_that_asks_unevenly_does_not_make_the_finger_tremble(texture, script):
    made = engine([texture()], script(lambda t: 200 * t, lambda t: 0.6))
    # Late by some milliseconds, as on a busy machine; the samples are played evenly.
    late = np.random.default_rng(4).exponential(0.002, 600)
    speeds = []
    for asked in np.maximum.accumulate(np.arange(600) * MOST / RATE + late):
        made.render(asked)
        speeds.extend(made.tracker.block.speed_mm_s[: made.tracker.block.count])
    settled = np.array(speeds[200 * MOST :])
    assert settled.mean() == pytest.approx(200, rel=0.01)
    assert settled.std() < 2
