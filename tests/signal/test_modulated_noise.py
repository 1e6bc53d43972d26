"""Modulated noise: spectrum, fluctuation and coupling of what it was fitted to; blocks; mixes; refusals."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal
from tests.signal.recorded_noise import MODEL, drawn, pulsating

from tactogram.errors import ParameterError
from tactogram.signal.modulated_noise import BANDS, RIDGE, equaliser_taps, frame_ends, mix
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.modulated_noise_synthesis import (
    synthesise_modulated_noise,
)


def yule_walker(covariance):
    """Return coefficients (gain, lag x gain), the latest frame first, and the innovations' covariance."""
    lags, gains = len(covariance) - 1, covariance.shape[1]
    blocks = [
        [covariance[j - i] if j >= i else covariance[i - j].T for j in range(lags)] for i in range(lags)
    ]
    with_past = np.hstack(list(covariance[1:]))
    coefficients = np.linalg.solve(np.block(blocks) + RIDGE * np.eye(lags * gains), with_past.T).T
    return coefficients, covariance[0] + RIDGE * np.eye(gains) - coefficients @ with_past.T


def test_mix_is_between_its_models_in_level_and_spectrum():
    strong = fit_modulated_noise([pulsating(seed, level=3.0) for seed in range(3)])
    weak = fit_modulated_noise([pulsating(seed, level=0.03) for seed in range(3)])
    levels = [
        20 * np.log10(np.concatenate([s.samples[0] for s in drawn(mix((strong, weak), (1 - w, w)))]).std())
        for w in (0, 0.25, 0.5, 0.75, 1)
    ]
    np.testing.assert_allclose(np.diff(levels), -10, atol=2.5)


def test_mix_is_stable_and_of_the_scale_of_its_weights_independent():
    fast = fit_modulated_noise([pulsating(seed, frequency=20) for seed in range(3)])
    mixed = mix((MODEL, fast), (2, 1))
    np.testing.assert_array_equal(mixed.covariance, mix((MODEL, fast), (4, 2)).covariance)
    coefficients, _ = yule_walker(mixed.covariance)
    gains = mixed.gains
    companion = np.vstack((coefficients, np.eye(coefficients.shape[1])[:-gains]))
    assert np.abs(np.linalg.eigvals(companion)).max() < 1
    assert mix((MODEL, fast), (0, 1)) is fast


def test_lattice_is_the_regression_of_the_covariances():
    """Rotations keep lengths; their root is that of the innovations; the likelihood is that of Yule and Walker."""
    rotations, root = MODEL.lattice
    for s, k, t in rotations:
        rotation = np.block([[s, k], [-k.T, t]])
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(2 * MODEL.gains), atol=1e-9)
        root = root @ s
    coefficients, innovations = yule_walker(MODEL.covariance)
    np.testing.assert_allclose(root @ root.T, innovations, atol=1e-9)
    z = np.random.default_rng(0).standard_normal((200, MODEL.gains))
    past = np.hstack([z[MODEL.lags - 1 - k : 199 - k] for k in range(MODEL.lags)])
    error = z[MODEL.lags :] - past @ coefficients.T
    expected = multivariate_normal(cov=innovations).logpdf(error).mean()
    assert MODEL.log_likelihood(z) == pytest.approx(expected, rel=1e-9)


def test_minimum_phase_filter_has_the_magnitude_asked_for():
    wanted = np.log(1 / np.abs(np.fft.rfft([1, -0.9], 500)))
    found = np.abs(np.fft.rfft(equaliser_taps(wanted), 500))
    np.testing.assert_allclose(20 * np.log10(found), 20 / np.log(10) * wanted, atol=0.2)
    energy = np.cumsum(equaliser_taps(wanted) ** 2)
    assert energy[20] > 0.98 * energy[-1]


def test_frames_end_at_the_nearest_sample():
    assert frame_ends(4, 1025.0).tolist() == [10, 21, 31, 41]
    assert frame_ends(4, 1025.0, per_frame=4).tolist() == [3, 5, 8, 10]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: mix((MODEL,), (0,)), "1 numbers >= 0, not all 0"),
        (lambda: mix((MODEL, replace(MODEL, unit="V")), (1, 1)), "one rate, unit, set of axes and order"),
        (
            lambda: replace(MODEL, coupling=np.ones((BANDS, 2, 2))),
            r"coupling must have the shape \(4, 1, 1\)",
        ),
        (lambda: replace(MODEL, mean=np.array([np.nan])), "mean must be finite"),
        (lambda: synthesise_modulated_noise(MODEL, 0.0, seed=0), "seconds must be > 0"),
        (lambda: MODEL.log_likelihood(np.zeros((5, 8))), "frames must be more than 10, got 5"),
    ],
)
def test_invalid_use_is_refused(call, message):
    with pytest.raises(ParameterError, match=message):
        call()
