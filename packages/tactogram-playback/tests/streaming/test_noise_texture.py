"""Modulated noise under a finger: the offline signal at one condition, and what follows speed and force."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal as dsp
from seams import seam_excess_db

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import MotionBlock
from tactogram.rendering.embedded.noise_header import one_axis
from tactogram.signal import Signal
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.modulated_noise_synthesis import synthesise_modulated_noise
from tactogram.signal.texture_map import NoiseMap
from tactogram_playback.streaming.contact import ContactSettings
from tactogram_playback.streaming.engine import Engine
from tactogram_playback.streaming.noise_texture import ModulatedNoiseTexture, NoiseTable

RATE, MOST, OWN = 8000.0, 40, 2000.0
PEAK_PER_SPEED = 1.5
CONDITIONS = [(v, f) for v in (50.0, 150.0, 300.0) for f in (0.2, 1.0)]


def unclicked(model):
    """Return a model without local amplitudes, which are not streamed."""
    return replace(model, local=model.local[:0])


def recording(speed, force, seed, *, axes=1, rate=OWN, seconds=2.0):
    """Noise with a peak at 1.5 Hz per mm/s and an rms of 1 + force, which pulsates at the speed over 20 mm."""
    random = np.random.default_rng(seed)
    count, angle = round(seconds * rate), 2 * np.pi * PEAK_PER_SPEED * speed / rate
    x = dsp.lfilter([1], [1, -1.9 * np.cos(angle), 0.95**2], random.standard_normal((axes, count + 500)))
    x = x[:, 500:] * (1 + 0.9 * np.sin(2 * np.pi * speed / 20 * np.arange(count) / rate + random.random()))
    return Signal((1 + force) * x / x.std(), rate, "m/s^2", ("x", "y", "z")[:axes])


@pytest.fixture(scope="module")
def surface():
    models = [
        fit_modulated_noise([recording(v, f, 10 * n + k) for k in range(3)])
        for n, (v, f) in enumerate(CONDITIONS)
    ]
    return NoiseMap(models, CONDITIONS)


@pytest.fixture(scope="module")
def table(surface):
    return NoiseTable(surface)


def at(speed, force, count=MOST):
    block = MotionBlock(count)
    block.count, block.speed_mm_s[:], block.force_n[:] = count, speed, force
    return block


def rendered(texture, speed, force, seconds=2.0, rate=RATE, most=MOST):
    out = np.zeros((len(texture.axes), most), np.float32)
    blocks = []
    for _ in range(round(seconds * rate / most)):
        texture.render(at(speed, force, most), out)
        blocks.append(out.copy())
    return np.concatenate(blocks, axis=1)


def engine(texture, motion):
    return Engine([texture], motion, rate=RATE, most=MOST, contact=ContactSettings(gain=0))


def fluctuation(samples, rate):
    """Return the coefficient of variation of the rms of 10 ms."""
    step = round(0.01 * rate)
    level = np.sqrt((samples**2)[: len(samples) // step * step].reshape(-1, step).mean(axis=1))
    return level.std() / level.mean()


def peak_hz(samples, rate=RATE):
    frequency, power = dsp.welch(samples, rate, nperseg=2048)
    return float(frequency[np.argmax(power)])


@pytest.mark.parametrize("place", [0, 3, 5])
@pytest.mark.parametrize("most", [1, 10, 33])
def test_at_one_speed_and_force_a_stream_is_the_offline_signal(table, surface, place, most):
    speed, force = CONDITIONS[place]
    texture = ModulatedNoiseTexture("a", table, rate=OWN, most=most, seed=7)
    streamed = rendered(texture, speed, force, 0.3, OWN, most)
    model = surface.models[place]
    offline = (
        synthesise_modulated_noise(unclicked(model), 0.4, seed=7).samples[:, : streamed.shape[1]] - model.mean
    )
    assert np.abs(streamed - offline).max() < 1e-5 * np.abs(offline).max()
    assert texture.delay_s == 0


def ribs(speed, seed, *, axes=1):
    """Ribs of 2 mm, and noise; the finger is not quite steady."""
    random = np.random.default_rng(seed)
    slow = dsp.sosfilt(dsp.butter(2, 1.5, fs=OWN, output="sos"), random.standard_normal(10_000))[2000:]
    wave = np.cos(2 * np.pi * np.cumsum(speed / 2 * np.exp(0.05 * slow / slow.std())) / OWN)
    x = wave + 0.1 * random.standard_normal((axes, len(wave)))
    return Signal(x.astype(np.float32), OWN, "m/s^2", ("x", "y", "z")[:axes])


@pytest.fixture(scope="module")
def ribbed():
    return NoiseMap(
        [fit_modulated_noise(ribs(v, 1)) for v in (80.0, 240.0)], [[80.0, np.nan], [240.0, np.nan]]
    )


@pytest.mark.parametrize(("place", "speed"), [(0, 80.0), (1, 240.0)])
def test_ribs_at_a_recorded_speed_stream_as_offline(ribbed, place, speed):
    texture = ModulatedNoiseTexture("ribs", NoiseTable(ribbed), rate=OWN, most=10, seed=7)
    streamed = rendered(texture, speed, 0.0, 0.5, OWN, 10)
    model = ribbed.models[place]
    offline = synthesise_modulated_noise(unclicked(model), 0.5, seed=7).samples - model.mean
    assert len(model.tones.frequency)
    # A frequency of 32 bits is off by a millionth of a cycle per cycle.
    assert np.abs(streamed - offline).max() < 1e-4 * np.abs(offline).max()


def test_ribs_follow_a_finger_that_changes_its_speed_in_every_block(ribbed):
    texture = ModulatedNoiseTexture("ribs", NoiseTable(ribbed), rate=OWN, most=10, seed=0)
    speeds, out, blocks, cycles = np.linspace(90, 230, 400), np.zeros((1, 10), np.float32), [], []
    for speed in speeds:
        texture.render(at(speed, 0.0, 10), out)
        blocks.append(out.copy())
    x = np.concatenate(blocks, axis=1)[0]
    for part in range(4):
        piece = x[1000 * part : 1000 * (part + 1)]
        peak = np.argmax(np.abs(np.fft.rfft(piece * np.hanning(1000)))) * OWN / 1000
        cycles.append(peak / speeds[100 * part : 100 * (part + 1)].mean())
    np.testing.assert_allclose(cycles, 0.5, rtol=0.15)


def test_one_axis_of_ribs_has_the_tones_of_all():
    model = fit_modulated_noise(ribs(160.0, 3, axes=3))
    one = one_axis(model, "dft321")
    np.testing.assert_allclose(one.tones.power, model.tones.power.sum())
    np.testing.assert_allclose(one.power, model.power.sum(), rtol=0.05)


def test_all_axes_are_streamed_as_they_are_coupled():
    signals = [recording(100, 0.5, seed, axes=2, rate=1000.0) for seed in range(3)]
    common = [s.with_samples(s.samples + s.samples[::-1] / 2 + np.float32([[9.81], [0]])) for s in signals]
    model = fit_modulated_noise(common)
    table = NoiseTable(NoiseMap([model], [[100.0, 0.5]]), axis="all")
    streamed = rendered(
        ModulatedNoiseTexture("a", table, rate=1000.0, most=5, seed=3), 80.0, 0.1, 2.0, 1000.0, 5
    )
    offline = synthesise_modulated_noise(unclicked(model), 2.0, seed=3).samples - model.mean[:, None]
    assert np.abs(streamed - offline).max() < 1e-5 * np.abs(offline).max()
    assert np.corrcoef(streamed)[0, 1] > 0.6


def test_between_its_nodes_a_table_is_the_map_to_a_fraction_of_a_db(table):
    random, error = np.random.default_rng(0), []
    for _ in range(20):
        speed, force = random.uniform(50, 300), random.uniform(0.2, 1.0)
        texture = ModulatedNoiseTexture("a", table, rate=OWN, most=10, seed=0)
        texture.render(at(speed, force, 10), np.zeros((1, 10), np.float32))
        exact = table.at(speed, force)
        found, _ = texture._process._ends[1][1]
        magnitudes = [np.abs(np.fft.rfft(taps[0], 1024)) for taps in (found.taps, exact.filter)]
        error.append(np.sqrt(np.mean((20 * np.log10(magnitudes[0] / magnitudes[1])) ** 2)))
        np.testing.assert_allclose(found.quantiles, exact.quantiles, atol=0.1)
        for s, k, t in found.rotations:
            lengths = np.linalg.svd(np.block([[s, k], [-k.T, t]]))[1]
            assert 0.97 < lengths.min() <= lengths.max() < 1 + 1e-6
    assert np.mean(error) < 0.5


def test_outside_a_table_holds_its_edge(table):
    one, other = (ModulatedNoiseTexture("a", table, rate=OWN, most=10, seed=0) for _ in range(2))
    assert np.array_equal(rendered(one, 9999, 9, 0.1, OWN, 10), rendered(other, 300, 1, 0.1, OWN, 10))
    one, other = (ModulatedNoiseTexture("a", table, rate=OWN, most=10, seed=0) for _ in range(2))
    assert np.array_equal(rendered(one, 0, 0, 0.1, OWN, 10), rendered(other, 50, 0.2, 0.1, OWN, 10))


@pytest.mark.parametrize("speed", [50.0, 100.0, 150.0, 220.0, 300.0])
def test_pitch_level_and_fluctuation_are_those_of_speed_and_force(table, script, rendered_by_engine, speed):
    """At another rate than the recordings', under a finger, against the offline signal of the same seed."""
    texture = ModulatedNoiseTexture("a", table, rate=RATE, most=MOST, seed=1)
    samples = rendered_by_engine(engine(texture, script(lambda t: speed * t, lambda t: 0.6)), 12.0)[0, 4000:]
    offline = synthesise_modulated_noise(unclicked(table.at(speed, 0.6)), 12.0, seed=1).samples[0]
    assert peak_hz(samples) == pytest.approx(PEAK_PER_SPEED * speed, abs=15)
    assert samples.std() == pytest.approx(offline.std(), rel=0.05)
    assert texture.level == pytest.approx(np.sqrt(1.2 * 2.0), rel=1e-3)
    assert fluctuation(samples, RATE) == pytest.approx(fluctuation(offline, OWN), rel=0.1)
    assert fluctuation(samples, RATE) > 0.4


