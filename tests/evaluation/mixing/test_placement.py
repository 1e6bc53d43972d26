import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from scipy.optimize import isotonic_regression
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.evaluation.mixing import placement
from tactogram.evaluation.mixing.placement import (
    OVERALL,
    IndistinctEndsError,
    _increasing,
    order_of,
    positions,
    texture_features,
)
from tactogram.signal import Signal

RATE = 1000.0
COUNT = 6


def white(seed, *, gain=1.0, seconds=2.0, axes=1):
    noise = np.random.default_rng(seed).standard_normal((axes, round(RATE * seconds)))
    return Signal(np.asarray(gain).reshape(-1, 1) * noise, RATE, "m/s^2")


def low(seed, gain=1.0):
    return white(seed).with_samples(gain * lfilter([1], [1, -0.9], white(seed).samples))


def high(seed, gain=1.0):
    return white(seed).with_samples(gain * lfilter([1], [1, 0.9], white(seed).samples))


def draw(make, seed, count=COUNT):
    return [make(100 * seed + number) for number in range(count)]


def louder(places, *, low_db=0.0, high_db=20.0, axes=1, count=COUNT):
    """White noise whose level in dB goes from low_db to high_db, at ``places`` of the way, with its ends."""

    def at(place):
        return lambda seed: white(seed, gain=10 ** ((low_db + place * (high_db - low_db)) / 20), axes=axes)

    steps = [draw(at(place), 10 + number, count) for number, place in enumerate(places)]
    return steps, draw(at(0), 1, count), draw(at(1), 2, count)


def test_a_level_that_rises_evenly_in_db_lies_evenly():
    places = np.linspace(0, 1, 5)
    ladder = positions(*louder(places))
    np.testing.assert_allclose(ladder.position[:, -1], places, atol=0.03)
    np.testing.assert_allclose(ladder.off_line[:, -1], 0, atol=0.06)
    assert ladder.monotone.all()
    assert ladder.half_weight[-1] == pytest.approx(0.5, abs=0.03)
    # 20 dB in each of 14 bands, nothing in 10 depths of modulation.
    assert ladder.distance_db[-1] == pytest.approx(20 * np.sqrt(14 / 24), rel=0.03)


def test_the_louder_of_two_powers_dominates():
    weights = np.linspace(0, 1, 6)
    power = (1 - weights) + 100 * weights
    steps, start, end = louder(10 * np.log10(power) / 20)
    ladder = positions(steps, start, end, weights=weights)
    np.testing.assert_allclose(ladder.position[:, -1], 10 * np.log10(power) / 20, atol=0.03)
    assert ladder.position[1, -1] == pytest.approx(0.66, abs=0.03)
    # Linearly between the steps at 0 and 0.2.
    assert ladder.half_weight[-1] == pytest.approx(0.2 * 0.5 / 0.659, abs=0.01)


def test_a_power_mix_of_two_spectra_lies_where_their_spectra_say():
    weights = np.linspace(0, 1, 5)

    def mixed(w):
        return lambda seed: low(seed).with_samples(
            np.sqrt(1 - w) * low(seed).samples + np.sqrt(w) * high(seed + 50).samples
        )

    steps = [draw(mixed(w), 10 + k) for k, w in enumerate(weights)]
    ladder = positions(steps, draw(low, 1), draw(high, 2), weights=weights)
    edges = np.geomspace(20, 500, 15)
    f = np.linspace(20, 500, 20001)
    z = np.exp(-2j * np.pi * f / RATE)
    ends = [np.abs(1 / (1 - 0.9 * z)) ** 2, np.abs(1 / (1 + 0.9 * z)) ** 2]
    band = np.digitize(f, edges[1:-1])
    mixes = [(1 - w) * ends[0] + w * ends[1] for w in weights]
    level = [10 * np.log10([mix[band == k].mean() for k in range(14)]) for mix in mixes]
    way = level[-1] - level[0]
    expected = [(row - level[0]) @ way / (way @ way) for row in level]
    np.testing.assert_allclose(ladder.position[:, -1], expected, atol=0.05)
    # Powers add, decibels do not: half way, each end's own bands are almost as loud as at that end.
    assert ladder.off_line[2, -1] > 0.2
    assert ladder.off_line[0, -1] < 0.1 > ladder.off_line[-1, -1]


