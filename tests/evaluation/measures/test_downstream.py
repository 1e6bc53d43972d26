import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import classifier_features, segments, transfer_accuracy
from tactogram.signal import Signal


@pytest.fixture
def sets(texture):
    """Return a function that draws three materials: two of one spectrum and level, one in bursts, and another."""

    def draw(seed, count=4):
        def members(first, **kind):
            return segments([texture(seed + first + k, **kind) for k in range(count)], 2.0)

        return {
            "even": members(0),
            "bursts": members(100, burst_hz=8, gain=2.0),
            "low": members(200, centre=60.0),
        }

    return draw


def test_materials_of_one_spectrum_are_distinguished_by_their_envelope(sets):
    got = transfer_accuracy(sets(0), sets(1000))
    assert got.accuracy == 1
    assert got.low == pytest.approx(0.862, abs=0.001)  # Wilson, 24 of 24


def test_generated_without_envelope_they_are_confused(sets, even):
    # The same level and spectrum, random phases: "bursts" and "even" are no longer two things.
    real = sets(0)
    made = {name: [even(s, k) for k, s in enumerate(members)] for name, members in sets(500).items()}
    assert transfer_accuracy(real, made).accuracy == pytest.approx(2 / 3, abs=0.05)
    assert transfer_accuracy(made, real).accuracy < 0.9


def test_a_level_error_lowers_the_accuracy(sets):
    made = {name: [s.with_samples(100 * s.samples) for s in part] for name, part in sets(500).items()}
    assert transfer_accuracy(sets(0), made).accuracy < 1


def test_any_classifier_can_be_used(sets):
    seen = []

    def fit(signals, labels):
        seen.append((len(signals), sorted(set(labels))))
        return lambda others: ["even"] * len(others)

    got = transfer_accuracy(sets(0), sets(1000), fit=fit)
    assert got.accuracy == pytest.approx(1 / 3)
    assert seen == [(24, ["bursts", "even", "low"])]


def test_each_material_counts_the_same(sets):
    tested = sets(1000)
    tested["even"] = tested["even"] * 5
    got = transfer_accuracy(sets(0), tested, fit=lambda *_: lambda others: ["even"] * len(others))
    assert got.accuracy == pytest.approx(1 / 3)


def test_features_are_one_row_per_signal_and_include_the_level(texture):
    one = texture(0)
    rows = classifier_features([one, one.with_samples(10 * one.samples), one.cut(500)])
    bands, modulations = 14, 4
    assert rows.shape == (3, 3 * (bands + modulations))
    split = rows.reshape(3, 3, -1)
    np.testing.assert_allclose(split[1, :, :bands] - split[0, :, :bands], 20, atol=1e-3)
    np.testing.assert_allclose(split[1, :, bands:], split[0, :, bands:], atol=1e-3)


def test_features_stay_in_the_order_of_the_signals(texture):
    signals = [texture(k, seconds=(1, 2, 1.5)[k % 3]) for k in range(7)]
    alone = np.concatenate([classifier_features([signal]) for signal in signals])
    np.testing.assert_allclose(classifier_features(signals), alone)


def test_what_does_not_fit_is_refused(sets):
    real = sets(0)
    with pytest.raises(ParameterError, match="trained must hold at least two materials"):
        transfer_accuracy({"even": real["even"]}, {"even": real["even"]})
    with pytest.raises(ParameterError, match="lacks wood"):
        transfer_accuracy(real, {"wood": real["even"]})
    with pytest.raises(ParameterError, match="got 2 kinds"):
        transfer_accuracy(real, {"even": [Signal(np.ones(500), 500, "1")]})
    with pytest.raises(ParameterError, match="at least one signal, got none"):
        transfer_accuracy(real, {"even": []})
