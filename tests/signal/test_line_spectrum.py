"""Line spectral frequencies: against the roots of their polynomials, and both ways at high orders."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.line_spectrum import (
    line_spectrum_of_reflection,
    polynomial_of_reflection,
    reflection_of_line_spectrum,
    reflection_of_polynomial,
)


def reflections(largest, max_order):
    number = st.floats(-largest, largest, allow_subnormal=False)
    return st.lists(number, min_size=1, max_size=max_order).map(np.array)


def roots_of_sum_and_difference(reflection):
    """Itakura's definition: the angles of P's and Q's roots in (0, pi)."""
    a = np.append(polynomial_of_reflection(reflection), 0.0)
    angles = np.angle(np.concatenate([np.roots(a + a[::-1]), np.roots(a - a[::-1])]))
    return np.sort(angles[(angles > 1e-6) & (angles < np.pi - 1e-6)])


def order_60(rng):
    """A texture's filter: twenty resonances of every sharpness and twenty real poles, order 60."""
    poles = rng.uniform(0.3, 0.97, 20) * np.exp(1j * rng.uniform(0.1, 3.0, 20))
    return np.poly(np.concatenate([poles, poles.conj(), rng.uniform(-0.6, 0.6, 20)])).real


@given(reflections(0.9, 8))
def test_frequencies_are_the_roots_of_their_definition(reflection):
    found = line_spectrum_of_reflection(reflection)
    np.testing.assert_allclose(found, roots_of_sum_and_difference(reflection), atol=1e-7)


@given(reflections(0.9, 12))
def test_reflection_comes_back_through_frequencies(reflection):
    back = reflection_of_line_spectrum(line_spectrum_of_reflection(reflection))
    np.testing.assert_allclose(back, reflection, atol=1e-6)


@given(reflections(0.9, 12))
def test_reflection_comes_back_through_the_polynomial(reflection):
    back = reflection_of_polynomial(polynomial_of_reflection(reflection))
    np.testing.assert_allclose(back, reflection, atol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_order_60_comes_back_from_its_frequencies(seed):
    rng = np.random.default_rng(seed)
    lines = np.sort(rng.uniform(0.02, np.pi - 0.02, 60) * 0.2 + 0.8 * np.linspace(0.02, np.pi - 0.02, 60))

    back = line_spectrum_of_reflection(reflection_of_line_spectrum(lines))

    np.testing.assert_allclose(back, lines, atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_order_60_keeps_its_spectrum(seed):
    polynomial = order_60(np.random.default_rng(seed))
    reflection = reflection_of_polynomial(polynomial)

    back = reflection_of_line_spectrum(line_spectrum_of_reflection(reflection))

    wanted, got = (np.abs(np.fft.rfft(polynomial_of_reflection(k), 2048)) for k in (reflection, back))
    np.testing.assert_allclose(20 * np.log10(got / wanted), 0, atol=1e-3)


@given(reflections(0.9999, 60), reflections(0.9999, 60), st.floats(0, 1))
def test_every_mean_of_stable_filters_is_stable(one, other, share):
    order = max(one.size, other.size)
    a, b = (line_spectrum_of_reflection(np.pad(k, (0, order - k.size))) for k in (one, other))
    assert np.all(np.abs(reflection_of_line_spectrum(share * a + (1 - share) * b)) < 1)


def test_white_noise_has_evenly_spaced_frequencies():
    np.testing.assert_allclose(line_spectrum_of_reflection(np.zeros(7)), np.pi * np.arange(1, 8) / 8)


def test_order_0_is_nothing_both_ways():
    assert line_spectrum_of_reflection([]).size == reflection_of_line_spectrum([]).size == 0


@pytest.mark.parametrize("lines", [[0.5, 0.4], [0.5, 0.5], [0.0, 1.0], [1.0, np.pi], [np.nan]])
def test_frequencies_that_do_not_ascend_are_refused(lines):
    with pytest.raises(ParameterError, match="must ascend strictly"):
        reflection_of_line_spectrum(lines)


@pytest.mark.parametrize("polynomial", [[1, -2, 1.1], [1, -1], [1, np.nan]])
def test_unstable_polynomial_is_refused(polynomial):
    with pytest.raises(ParameterError, match="must be stable"):
        reflection_of_polynomial(polynomial)


def test_polynomial_must_begin_with_1():
    with pytest.raises(ParameterError, match="begins with 1"):
        reflection_of_polynomial([2, 1])


def test_reflection_of_1_is_refused():
    with pytest.raises(ParameterError, match=r"within \(-1, 1\)"):
        line_spectrum_of_reflection([0.5, 1.0])


RATE = 1000.0


def drawn(polynomial, seconds, seed, deviation=1.0):
    noise = np.random.default_rng(seed).standard_normal(round(seconds * RATE) + 2000) * deviation
    return Signal(lfilter([1], polynomial, noise)[2000:], RATE, "m/s^2")


def test_reflection_of_polynomial_agrees_with_the_fit():
    model = fit_autoregressive(drawn([1, -1.6, 0.9], 5, 0), order=6)
    np.testing.assert_allclose(
        reflection_of_polynomial(model.coefficients[0]), model.reflection[0], atol=1e-9
    )
