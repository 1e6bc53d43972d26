"""Engine: continuity, pitch by speed, immediate landings, mixes of constant power."""

import math

import numpy as np
import pytest
from scipy import signal as dsp
from tests.signal.seams import seam_excess_db

from tactogram.errors import ParameterError
from tactogram.rendering.streaming.contact import ActiveTransients, ContactSettings
from tactogram.rendering.streaming.engine import Engine
from tactogram.rendering.streaming.motion import MixWeights, MotionSettings, Tap
from tactogram.rendering.streaming.recorded_motion import SimulatedHand
from tactogram.rendering.streaming.texture_table import TextureTable, summed
from tactogram.rendering.streaming.textures import AutoregressiveTexture, SurfaceTexture, looped
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel
from tactogram.signal.texture_map import TextureMap

RATE, MOST = 8000.0, 40
SILENT = ContactSettings(gain=0)


@pytest.fixture(scope="module")
def table(sloping):
    return TextureTable(sloping)


@pytest.fixture(name="texture")
def texture_fixture(table):
    def make(name="slope", seed=0):
        return AutoregressiveTexture(name, table, rate=RATE, most=MOST, seed=seed)

    return make


def engine(textures, motion, **options):
    return Engine(textures, motion, rate=RATE, most=MOST, contact=options.pop("contact", SILENT), **options)


def peak_hz(samples, rate=RATE):
    frequency, power = dsp.welch(samples, rate, nperseg=2048)
    return float(frequency[np.argmax(power)])


# -- tables ------------------------------------------------------------------------------------------------


def test_a_table_is_exact_at_every_condition_that_was_recorded(table, sloping):
    for model, (speed, force) in zip(sloping.models, sloping.conditions, strict=True):
        found = table.at(speed, force)
        assert np.allclose(found.reflection, model.reflection, atol=1e-9)
        assert found.power == pytest.approx(model.power, rel=1e-9)


def test_between_its_nodes_a_table_is_the_map_to_a_fraction_of_a_db(table, sloping):
    frequency, random = np.linspace(0.02, 0.98, 200) * table.rate / 2, np.random.default_rng(0)
    found = []
    for _ in range(30):
        speed, force = (random.uniform(grid[0], grid[-1]) for grid in (table.grid.speeds, table.grid.forces))
        exact = sloping.at(
            *(v if known else None for v, known in zip((speed, force), sloping.has_conditions, strict=True))
        )
        ratio = table.at(speed, force).power_spectrum(frequency) / exact.power_spectrum(frequency)
        found.append(np.sqrt(np.mean((10 * np.log10(ratio)) ** 2)))
    assert np.mean(found) < 0.05


def test_outside_a_table_holds_its_edge(table):
    assert np.array_equal(table.at(9999, 9).reflection, table.at(300, 1).reflection)
    assert np.array_equal(table.at(0, 0).reflection, table.at(50, 0.2).reflection)


def test_a_surface_of_one_condition_has_a_table(resonance):
    one = TextureMap([resonance(200)], [[math.nan, math.nan]])
    assert np.allclose(TextureTable(one).at(123, 4).reflection, resonance(200).reflection)


def test_summed_axes_have_the_power_of_all_at_every_frequency():
    random = np.random.default_rng(0)
    model = AutoregressiveModel(
        np.tanh(random.normal(0, 0.4, (3, 12))), np.diag([1.0, 2.0, 0.5]), 2500.0, "m/s^2", ("x", "y", "z")
    )
    one = summed(model)
    frequency = np.linspace(5, 1245, 400)
    ratio = one.power_spectrum(frequency)[0] / model.power_spectrum(frequency).sum(axis=0)
    assert np.sqrt(np.mean((10 * np.log10(ratio)) ** 2)) < 0.5
    assert one.power[0] == pytest.approx(model.power.sum(), rel=1e-6)


