"""Numbers of the paper, and inputs of the discriminator that contradict each other."""

import pytest

from tactogram.models.tactile_image_cgan.config import Config

PAPER = {
    "noise": 100, "widths": (512, 256, 128, 64), "size": 64, "leak": 0.2, "image_weight": 5000,
    "learning_rate": 0.002, "betas": (0.5, 0.999), "epsilon": 1e-8, "batch_size": 32, "updates": 1000,
}  # fmt: skip
"""Hatori et al. 2025, Sec. II-C, Tables 2 to 4, Fig. 5."""


def test_the_recipe_paper_has_the_papers_numbers(paper_values):
    assert paper_values("tactile_image_cgan", PAPER) == PAPER


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"regression_weight": 1.0}, "must be 0 unless label_input is 'projection' or 'none'"),
        ({"label_input": "none"}, "regression_weight must be > 0 with label_input 'none'"),
    ],
)
def test_a_regression_that_would_see_its_answer_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        Config(**changes)