def test_a_jump_is_monotone_and_shows_as_one_rise():
    ladder = positions(*louder([0, 0, 0, 1, 1, 1]))
    assert ladder.monotone[-1]
    assert ladder.largest_rise[-1] == pytest.approx(1, abs=0.03)
    assert ladder.largest_drop[-1] < 0.02
    assert ladder.half_weight[-1] == pytest.approx(0.5, abs=0.01)


def test_a_drop_beyond_the_spread_is_not_monotone():
    ladder = positions(*louder([0, 0.3, 0.7, 0.5, 0.8, 1]))
    assert not ladder.monotone[-1]
    assert ladder.monotone_p[-1] < 0.01
    assert ladder.tau[-1] == pytest.approx(1 - 2 / 15)
    assert ladder.largest_drop[-1] == pytest.approx(0.2, abs=0.03)


def test_a_drop_within_the_spread_is_not_held_against_it():
    places = [0, 0.4, 0.8, 0.7, 1]
    rng = np.random.default_rng(5)
    steps, start, end = louder(places)
    steps = [[s.with_samples(s.samples * 10 ** rng.normal(0, 0.3)) for s in step] for step in steps]
    ladder = positions(steps, start, end)
    assert ladder.spread[:, -1].min() > 0.1
    assert ladder.resolution[-1] > 0.1
    assert ladder.monotone_p[-1] > 0.05


def test_what_stays_put_does_not_move_one_way():
    ladder = positions(*louder([0.5] * 6))
    assert not ladder.monotone[-1]
    assert ladder.monotone_p[-1] > 0.05
    assert ladder.tau_low[-1] < 0 < ladder.tau_high[-1]


def test_what_is_neither_is_off_the_line():
    """Between the ends in level, but with a spectrum that neither has."""
    steps, start, end = louder([0, 0.5, 1])
    tilt = np.where(np.arange(14) % 2, 1.0, -1.0)
    edges = np.geomspace(20, 500, 15)

    def striped(seed):
        spectrum = np.fft.rfft(white(seed, gain=10**0.5).samples)
        f = np.fft.rfftfreq(2000, 1 / RATE)
        band = np.clip(np.searchsorted(edges, f) - 1, 0, 13)
        return white(seed).with_samples(np.fft.irfft(spectrum * 10 ** (10 * tilt[band] / 20), 2000))

    ladder = positions([steps[0], draw(striped, 40), steps[2]], start, end)
    assert 0.4 < ladder.position[1, -1] < 0.8  # what leaks into the quiet bands makes it louder
    assert 0.25 < ladder.off_line[1, -1] < 0.8
    assert ladder.off_line[0, -1] < 0.1


def test_axes_are_told_apart_and_weighed_by_how_far_the_ends_are():
    def at(x_db, z_db):
        return lambda seed: white(seed, axes=3, gain=[10 ** (x_db / 20), 1.0, 10 ** (z_db / 20)])

    start, end = draw(at(0, 0), 1), draw(at(20, 10), 2)
    steps = [draw(at(0, 0), 11), draw(at(20, 0), 12), draw(at(20, 10), 13)]
    ladder = positions(steps, start, end)
    assert ladder.columns == ("x", "y", "z", OVERALL)
    np.testing.assert_allclose(ladder.position[:, 0], [0, 1, 1], atol=0.05)
    np.testing.assert_allclose(ladder.position[:, 2], [0, 0, 1], atol=0.05)
    assert ladder.position[1, 3] == pytest.approx(400 / 500, abs=0.03)
    assert np.isnan(ladder.position[:, 1]).all()
    assert not ladder.monotone[1]
    figures = ladder.as_dict()
    assert figures["position"]["y"] == [None, None, None]
    assert {name: figures["monotone"][name] for name in "xy"} == {"x": True, "y": None}
    assert figures["weights"] == [0, 0.5, 1]