def test_an_axis_that_is_not_there_is_refused(sloping):
    with pytest.raises(ParameterError, match="axis must be dft321, all or one of z, got 'q'"):
        TextureTable(sloping, axis="q")


# -- autoregressive textures under the finger --------------------------------------------------------------


@pytest.mark.parametrize("speed", [50.0, 100.0, 240.0])
def test_pitch_and_level_are_those_of_speed_and_force(texture, script, rendered, speed):
    samples, _ = rendered(engine([texture()], script(lambda t: speed * t, lambda t: 0.6)), 6.0)
    settled = samples[0, 4000:]
    assert peak_hz(settled) == pytest.approx(2 * speed, abs=8)
    assert settled.std() == pytest.approx(1.6, rel=0.15)


@pytest.mark.parametrize("rate", [2500.0, 10_000.0])
def test_a_texture_at_another_rate_keeps_pitch_and_level(resonance, script, rendered, rate):
    table = TextureTable(TextureMap([resonance(300, rms=2.0, rate=rate)], [[100.0, math.nan]]))
    texture = AutoregressiveTexture("a", table, rate=RATE, most=MOST, seed=3)
    samples, _ = rendered(engine([texture], script(lambda t: 100 * t)), 6.0)
    assert peak_hz(samples[0, 4000:]) == pytest.approx(300, abs=8)
    assert samples[0, 4000:].std() == pytest.approx(2.0, rel=0.15)
    assert 0 < texture.delay_s <= 0.005


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


# -- surfaces ----------------------------------------------------------------------------------------------


def grating(cycles_per_mm=2.0, length_mm=50.0, rate=40.0, unit="m/s^2"):
    x = np.arange(int(length_mm * rate)) / rate
    return Signal(np.sin(2 * np.pi * cycles_per_mm * x).astype(np.float32), rate, unit, domain="displacement")


@pytest.mark.parametrize("speed", [50.0, 120.0, 300.0])
def test_a_grating_is_felt_at_its_cycles_by_the_speed(script, rendered, speed):
    surface = SurfaceTexture("grating", grating(), rate=RATE)
    samples, _ = rendered(engine([surface], script(lambda t: speed * t)), 3.0)
    assert peak_hz(samples[0, 4000:]) == pytest.approx(2 * speed, abs=4)
    assert samples[0, 8000:].std() == pytest.approx(np.sqrt(0.5), rel=0.02)


def test_a_signal_over_time_is_laid_out_by_its_speed(script, rendered):
    t = np.arange(4000) / 2000
    made = Signal(np.sin(2 * np.pi * 150 * t).astype(np.float32), 2000, "m/s^2")
    surface = SurfaceTexture("a", made, rate=RATE, speed_mm_s=100.0)
    samples, _ = rendered(engine([surface], script(lambda t: 200 * t)), 2.0)
    assert peak_hz(samples[0, 4000:]) == pytest.approx(300, abs=4)
    with pytest.raises(ParameterError, match="over time: give speed_mm_s"):
        SurfaceTexture("a", made, rate=RATE)


def test_what_a_fast_finger_would_fold_back_is_gone(script, rendered):
    """15 cycles per mm at 400 mm/s are 6 kHz: above half of 8 kHz, to be folded to 2 kHz."""
    surface = SurfaceTexture("fine", grating(15.0), rate=RATE)
    samples, _ = rendered(engine([surface], script(lambda t: 400 * t)), 1.0)
    assert samples[0, 4000:].std() < 1e-3


def test_a_loop_has_no_seam():
    random = np.random.default_rng(1)
    rough = dsp.sosfilt(dsp.butter(4, 0.2, output="sos"), random.standard_normal(3000))
    loop = looped(Signal(rough.astype(np.float32), 40, "1", domain="displacement"))
    twice = Signal(np.tile(loop.samples, 4), 40, "1", domain="displacement")
    assert seam_excess_db(twice, [len(loop), 2 * len(loop), 3 * len(loop)]) < 3
    assert loop.samples.std() == pytest.approx(rough.std(), rel=0.1)


