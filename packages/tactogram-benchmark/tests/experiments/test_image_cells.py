"""Rated plates: mean scores, and too few."""

import numpy as np
import pytest
from made_up_images import PLATES, loop, rated

from tactogram.datasets import Recording, create_store
from tactogram.datasets.ratings.ratings import SEVEN_POINT
from tactogram.errors import ParameterError
from tactogram_benchmark.experiments.image_cells import plates_of


def made(folder, plates, ratings):
    strains = [Recording(streams={"strain": loop(n)}, material=name) for n, name in enumerate(plates)]
    return create_store(folder, strains, name="plates", licence="-", simulated=True, ratings=ratings)


def test_plates_have_their_mean_scores(tmp_path):
    """Hatori et al. 2025, Sec. II-C: "the normalized average tactile evaluation scores of the metal plate samples"."""
    ratings = rated(PLATES, SEVEN_POINT, 2)
    plates = plates_of(made(tmp_path / "s", (*PLATES, "unrated"), ratings))
    assert plates.names == PLATES
    assert plates.words == ratings.words
    assert plates.means.shape == (3, len(ratings.words))
    scores = ratings.score.reshape(2, 3, len(ratings.words))  # rater, plate, word
    np.testing.assert_allclose(plates.means, (scores.mean(0) - 1) / 6)


def test_too_few_plates_are_refused(tmp_path):
    with pytest.raises(ParameterError, match="at least 3 rated surfaces, got 2"):
        plates_of(made(tmp_path / "s", PLATES[:2], rated(PLATES[:2], SEVEN_POINT, 2)))
    with pytest.raises(ParameterError, match="has no ratings of surfaces"):
        plates_of(made(tmp_path / "none", PLATES, None))