def test_a_measured_jump_in_speed_and_force_makes_no_jump(table, script, rendered_by_engine):
    hop = script(
        None, lambda t: 0.2 if t < 1 else 1.0, speed=lambda t: 50.0 if int(8 * t) % 2 else 300.0, rate=200.0
    )
    texture = ModulatedNoiseTexture("a", table, rate=RATE, most=MOST, seed=1)
    found = Signal(rendered_by_engine(engine(texture, hop), 4.0)[:, 800:], RATE, "m/s^2")
    assert seam_excess_db(found, range(MOST, len(found), MOST)) < 0.5


def test_at_rest_it_fades_and_comes_back(table, script, rendered_by_engine):
    place = lambda t: 100 * min(t, 0.5) if t < 1.0 else 50 + 100 * (t - 1.0)  # noqa: E731
    texture = ModulatedNoiseTexture("a", table, rate=RATE, most=MOST, seed=0)
    samples = rendered_by_engine(engine(texture, script(place)), 1.5)
    level = samples[0].reshape(-1, 400).std(axis=1)  # by 50 ms
    assert level[4:10].mean() > 0.5
    assert level[14:20].max() == 0
    assert level[-4:].mean() > 0.5


@pytest.fixture(name="rendered_by_engine")
def rendered_by_engine_fixture(rendered):
    return lambda made, seconds: rendered(made, seconds)[0]


