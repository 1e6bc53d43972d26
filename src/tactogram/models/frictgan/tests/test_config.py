"""Numbers of the paper, and sizes that do not fit together."""

import pytest
from pydantic import ValidationError

from tactogram.models.frictgan import Config

PAPER = {
    "pixels": 1024, "offset": 2, "windows": 600, "shares": (2 / 3, 1 / 6, 1 / 6), "n_fft": 512, "hop": 128,
    "bins": 257, "frames": 11, "latent": 128, "noise": 50, "encoder_dropout": 3, "loss": "wasserstein", "l1": 100,
    "learning_rate": 5e-5, "critic_learning_rate": None, "batch_size": 2,
}  # fmt: skip
"""Cai et al. 2020, Sec. 3.1, 3.2 and 4."""


def test_the_recipe_paper_has_the_papers_numbers(paper_values):
    assert paper_values("frictgan", PAPER) == PAPER


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"pixels": 1000}, "multiple of the product of strides"),
        ({"latent": 0}, "noise joins the latent vector"),
        ({"n_fft": 32, "hop": 8}, "n_fft must be at least 64"),
        ({"pixels": 256, "strides": (2, 2, 2, 2, 2, 2, 2)}, "cannot be cropped"),
        ({"channels": (8, 8)}, "equally many"),
        ({"shares": (0.5, 0.2, 0.1)}, "add up to 1"),
    ],
)
def test_what_does_not_fit_together_is_refused(values, message):
    with pytest.raises((ValidationError, ValueError), match=message):
        Config(**values)
