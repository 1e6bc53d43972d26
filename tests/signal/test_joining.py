import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.signal import lfilter
from tests.signal.seams import seam_excess_db

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.joining import _crossfade, extend, join

RATE = 1000


def noise(seed, samples=4000, axes=1, level=1.0):
    x = np.random.default_rng(seed).standard_normal((axes, samples + 200))
    x = lfilter([1], [1, -1.6, 0.8], x, axis=1)[:, 200:]
    return Signal((level * x / x.std()).astype(np.float32), RATE, "m/s^2")


def power(x):
    return np.mean(np.square(x, dtype=np.float64), axis=-1)


@given(st.floats(-0.85, 1.0), st.floats(0.2, 5.0), st.integers(0, 1000))
@settings(deadline=None, max_examples=40)
def test_the_power_is_kept_whatever_the_correlation(correlation, level, seed):
    rng = np.random.default_rng(seed)
    a, other = rng.standard_normal((2, 1, 20_000))
    b = level * (correlation * a + np.sqrt(1 - correlation**2) * other)
    blocks = power(_crossfade(a, b).reshape(10, 2000))
    rise = np.sin(np.pi / 2 * (np.arange(10) + 0.5) / 10) ** 2
    u, v = (1 - rise) ** 2, rise**2
    np.testing.assert_allclose(blocks, (u + v * level**2) / (u + v), rtol=0.2)
    assert np.all(blocks > 0.75 * min(1, level**2))
    assert np.all(blocks < 1.25 * max(1, level**2))


def test_alike_pieces_are_joined_to_what_they_were_cut_from():
    x = noise(0)
    joined = join([x.cut(0, 2200), x.cut(2000, 4000)], overlap_s=0.2)
    np.testing.assert_allclose(joined.samples, x.samples, atol=2e-6)


def test_pieces_of_one_level_keep_it_on_every_axis():
    scale = np.array([[1.0], [0.1], [7.0]])
    pieces = [noise(seed, 1000, axes=3) for seed in range(40)]
    pieces = [p.with_samples(p.samples * scale) for p in pieces]
    joined = join(pieces, overlap_s=0.4)
    np.testing.assert_allclose(np.sqrt(power(joined.samples)), scale[:, 0], rtol=0.1)
    inside = [joined.samples[:, k * 600 : k * 600 + 400] for k in range(1, 39)]
    outside = [joined.samples[:, k * 600 + 400 : (k + 1) * 600] for k in range(1, 39)]
    ratio = power(np.hstack(inside)) / power(np.hstack(outside))
    np.testing.assert_allclose(10 * np.log10(ratio), 0, atol=0.6)


def test_opposed_pieces_stay_finite_and_bounded():
    x = noise(1)
    joined = join([x, x.with_samples(-x.samples)], overlap_s=1.0)
    assert np.abs(joined.samples).max() <= 3.2 * np.abs(x.samples).max()


def test_gravity_stays_and_does_not_make_unlike_pieces_look_alike():
    pieces = [noise(seed, 1000).samples + 9.81 * 20 for seed in range(40)]
    joined = join([Signal(x, RATE, "m/s^2") for x in pieces], overlap_s=0.4).samples[0]
    inside = np.hstack([joined[k * 600 : k * 600 + 400] for k in range(1, 39)])
    assert inside.mean() == pytest.approx(9.81 * 20, rel=1e-3)
    assert 10 * np.log10(inside.var()) == pytest.approx(0, abs=0.6)


def test_silence_fades_into_a_signal():
    x = noise(2)
    joined = join([x.with_samples(np.zeros((1, 1000))), x], overlap_s=0.5)
    assert np.all(joined.samples[0, :500] == 0)
    np.testing.assert_array_equal(joined.samples[0, 1000:], x.samples[0, 500:])


def test_the_search_finds_where_a_piece_goes_on_and_moves_all_axes_by_one_lag():
    x = noise(3, axes=3)
    joined = join([x.cut(0, 2000), x.cut(1863, 4000)], overlap_s=0.1, search_s=0.06)
    np.testing.assert_allclose(joined.samples, x.samples, atol=2e-6)  # 37 samples were left out


@given(st.integers(1, 9000), st.integers(0, 300), st.integers(0, 200))
@settings(deadline=None, max_examples=30)
def test_the_length_is_exact(samples, overlap, search):
    pieces = {"overlap_s": overlap / RATE, "search_s": search / RATE}
    made = extend(lambda k: noise(k, 700), seconds=samples / RATE, **pieces)
    assert len(made) == samples


def test_extending_is_joining():
    made = extend(lambda k: noise(k, 900), seconds=5.0, overlap_s=0.1, search_s=0.05)
    whole = join([noise(k, 900) for k in range(9)], overlap_s=0.1, search_s=0.05)
    np.testing.assert_array_equal(made.samples, whole.samples[:, :5000])


def test_a_joined_signal_is_as_long_as_its_pieces_less_the_crossfades():
    assert len(join([noise(k, 500 + k) for k in range(5)], overlap_s=0.1)) == 5 * 500 + 10 - 4 * 100
    assert len(join([noise(0, 150)] * 4, overlap_s=0.1)) == 4 * 150 - 3 * 100


def test_repetition_shows_at_its_seams_and_crossfades_do_not():
    plain, faded = [], []
    for seed in range(40):
        x = noise(seed)
        again = x.with_samples(np.tile(x.samples, 10))
        np.testing.assert_array_equal(again.samples[0, 4000:8000], x.samples[0])
        plain.append(seam_excess_db(again, [4000 * k for k in range(1, 10)]))
        joined = join([x] * 10, overlap_s=0.2)
        seams = [k * 3800 + n for k in range(1, 10) for n in range(200)]
        faded.append(seam_excess_db(joined, seams))
    # One seam is one draw: over many, 1 / (1 - r) = 9.5 dB for neighbours correlated by r = 1.6 / 1.8.
    assert 10 * np.log10(np.mean(10 ** (np.array(plain) / 10))) == pytest.approx(9.5, abs=2)
    assert np.abs(faded).max() < 2
    assert abs(np.mean(faded)) < 0.3


def test_a_seam_excess_by_hand():
    x = Signal(np.array([[0, 1, 0, 1, 11, 10, 11]], dtype=np.float32), RATE, "m/s^2")
    assert seam_excess_db(x, [4]) == pytest.approx(20.0)
    assert seam_excess_db(x.cut(0, 4), [2]) == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: join([], overlap_s=0.1), "at least one piece"),
        (lambda: join([noise(0), noise(1, axes=3)], overlap_s=0.1), "one rate, unit, set of axes and domain"),
        (lambda: join([noise(0), noise(1, 50)], overlap_s=0.1), "piece 1 must have at least 100 samples"),
        (lambda: join([noise(0)], overlap_s=-1), "overlap_s must be >= 0"),
        (lambda: join([noise(0)], overlap_s=0.1, search_s=np.nan), "search_s must be >= 0"),
        (lambda: extend(lambda k: noise(k, 100), seconds=1, overlap_s=0.1), "longer than overlap_s"),
        (lambda: extend(noise, seconds=0, overlap_s=0.1), "seconds must be > 0"),
    ],
)
def test_what_cannot_be_joined_is_refused(call, message):
    with pytest.raises(ParameterError, match=message):
        call()
