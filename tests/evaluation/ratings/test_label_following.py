import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.evaluation.ratings.label_following import label_fidelity


def test_what_repeats_its_label_follows_it():
    asked = np.array([[0.0, 0.2], [0.5, 0.4], [1.0, 0.9]])
    found = label_fidelity(asked, np.repeat(asked[:, None], 4, 1))
    assert found.error == 0
    assert found.correlation == pytest.approx(1)
    assert found.slope == pytest.approx(1)
    assert found.by_word == pytest.approx((1, 1))
    others = [np.abs(asked[a] - asked[b]).mean() for a in range(3) for b in range(3) if a != b]
    assert found.error_of_others == pytest.approx(np.mean(others))


def test_what_ignores_its_label_has_one_error_for_all_and_no_correlation():
    """A mean-only answer errs little, and follows nothing."""
    asked = np.random.default_rng(0).random((12, 10))
    found = label_fidelity(asked, np.broadcast_to(asked.mean(0), (12, 8, 10)))
    assert found.correlation == pytest.approx(0, abs=1e-9)
    assert found.slope == pytest.approx(0, abs=1e-9)
    assert found.error == pytest.approx(found.error_of_others)


def test_a_word_answered_the_wrong_way_round_is_seen():
    asked = np.array([[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]])
    said = np.stack([asked[:, 0], 1 - asked[:, 1]], 1)[:, None]
    assert label_fidelity(asked, said).by_word == pytest.approx((1, -1))
    assert label_fidelity(asked, said).correlation == pytest.approx(0)


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(ParameterError, match="at least 3 labels"):
        label_fidelity(np.zeros((2, 3)), np.zeros((2, 1, 3)))


def test_a_hair_the_right_way_beside_much_noise_is_no_following():
    """Means over the same noises would correlate by 1."""
    rng = np.random.default_rng(0)
    asked = rng.random((12, 10))
    said = 0.01 * asked[:, None] + rng.standard_normal((1, 8, 10))
    found = label_fidelity(asked, said)
    assert abs(found.correlation) < 0.05
    assert found.slope == pytest.approx(0.01)