def test_friction_is_locked_to_the_place_and_holds_at_rest(script, rendered):
    """There and back over a ramp of friction coefficients: the same place has the same value."""
    x = np.arange(4000) / 40
    bump = 0.3 + 0.2 * np.exp(-((x - 50) ** 2) / 50)
    surface = SurfaceTexture(
        "bump", Signal(bump.astype(np.float32), 40, "1", domain="displacement"), rate=RATE, along="x"
    )
    moving = engine([surface], script(lambda t: 45 + 20 * math.sin(math.pi * t)))
    values, places = [], []
    for block in range(400):
        out = moving.render(block * MOST / RATE)[0]
        values.append(float(out[-1]))
        places.append(moving.tracker.block.x_mm[MOST - 1])
    loop = looped(Signal(bump.astype(np.float32), 40, "1", domain="displacement"))
    expected = np.interp(np.array(places) % loop.length_mm, np.arange(len(loop)) / 40, loop.samples[0])
    assert np.abs(np.array(values) - expected)[40:].max() < 2e-3
    still = engine([surface], script(lambda t: 45.0))
    samples, _ = rendered(still, 0.5)
    assert samples[0, -2000:].min() > 0.25


# -- landings ----------------------------------------------------------------------------------------------


def test_a_landing_is_heard_in_the_block_after_it(texture, script, rendered):
    moving = engine(
        [texture()], script(lambda t: 0.0, lambda t: 0.0 if t < 0.5 else 1.0), contact=ContactSettings()
    )
    samples, _ = rendered(moving, 1.0)
    begin = int(np.argmax(np.abs(samples[0]) > 1e-3 * np.abs(samples[0]).max()))
    assert 0 <= begin / RATE - 0.5 <= MOST / RATE
    assert np.abs(samples).max() == pytest.approx(4.0 * moving.textures[0].level, rel=0.05)
    assert moving.transients.started == 1


def test_a_tap_message_needs_no_contact(texture, script):
    class Tapped(script):
        def poll(self, now_s):
            return [*super().poll(now_s), *([Tap(now_s, 0.5)] if now_s == 0.25 else [])]

    moving = engine([texture()], Tapped(lambda t: 0.0, lambda t: 0.0), contact=ContactSettings())
    peaks = [np.abs(moving.render(b * MOST / RATE)).max() for b in range(60)]
    assert max(peaks[:50]) == 0
    assert peaks[50] > 0
    assert moving.latency.tap.count == 1


def test_a_transient_is_the_decaying_sine_of_its_settings():
    settings = ContactSettings(frequency_hz=200, decay_s=0.01, gain=2.0)
    transients = ActiveTransients(settings, RATE)
    transients.start(1.5, 1.0)
    whole = np.zeros((1, 800), np.float32)
    transients.add(whole, 800)
    t = np.arange(800) / RATE
    shape = np.exp(-t / 0.01) * np.sin(2 * np.pi * 200 * t)
    assert np.allclose(whole[0], 3.0 * shape / math.exp(-0.25 / 2), atol=1e-4)
    assert not transients._amplitude.any()


# -- mixes -------------------------------------------------------------------------------------------------


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
        ({"weights": {"q": 1.0}}, "textures are slope; got 'q'"),
        ({"weights": {"slope": -1.0}}, "must be >= 0"),
    ],
)
def test_what_makes_no_engine_is_refused(texture, script, change, says):
    options = {"rate": RATE, "most": MOST} | change
    with pytest.raises(ParameterError, match=says):
        Engine([texture()], script(lambda t: 0.0), **options)


def test_textures_of_two_units_do_not_mix(texture, script):
    friction = SurfaceTexture("mu", grating(unit="1"), rate=RATE)
    with pytest.raises(ParameterError, match="one unit and number of axes"):
        engine([texture(), friction], script(lambda t: 0.0))


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