# -- one axis of several -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def three_axes():
    strengths = np.float32([[1.0], [0.5], [2.0]])
    signals = [recording(100, 0.0, seed, axes=3, rate=1000.0) for seed in range(6)]
    return fit_modulated_noise([s.with_samples(strengths * s.samples + np.float32(5)) for s in signals])


@pytest.mark.parametrize(("axis", "chosen"), [("dft321", [0, 1, 2]), ("z", [2])])
def test_one_axis_has_the_power_of_those_it_stands_for_at_every_frequency(three_axes, axis, chosen):
    model = one_axis(three_axes, axis)
    assert (model.axes, model.unit, model.rate) == ((axis,), "m/s^2", 1000.0)
    assert abs(model.mean[0]) < 0.1
    frequency = np.arange(8, 500, 4)
    expected = three_axes.power_spectrum(frequency)[chosen].sum(axis=0)
    made = [synthesise_modulated_noise(model, 4.0, seed=seed).samples[0] for seed in range(8)]
    found = np.mean([dsp.welch(x, 1000.0, nperseg=250)[1] for x in made], axis=0)[2:125]
    difference = 10 * np.log10(found / expected)
    assert abs(difference.mean()) < 0.5
    assert difference.std() < 0.55
    assert np.exp(2 * model.deviation[0]) == pytest.approx(np.exp(2 * three_axes.deviation[chosen]).sum())


def test_one_axis_fluctuates_as_the_axes_do(three_axes):
    made = [synthesise_modulated_noise(one_axis(three_axes, "dft321"), 4.0, seed=s) for s in range(4)]
    recorded = [recording(100, 0.0, seed + 50, axes=3, rate=1000.0, seconds=4.0) for seed in range(4)]

    weights = np.array([[1.0], [0.5], [2.0]])
    together = [np.sqrt(((weights * s.samples) ** 2).sum(axis=0)) for s in recorded]
    expected = np.mean([fluctuation(x, 1000.0) for x in together])
    found = np.mean([fluctuation(s.samples[0], 1000.0) for s in made])
    assert found == pytest.approx(expected, rel=0.25)


def test_an_axis_that_is_not_there_is_refused(surface):
    with pytest.raises(ParameterError, match="axis must be dft321, all or one of x, got 'q'"):
        NoiseTable(surface, axis="q")