def test_the_level_can_be_left_out():
    def at(gain, make):
        return lambda seed: make(seed, gain)

    steps = [draw(at(1, low), 11), draw(at(30, low), 12), draw(at(1, high), 13)]
    start, end = draw(at(1, low), 1), draw(at(1, high), 2)
    assert positions(steps, start, end, level=False).position[1, -1] == pytest.approx(0, abs=0.05)
    assert positions(steps, start, end).off_line[1, -1] > 1


def test_envelopes_alone_make_a_way():
    def gated(depth):
        def make(seed):
            gate = 1 + depth * np.sin(2 * np.pi * 8 * np.arange(2000) / RATE)
            return white(seed).with_samples(white(seed).samples * gate / np.sqrt(1 + depth**2 / 2))

        return make

    steps = [draw(gated(d), 10 + k) for k, d in enumerate((0, 0.2, 0.9))]
    ladder = positions(steps, draw(gated(0), 1), draw(gated(0.9), 2), level=False)
    assert ladder.monotone[-1]
    assert 0.15 < ladder.position[1, -1] < 0.85


def test_what_never_gets_half_way_has_no_half_weight():
    steps, start, end = louder([0, 0.1, 0.2, 0.3])
    ladder = positions(steps, start, end)
    assert np.isinf(ladder.half_weight[-1])
    assert ladder.as_dict()["half_weight"][OVERALL] is None


def test_chance_does_not_pull_the_ends_inwards(monkeypatch):
    """A few noisy signals make the ends' means uncertain; steps at the ends must still lie there on average."""
    monkeypatch.setattr(placement, "DRAWS", 9)  # of what is not looked at here
    found = []
    for seed in range(12):
        rng = np.random.default_rng(seed)

        def at(db, rng=rng):
            return [white(rng.integers(2**32), gain=10 ** ((db + rng.normal(0, 3)) / 20)) for _ in range(3)]

        found.append(positions([at(0), at(9)], at(0), at(9) + at(9)).position[:, -1])
    np.testing.assert_allclose(np.median(found, axis=0), [0, 1], atol=0.25)


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(gain=st.floats(0.01, 100), seed=st.integers(0, 100))
def test_the_unit_of_all_signals_changes_nothing(monkeypatch, gain, seed):
    monkeypatch.setattr(placement, "DRAWS", 9)  # of what is not looked at here
    steps, start, end = louder([0, 0.4, 1], count=2)
    one = positions(steps, start, end, seed=seed)

    def scaled(part):
        return [signal.with_samples(gain * signal.samples) for signal in part]

    other = positions([scaled(step) for step in steps], scaled(start), scaled(end), seed=seed)
    np.testing.assert_allclose(other.position, one.position, atol=1e-3)


def test_ends_that_are_alike_have_an_error_of_their_own():
    steps, start, _ = louder([0, 1])
    with pytest.raises(IndistinctEndsError):
        positions(steps, start, draw(white, 77))


