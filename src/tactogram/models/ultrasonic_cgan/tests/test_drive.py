"""From words, and a vibration, to a loop for the display."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.model import unit_scores

ROUGH, STICKY = {"rough": 6.4, "sticky": 2.0}, {"rough": 2.0, "sticky": 6.0}


def test_the_model_is_that_of_the_cluster_nearest_in_words(learner):
    rough, sticky = (learner.selection_for({"words": words}, 3) for words in (ROUGH, STICKY))
    assert (rough["surface"], rough["cluster"]) == ("plate01", 1)
    assert (sticky["surface"], sticky["cluster"]) == ("plate03", 2)
    assert sticky["cluster_surfaces"] == ["plate03"]
    assert sticky["sensor_spectrum"]["recording"].startswith("plate03")
    assert sticky["distance"] == pytest.approx(np.hypot(0.1 - 1 / 6, 0.9 - 5 / 6), abs=0.1)
    assert 0 <= rough["clamped_amplitude"] <= rough["clamped_bins"] <= 1


def test_a_surfaces_own_means_are_at_no_distance(kind, learner):
    means = 1 + 6 * learner.surfaces.means[1]
    facts = learner.selection_for({"words": dict(zip(kind.words, means, strict=True))}, 0)
    assert facts["surface"] == "plate02"
    assert facts["distance"] == pytest.approx(0, abs=1e-12)


def test_a_loop_has_the_generated_amplitudes_and_no_bin_below_zero(kind, learner):
    spectrum = learner._make({"words": ROUGH}, 1)
    signal = learner.generate({"words": ROUGH}, seed=1)
    got = np.abs(np.fft.rfft(signal.samples[0].astype(float))) / 250
    np.testing.assert_allclose(got[1:61], spectrum.amplitudes, atol=1e-6 * spectrum.amplitudes.max())
    assert spectrum.amplitudes.min() >= 0
    assert (signal.rate, signal.unit, signal.axes, len(signal)) == (kind.rate, "1", ("drive",), 500)


def test_longer_signals_are_whole_loops_and_shorter_ones_the_beginning(learner):
    turn = learner.generate({"words": ROUGH}, seed=1).samples
    longer = learner.generate({"words": ROUGH}, seconds=2.5, seed=1).samples
    np.testing.assert_array_equal(longer, np.concatenate((turn, turn, turn[:, :250]), axis=1))
    shorter = learner.generate({"words": ROUGH}, seconds=0.3, seed=1).samples
    np.testing.assert_array_equal(shorter, turn[:, :150])


def test_random_phases_have_a_higher_crest_factor(trained):
    learner = trained()
    low = learner.selection_for({"words": ROUGH}, 5)["crest_factor"]
    learner.config = learner.config.model_copy(update={"phase": "random"})
    assert learner.selection_for({"words": ROUGH}, 5)["crest_factor"] > 1.2 * low


def test_a_vibration_of_ones_own_goes_in_instead_of_a_stored_one(measurement, learner):
    vibration = measurement(1, 5, 0, 0).signal
    facts = [learner.selection_for({"words": ROUGH, "vibration": vibration}, seed) for seed in range(8)]
    assert {fact["sensor_spectrum"]["of"] for fact in facts} == {"vibration"}
    assert len({fact["sensor_spectrum"]["axis"] for fact in facts}) > 1
    assert facts[3] == learner.selection_for({"words": ROUGH, "vibration": vibration}, 3)
    with pytest.raises(ParameterError, match="condition 'vibration': signal must last 1 s"):
        learner.generate({"words": ROUGH, "vibration": vibration.cut(0, 100)}, seed=0)


def test_scores_are_normalised_as_published(kind):
    """Sec. IV-A: from 1 to 7 to 0 to 1, (x - 1) / 6."""
    np.testing.assert_allclose(unit_scores({"sticky": 7, "rough": 2.5}, kind), [0.25, 1.0])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"rough": 3}, "a score is needed of sticky"),
        ({"rough": 3, "sticky": 2, "loud": 3}, "words must be of rough, sticky, got 'loud'"),
        ({"rough": 8, "sticky": 2}, "rough must be 1 to 7, got 8"),
        ({"rough": float("nan"), "sticky": 2}, "got nan"),
    ],
)
def test_words_that_cannot_be_answered_are_refused(kind, words, message):
    with pytest.raises(ParameterError, match=message):
        unit_scores(words, kind)
