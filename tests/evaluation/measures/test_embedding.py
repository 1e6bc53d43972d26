import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.linalg import sqrtm
from scipy.spatial.distance import cdist

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import (
    embedding,
    frechet_distance,
    precision_recall_density_coverage,
    two_sample_accuracy,
)


def normal(seed, n=400, d=8, shift=0.0, scale=1.0):
    return shift + scale * np.random.default_rng(seed).standard_normal((n, d))


def test_frechet_distance_in_one_dimension_is_that_of_means_and_deviations():
    a, b = normal(0, d=1), normal(1, d=1, shift=2, scale=3)
    expected = (a.mean() - b.mean()) ** 2 + (a.std(ddof=1) - b.std(ddof=1)) ** 2
    assert frechet_distance(a, b) == pytest.approx(expected)


def test_frechet_distance_is_the_textbooks_matrix_square_root():
    a, b = normal(0), normal(1, shift=0.3) @ np.diag(np.arange(1, 9)) / 4
    first, second = np.cov(a.T), np.cov(b.T)
    shift = a.mean(axis=0) - b.mean(axis=0)
    naive = shift @ shift + np.trace(first + second - 2 * sqrtm(first @ second).real)
    assert frechet_distance(a, b) == pytest.approx(naive)


def test_frechet_distance_of_fewer_points_than_features():
    a, b = normal(0, n=5, d=64), normal(1, n=7, d=64)
    # In a basis of all 12 points nothing is lost, and a textbook's root can be taken there.
    basis = np.linalg.svd(np.concatenate([a, b]), full_matrices=False)[2]
    first, second = np.cov((a @ basis.T).T), np.cov((b @ basis.T).T)
    shift = a.mean(axis=0) - b.mean(axis=0)
    roots = np.sqrt(np.maximum(np.linalg.eigvals(first @ second).real, 0)).sum()
    naive = shift @ shift + np.trace(first) + np.trace(second) - 2 * roots
    assert frechet_distance(a, b) == pytest.approx(naive, rel=1e-5)


@given(st.integers(0, 1000), st.integers(2, 40), st.integers(1, 30))
@settings(max_examples=40)
def test_frechet_distance_is_symmetric_zero_on_itself_and_shifts_by_the_square(seed, n, d):
    a, b = normal(seed, n, d), normal(seed + 1, n + 3, d)
    assert frechet_distance(a, a) == pytest.approx(0, abs=1e-9 * d)
    assert frechet_distance(a, b) == pytest.approx(frechet_distance(b, a))
    assert frechet_distance(a, a + 2) == pytest.approx(4 * d, rel=1e-6)


def test_few_points_bias_the_frechet_distance_as_documented():
    apart = [frechet_distance(normal(0, n, 64), normal(1, n, 64)) for n in (50, 400)]
    assert apart[0] > 5 * apart[1] > 0


def naive_manifold(real, made, k):
    within = {
        name: np.sort(cdist(points, points), axis=1)[:, k]
        for name, points in (("real", real), ("made", made))
    }
    distance = cdist(real, made)
    in_real, in_made = distance <= within["real"][:, None], distance <= within["made"]
    return (
        in_real.any(axis=0).mean(),
        in_made.any(axis=1).mean(),
        in_real.sum() / (k * len(made)),
        in_real.any(axis=1).mean(),
    )


@pytest.mark.parametrize("k", [1, 3, 5])
@pytest.mark.parametrize("chunk", [100, 2**23])
def test_neighbourhoods_are_those_of_plain_loops(k, chunk, monkeypatch):
    monkeypatch.setattr(embedding, "CHUNK_DISTANCES", chunk)
    real, made = normal(0, 60, 3), normal(1, 45, 3, shift=0.5)
    assert precision_recall_density_coverage(real, made, k) == pytest.approx(naive_manifold(real, made, k))


def test_neighbourhoods_by_hand():
    # Real 0, 1, 3 with k = 1: balls [-1, 1], [0, 2], [1, 5]. Made 0.5, 4, 9, 10: balls of 3.5, 3.5, 1, 1.
    real, made = np.array([[0.0], [1.0], [3.0]]), np.array([[0.5], [4.0], [9.0], [10.0]])
    got = precision_recall_density_coverage(real, made, k=1)
    assert got.precision == 2 / 4
    assert got.recall == 1
    assert got.density == 3 / 4
    assert got.coverage == 1


