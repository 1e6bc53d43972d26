"""Tones: lines that follow a wandering speed, found in recordings, mixed, moved and synthesised."""

import numpy as np
import pytest
from tests.signal.ribs import BAND, RATE, ribs

from tactogram.errors import ParameterError
from tactogram.signal.modulated_noise import mix
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.modulated_noise_synthesis import NoiseProcess, parameters_of, synthesise_modulated_noise
from tactogram.signal.texture_map import NoiseMap
from tactogram.signal.tones import Tones, mix_tones, no_tones, share_pattern, synthesise_tones


def line_share(samples, hz, width=8.0):
    """Return the share of the power within ``width`` of a frequency."""
    power = np.abs(np.fft.rfft(samples * np.hanning(samples.shape[-1]))) ** 2
    frequency = np.fft.rfftfreq(samples.shape[-1], 1 / RATE)
    return float(power[..., np.abs(frequency - hz) < width].sum() / power.sum())


def test_synthesised_ribs_are_steady_and_as_strong_as_recorded():
    signals = [ribs(seed) for seed in range(4)]
    model = fit_modulated_noise(signals)
    made = [synthesise_modulated_noise(model, 4.0, seed=seed).samples for seed in range(4)]
    recorded = np.mean([s.samples.std(1) for s in signals], 0)
    np.testing.assert_allclose(np.mean([x.std(1) for x in made], 0), recorded, rtol=0.1)
    assert np.corrcoef(np.concatenate(made, 1))[0, 1] == pytest.approx(
        np.corrcoef(np.concatenate([s.samples for s in signals], 1))[0, 1], abs=0.05
    )

    def swelling(x):
        return (x[0].reshape(-1, 50) ** 2).mean(1).std() / (x[0] ** 2).mean()

    steady = np.mean([swelling(s.samples) for s in signals])
    assert np.mean([swelling(x) for x in made]) < 1.6 * steady


def test_blocks_are_one_call():
    model = fit_modulated_noise([ribs(0), ribs(1)])
    axes, made = len(model.axes), []
    for counts in ((900,), (1, 10, 89, 800)):
        process = NoiseProcess(axes, model.lags, model.rate, seed=3)
        blocks = [np.empty((axes, count)) for count in counts]
        for block in blocks:
            process.next(block, parameters_of(model))
        made.append(np.hstack(blocks))
    assert np.array_equal(*made)


def test_a_mix_has_the_lines_of_both_and_the_mean_power_in_db():
    one, other = (
        fit_modulated_noise(ribs(0, hz=60.0)),
        fit_modulated_noise(ribs(1, hz=90.0, harmonics=(3.0,))),
    )
    half = mix([one, other], [0.5, 0.5])
    assert len(half.tones.frequency) == 3
    made = synthesise_modulated_noise(half, 20.0, seed=0).samples
    power = [synthesise_modulated_noise(m, 20.0, seed=0).samples.var(1) for m in (one, other)]
    np.testing.assert_allclose(10 * np.log10(made.var(1) / np.sqrt(power[0] * power[1])), 0, atol=0.5)


def test_lines_of_one_frequency_are_added_and_unsteadiness_is_that_of_tones():
    one = Tones(np.array([50.0, 80.0]), np.ones((2, 1, 2)), np.full(5, 0.1))
    mixed = mix_tones([one, one, no_tones(1)], [0.25, 0.25, 0.5])
    assert mixed.frequency.tolist() == [50.0, 80.0]
    np.testing.assert_allclose(mixed.amplitude, 0.5)
    np.testing.assert_allclose(mixed.unsteadiness, 0.1)


def test_strokes_of_a_surface_share_the_strongest_pattern_at_their_speed_and_power():
    strong = Tones(np.array([100.0, 300.0]), np.array([[[2.0, 1.0]], [[0.0, 0.0]]]), np.zeros(5))
    weak = Tones(np.array([37.0]), np.array([[[0.5]], [[0.0]]]), np.zeros(5))
    shared = share_pattern([strong, weak, no_tones(1)], [100.0, 50.0, 200.0], np.array([20.0, 500.0]))
    assert [each.frequency.tolist() for each in shared] == [[100.0, 300.0], [50.0, 150.0], [200.0, 600.0]]
    np.testing.assert_allclose(shared[1].power, weak.power)
    assert shared[2].power == 0
    alone = share_pattern([strong, strong], [np.nan, np.nan], np.array([20.0, 500.0]))
    assert alone[1].frequency.tolist() == strong.frequency.tolist()


def test_lines_follow_the_speed_between_recordings():
    """Ribs at 100 and 200 mm/s: at 150 there is one line, half way."""
    models = [fit_modulated_noise(ribs(0, hz=60.0)), fit_modulated_noise(ribs(1, hz=120.0))]
    surface = NoiseMap(models, [[100.0, np.nan], [200.0, np.nan]])
    between = surface.at(150.0)
    made = synthesise_modulated_noise(between, 8.0, seed=0).samples
    hz = between.tones.frequency[0]
    assert hz == pytest.approx(90, rel=0.1)
    assert line_share(made, hz, 20) > 0.5 > 10 * line_share(made, 60.0, 5)


def test_one_axis_has_the_power_of_all():
    tones = Tones(np.array([50.0]), np.array([[[3.0], [4.0]], [[0.0], [0.0]]]), np.zeros(5))
    np.testing.assert_allclose(tones.summed([True, True]).amplitude, [[[5.0]], [[0.0]]])
    np.testing.assert_allclose(tones.summed([False, True]).amplitude, [[[4.0]], [[0.0]]])


def test_a_spectrum_has_the_power_of_its_lines():
    tones = Tones(
        np.array([50.0, 200.0]), np.array([[[3.0, 1.0]], [[0.0, 1.0]]]), np.array([0.02, 0.05, 0.9, 0, 0])
    )
    frequency = np.arange(0, 500.0)
    np.testing.assert_allclose(
        np.trapezoid(tones.power_spectrum(frequency), frequency), tones.power, rtol=1e-3
    )


def test_tones_whose_shapes_differ_are_refused():
    with pytest.raises(ParameterError, match="tones of 2 lines need amplitudes"):
        Tones(np.zeros(2), np.zeros((2, 1, 3)), np.zeros(5))


def test_tones_that_lose_a_line_are_refused():
    two = Tones(np.array([50.0, 90.0]), np.ones((2, 1, 2)), np.zeros(5))
    one = Tones(np.array([50.0]), np.ones((2, 1, 1)), np.zeros(5))
    with pytest.raises(ParameterError, match="must keep their lines, got 2, then 1"):
        synthesise_tones([two, one], 1000, RATE, seed=0)


def test_several_tones_glide_from_one_to_the_next():
    steady = Tones(np.array([50.0]), np.array([[[1.0]], [[0.0]]]), np.zeros(5))
    end = steady.moved(2.0, BAND).scaled(np.array([3.0]))
    same = synthesise_tones([steady] * 3, 4000, RATE, seed=1)
    np.testing.assert_allclose(same, synthesise_tones([steady], 4000, RATE, seed=1), atol=1e-9)
    glide = synthesise_tones([steady, end], 4000, RATE, seed=1)[0]
    hz = [np.diff(np.signbit(second)).sum() / 2 for second in glide.reshape(4, 1000)]
    np.testing.assert_allclose(hz, [56.25, 68.75, 81.25, 93.75], atol=1)
    assert np.abs(glide[-500:]).max() == pytest.approx(3, rel=0.1)