def test_the_same_seed_gives_the_same_figures():
    parts = louder([0, 0.5, 1], count=2)
    assert positions(*parts, seed=3).as_dict() == positions(*parts, seed=3).as_dict()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"end": "start"}, "the two ends must differ, got .* dB between them and .* dB by chance"),
        ({"end": "same"}, "the two ends must differ"),
        ({"end": "one"}, "must have at least 2 signals"),
        ({"weights": [0, 0, 1]}, "weights must be 3 rising numbers"),
        ({"weights": [0, 1]}, "weights must be 3 rising numbers"),
        ({"weights": [0, np.nan, 1]}, "weights must be 3 rising numbers"),
        ({"end": "slow"}, "one rate, unit and set of axes, got 2 kinds"),
        ({"end": "short"}, r"at least 0.5 s, got 0.1 s"),
    ],
)
def test_what_cannot_be_placed_is_refused_in_one_line(change, message):
    steps, start, end = louder([0, 0.5, 1])
    ends = {
        "start": start,
        "same": draw(white, 77),
        "one": end[:1],
        "slow": [Signal(np.ones(500), 500, "m/s^2")] * 2,
        "short": [signal.cut(0, 100) for signal in end],
    }
    with pytest.raises(ParameterError, match=message) as caught:
        positions(steps, start, ends.get(change.get("end"), end), weights=change.get("weights"))
    assert "\n" not in str(caught.value)


def test_features_are_levels_in_db_and_depths_of_modulation():
    t = np.arange(4000) / RATE
    tone = Signal(2.0 * np.sin(2 * np.pi * 200 * t), RATE, "m/s^2")
    deep = tone.with_samples(tone.samples * (1 + 0.5 * np.sin(2 * np.pi * 8 * t)))
    features = texture_features([tone, deep])
    assert features.shape == (2, 1, 14 + 2 * 5)
    assert 10 * np.log10((10 ** (features[0, 0, :14] / 10)).sum()) == pytest.approx(10 * np.log10(2), abs=0.1)
    depth = features[:, 0, -5:]
    assert depth[1].argmax() == 2  # 8 Hz
    assert depth[1, 2] == pytest.approx(10 * np.log10(0.5**2 / 2), abs=0.3)
    assert depth[0].max() < -30


def test_features_do_not_depend_on_how_long_a_signal_is():
    signals = [signal for d in (8, 2) for signal in draw(lambda s, d=d: white(s, seconds=d), 3, 20)]
    long, short = np.split(texture_features(signals), 2)
    np.testing.assert_allclose(long.mean(axis=0), short.mean(axis=0), atol=1.0)
    assert long.std(axis=0).mean() < 0.7 * short.std(axis=0).mean()


def test_silence_has_finite_features():
    assert np.isfinite(texture_features([Signal(np.zeros(1000), RATE, "m/s^2")])).all()


def test_equal_steps_are_called_dropping_about_one_time_in_twenty():
    rng = np.random.default_rng(1)
    found = []
    for _ in range(60):
        members = [rng.standard_normal(4) for _ in range(5)]
        place = np.array([part.mean() for part in members])
        order = order_of(place, members, np.linspace(0, 1, 5), end_error=np.zeros(2), rng=rng)
        found.append((order["monotone_p"] < 0.05, order["tau_low"] > 0))
    dropping, rising = np.mean(found, axis=0)
    assert 0 < dropping < 0.12
    assert rising < 0.05


def test_a_generator_without_chance_is_judged_by_its_order_alone():
    weights = np.linspace(0, 1, 4)
    for place, p in (([0, 0.2, 0.2, 1], 1.0), ([0, 0.5, 0.4, 1], 0.0)):
        members = [np.full(3, value) for value in place]
        order = order_of(
            np.array(place), members, weights, end_error=np.zeros(2), rng=np.random.default_rng(0)
        )
        assert order["monotone_p"] == p
        assert order["resolution"] < 1e-9


@pytest.mark.parametrize("steps", [2, 5, 11])
def test_increasing_curves_are_those_of_scipy(steps):
    rng = np.random.default_rng(steps)
    counts = rng.integers(2, 9, steps)
    rows = np.linspace(0, 1, steps) + rng.normal(0, 0.4, (50, steps))
    expected = [isotonic_regression(row, weights=counts).x for row in rows]
    np.testing.assert_allclose(_increasing(rows, counts), expected, atol=1e-12)
