import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.image_spread import ImageSpread, image_spread, mean_distance


def test_distance_is_that_of_every_pair():
    images = np.random.default_rng(0).uniform(-1, 1, (5, 3, 4, 4)).astype(np.float32)
    slow = [np.sqrt(np.mean((images[a] - images[b]) ** 2)) for a in range(5) for b in range(a)]
    assert mean_distance(images) == pytest.approx(np.mean(slow), rel=1e-5)
    assert mean_distance(images[[0, 0]]) == pytest.approx(0, abs=1e-6)


def test_one_image_differs_from_nothing():
    with pytest.raises(ParameterError, match="at least 2 to differ, got 1"):
        mean_distance(np.zeros((1, 3, 4, 4), np.float32))


def test_noise_and_label_are_told_apart():
    """Images of one grey value: the noise times 0.1 plus the label."""

    def make(noises, labels):
        return np.broadcast_to((0.1 * noises + labels)[:, :, None, None], (len(noises), 1, 4, 4))

    labels, noises = np.array([[0.0], [0.5]]), np.array([[0.0], [1.0]])
    found = image_spread(make, labels, noises, real=0.5)
    assert found.by_noise == pytest.approx(0.1)
    assert found.by_label == pytest.approx(0.5)
    assert found.noise_share == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("noise", "label", "said"),
    [
        (0.5, 0.5, ""),
        (0.04, 0.5, "one image per label, whatever the noise"),
        (0.5, 0.04, "the label makes no difference"),
        (0.04, 0.04, "one image for all labels and noises"),
    ],
)
def test_collapse_is_called_what_it_is(noise, label, said):
    spread = ImageSpread(0.5, noise, label)
    assert spread.collapse == said
    assert spread.as_dict()["collapsed"] == bool(said)
