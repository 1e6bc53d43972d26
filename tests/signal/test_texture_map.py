"""Models over speed and force: barycentric inside, the nearest point outside."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel
from tactogram.signal.modulated_noise import stretched
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.texture_map import NoiseMap, TextureMap

RATE = 1000.0


def model(power, frequency=100.0):
    angle = 2 * np.pi * frequency / RATE
    made = AutoregressiveModel.from_coefficients(
        [1, -1.8 * np.cos(angle), 0.81], 1.0, rate=RATE, unit="m/s^2"
    )
    return AutoregressiveModel(made.reflection, np.array([[power]]) / made.gain, RATE, "m/s^2", ("z",))


GRID = [(v, f) for v in (50, 100, 200) for f in (0.5, 1.0, 2.0)]
SURFACE = TextureMap([model(v * f, v) for v, f in GRID], GRID)


@settings(deadline=None)
@given(st.floats(50, 200), st.floats(0.5, 2))
def test_weights_inside_are_barycentric(speed, force):
    weights = SURFACE.weights(speed, force)
    assert weights.sum() == pytest.approx(1)
    assert weights.min() >= 0
    assert np.count_nonzero(weights) <= 3
    np.testing.assert_allclose(weights @ SURFACE.conditions, [speed, force], rtol=1e-6)


@settings(deadline=None)
@given(st.floats(0, 1000), st.floats(0, 20))
def test_outside_is_the_nearest_point_of_the_hull(speed, force):
    """The hull of a grid is a rectangle, where nearest is clamping each by itself."""
    expected = [np.clip(speed, 50, 200), np.clip(force, 0.5, 2)]
    np.testing.assert_allclose(SURFACE.weights(speed, force) @ SURFACE.conditions, expected, rtol=1e-6)


def test_recorded_conditions_are_the_recorded_models():
    for (speed, force), one in zip(GRID, SURFACE.models, strict=True):
        assert SURFACE.at(speed, force).power[0] == pytest.approx(one.power[0], rel=1e-6)


def test_corner_of_a_triangular_hull_is_cut():
    surface = TextureMap([model(1), model(2), model(3)], [(0, 0), (100, 0), (0, 1)])
    np.testing.assert_allclose(surface.weights(100, 1), [0, 0.5, 0.5])


def test_left_out_is_the_median():
    np.testing.assert_allclose(SURFACE.weights() @ SURFACE.conditions, [100, 1.0])


def test_speed_alone_is_a_line():
    surface = TextureMap([model(1), model(3), model(2)], [(50, np.nan), (200, np.nan), (100, np.nan)])
    np.testing.assert_allclose(surface.weights(speed_mm_s=150), [0, 0.5, 0.5])
    np.testing.assert_allclose(surface.weights(speed_mm_s=500), [0, 1, 0])
    with pytest.raises(ParameterError, match="force_n is unknown"):
        surface.weights(force_n=1.0)


def test_conditions_on_a_slanted_line_are_a_line():
    surface = TextureMap([model(1), model(2), model(3)], [(0, 0), (100, 1), (200, 2)])
    np.testing.assert_allclose(surface.weights(150, 1.5), [0, 0.5, 0.5])


def test_one_model_is_itself_everywhere():
    surface = TextureMap([model(1)], [(np.nan, np.nan)])
    assert surface.at() is surface.models[0]
    known = TextureMap([model(1)], [(100, 1)])
    assert known.at(5, 9) is known.models[0]


def test_given_triangles_are_used():
    points = [(0, 0), (1, 0), (0, 1), (1, 1)]
    other = [[0, 1, 3], [0, 3, 2]], [[0, 1, 2], [1, 2, 3]]
    weights = [TextureMap([model(1)] * 4, points, triangles=t).weights(0.5, 0.5) for t in other]
    np.testing.assert_allclose(weights, [[0.5, 0, 0, 0.5], [0, 0.5, 0.5, 0]])


@pytest.mark.parametrize(
    ("conditions", "options", "message"),
    [
        ([(1, 1)], {}, "2 models, 2"),
        ([(1, 1), (1, 1)], {}, "same speed and force"),
        ([(1, 1), (np.nan, 2)], {}, "for every model or for none"),
        ([(1, 1), (-1, 2)], {}, "finite and >= 0"),
    ],
)
def test_conditions_that_make_no_map_are_refused(conditions, options, message):
    with pytest.raises(ParameterError, match=message):
        TextureMap([model(1), model(2)], conditions, **options)


@pytest.mark.parametrize("speed", [-1, np.nan, np.inf])
def test_speed_that_makes_no_sense_is_refused(speed):
    with pytest.raises(ParameterError, match="speed_mm_s must be finite"):
        SURFACE.weights(speed, 1.0)


NOISE_RATE = 2000.0
SLOW, FAST, BETWEEN = 60.0, 240.0, 120.0


def resonance(hz, seed, *, level=1.0):
    """Return noise with a peak."""
    noise = np.random.default_rng(seed).standard_normal(9000)
    x = lfilter([1], [1, -1.9 * np.cos(2 * np.pi * hz / NOISE_RATE), 0.9025], noise)[1000:]
    return Signal((level * x / x.std())[None], NOISE_RATE, "m/s^2", ("z",))


def mapped(hz_at, speeds=(SLOW, FAST), forces=None):
    forces = [np.nan] * len(speeds) if forces is None else forces
    models = [
        fit_modulated_noise(resonance(hz_at(speed), n, level=speed / 100)) for n, speed in enumerate(speeds)
    ]
    return NoiseMap(models, np.column_stack((speeds, forces)))


def peak_hz(model):
    frequency = np.linspace(10, 900, 1781)
    return frequency[model.power_spectrum(frequency)[0].argmax()]


def test_a_pattern_is_felt_at_speed_over_period_between_recorded_speeds():
    surface = mapped(lambda speed: 1.25 * speed)
    assert surface.exponent == pytest.approx(1, abs=0.1)
    for speed in (SLOW, 90.0, BETWEEN, 200.0, FAST):
        assert peak_hz(surface.at(speed)) == pytest.approx(1.25 * speed, abs=15)
    truth = fit_modulated_noise(resonance(1.25 * BETWEEN, 9))
    band = slice(10, 110)  # 40 to 440 Hz
    errors = []
    for found in (surface.at(BETWEEN), surface.mix(surface.weights(BETWEEN))):
        difference = (found.spectrum - truth.spectrum)[0, band]
        errors.append(np.std(difference))
    assert errors[0] < 0.4 * errors[1]


def test_a_resonance_stays_where_it_is():
    surface = mapped(lambda speed: 180.0)
    assert surface.exponent == pytest.approx(0, abs=0.1)
    assert peak_hz(surface.at(BETWEEN)) == pytest.approx(180, rel=0.1)


def test_level_is_that_of_the_mix_and_recorded_conditions_stay():
    surface = mapped(lambda speed: 1.25 * speed, (SLOW, BETWEEN, FAST), (1.0, 1.0, 1.0))
    for model, speed in zip(surface.models, (SLOW, BETWEEN, FAST), strict=True):
        np.testing.assert_allclose(surface.at(speed, 1.0).spectrum, model.spectrum)
    at = surface.at(170.0, 1.0)
    np.testing.assert_allclose(at.deviation, surface.mix(surface.weights(170.0, 1.0)).deviation)
    powers = [np.log(np.exp(2 * model.spectrum).sum()) for model in (*surface.models, at)]
    assert powers[1] < powers[3] < powers[2]


def test_beyond_the_recorded_speeds_it_is_the_nearest():
    surface = mapped(lambda speed: 1.25 * speed)
    np.testing.assert_array_equal(surface.at(900.0).spectrum, surface.models[1].spectrum)
    np.testing.assert_array_equal(surface.at(1.0).spectrum, surface.models[0].spectrum)


def test_a_speed_that_is_not_asked_is_the_median():
    surface = mapped(lambda speed: 1.25 * speed)
    np.testing.assert_allclose(surface.at().spectrum, surface.at(150.0).spectrum)
    assert peak_hz(surface.at()) == pytest.approx(1.25 * 150, abs=15)


def test_a_recorded_speed_of_0_moves_nothing():
    surface = mapped(lambda speed: 1.25 * max(speed, 40.0), (0.0, SLOW, FAST))
    np.testing.assert_array_equal(surface.at(0.0).spectrum, surface.models[0].spectrum)
    assert np.isfinite(surface.at(30.0).spectrum).all()
    assert peak_hz(surface.at(BETWEEN)) == pytest.approx(1.25 * BETWEEN, abs=15)


def test_without_speeds_nothing_moves():
    model = fit_modulated_noise(resonance(100, 0))
    assert NoiseMap([model], [[np.nan, np.nan]]).exponent == 0
    by_force = NoiseMap([model, fit_modulated_noise(resonance(300, 1))], [[np.nan, 0.5], [np.nan, 1.0]])
    assert by_force.exponent == 0
    assert by_force.at(None, 0.5).spectrum.shape == model.spectrum.shape


def test_a_stretched_model_has_the_power_it_had_and_its_ends_stay():
    model = fit_modulated_noise(resonance(200, 0))
    moved = stretched(model, 1.5)
    assert peak_hz(moved) == pytest.approx(300, rel=0.1)
    powers = [np.exp(2 * each.spectrum).sum() for each in (model, moved)]
    assert powers[0] == pytest.approx(powers[1])
    np.testing.assert_allclose(moved.equaliser - model.equaliser, moved.spectrum - model.spectrum)
    assert np.ptp((moved.spectrum - model.spectrum)[0, :6]) < 1e-9  # below the bands