def test_coverage_and_density_of_one_distribution_are_as_published():
    # Naeem et al. 2020, Sec. 3.3: 1 and 1 - 2^-k.
    got = precision_recall_density_coverage(normal(0, 1500, 16), normal(1, 1500, 16), k=5)
    assert got.density == pytest.approx(1, abs=0.05)
    assert got.coverage == pytest.approx(1 - 2**-5, abs=0.015)


def test_a_lost_mode_lowers_recall_and_coverage_but_not_precision():
    real = np.concatenate([normal(0, 300, 2), normal(1, 300, 2, shift=20)])
    made = normal(2, 600, 2)
    got = precision_recall_density_coverage(real, made)
    assert got.precision > 0.9
    assert got.recall < 0.55
    assert got.coverage < 0.55


def test_two_samples_of_one_distribution_cannot_be_distinguished():
    got = two_sample_accuracy(normal(0), normal(1))
    assert got.low < 0.5 < got.high
    assert got.accuracy == pytest.approx(0.5, abs=0.05)
    assert two_sample_accuracy(normal(0), normal(1, shift=5)).accuracy == 1


def test_copies_are_far_below_one_half():
    points = normal(0)
    assert two_sample_accuracy(points, points + 1e-6).accuracy < 1 / 300  # drawn without its copy: 1 in 400


def test_pieces_of_one_recording_are_not_neighbours():
    # Each of 40 recordings lies somewhere, its 10 pieces close around: all real, from one distribution.
    recordings = np.repeat(normal(0, 40), 10, axis=0) + normal(1, scale=0.01)
    ids = np.repeat(np.arange(40), 10)
    one, other = recordings[:200], recordings[200:]
    assert two_sample_accuracy(one, other).accuracy > 0.95
    fair = two_sample_accuracy(one, other, one_groups=list(ids[:200]), other_groups=list(ids[200:]))
    assert fair.low < 0.5 < fair.high
    assert fair.high - fair.low == pytest.approx(0.3, abs=0.05)  # 40 answers, not 400


@pytest.mark.parametrize(("groups", "others"), [(2, 2), (2, 6), (6, 2), (3, 12), (12, 12)])
@pytest.mark.parametrize("spread", [0.01, 1.0])
def test_guessing_is_one_half_however_few_recordings_there_are(groups, others, spread):
    shares = []
    for seed in range(150):
        rng = np.random.default_rng([seed, groups, others])
        centres = np.repeat(rng.standard_normal((groups + others, 3)), 4, axis=0)
        points = centres + spread * rng.standard_normal(centres.shape)
        ids = list(np.repeat(np.arange(groups + others), 4))
        one, other = slice(0, 4 * groups), slice(4 * groups, None)
        got = two_sample_accuracy(points[one], points[other], one_groups=ids[one], other_groups=ids[other])
        shares.append(got.accuracy)
    assert np.mean(shares) == pytest.approx(0.5, abs=0.04)


def test_what_does_not_fit_is_refused():
    a = normal(0)
    with pytest.raises(ParameterError, match=r"with equally many features, got \(400, 8\) and \(400, 7\)"):
        frechet_distance(a, a[:, 1:])
    with pytest.raises(ParameterError, match="both sets must have at least 2 points, got 400 and 1"):
        frechet_distance(a, a[:1])
    with pytest.raises(ParameterError, match="finite"):
        frechet_distance(a, np.where(a > 2, np.nan, a))
    with pytest.raises(ParameterError, match="must have at least 6 points"):
        precision_recall_density_coverage(a, a[:5])
    with pytest.raises(ParameterError, match="k must be >= 1"):
        precision_recall_density_coverage(a, a, k=0)
    with pytest.raises(ParameterError, match="equally many points, got 400 and 399"):
        two_sample_accuracy(a, a[:-1])
    with pytest.raises(ParameterError, match="one per point"):
        two_sample_accuracy(a, a, one_groups=[1])
    with pytest.raises(ParameterError, match="at least 2 groups"):
        two_sample_accuracy(a, a, one_groups=[1] * 400)
