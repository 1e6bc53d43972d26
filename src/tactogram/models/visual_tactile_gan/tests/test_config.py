"""Numbers of the paper, and what follows from them."""

import pytest

from tactogram import models
from tactogram.models.visual_tactile_gan.config import Config
from tactogram.recipe import Preparation, Recipe

PAPER = {
    "widths": (64, 128, 256, 512, 512, 512, 512, 512), "discriminators": 3, "layers": 3, "width": 64, "gain": 0.02,
    "l1": 10, "feature_matching": 40, "batch_size": 32, "learning_rate": 2e-4, "betas": (0.5, 0.999),
    "epochs": 200, "constant": 0.5, "choose_by": "lpips", "label": "predicted", "steps": None,
    "predictor.trunk": "densenet201", "predictor.hidden": 256, "predictor.leak": 0.01, "predictor.scale": 1.5,
    "predictor.batch_size": 64, "predictor.epochs": 30, "predictor.halve_every": 5,
    "predictor.learning_rate": 2e-4, "predictor.betas": (0.5, 0.999), "pairs.n_fft": 512, "pairs.hop": 128,
    "pairs.frames": 256, "pairs.size": 256, "pairs.crop": 256, "pairs.per_photo": 10, "pairs.per_recording": 10,
    "pairs.repeats": 10,
}  # fmt: skip
"""Neshov et al. 2026, Sec. 3.1, 3.2 and 4.1, Tables 1 and 2."""


def test_the_recipe_paper_has_the_papers_numbers(paper_values):
    assert paper_values("visual_tactile_gan", PAPER) == PAPER


def test_recipes_learn_the_z_axis_and_ablations_omit_one_part_of_the_paper():
    """Sec. 4.1: "only the Z-axis signal is considered"; Table 4, rows "W/o" and "Single Discriminator"."""
    facts = models.find("visual_tactile_gan")
    changes = {
        "no-cbn": {"conditional": False}, "no-l1": {"l1": 0}, "no-fm": {"feature_matching": 0},
        "one-discriminator": {"discriminators": 1},
    }  # fmt: skip
    published = Recipe.load(facts.recipe("paper"))
    assert published.prepare == Preparation(axes=("z",))
    assert {name for name in facts.recipes() if name.startswith("ablation")} == {
        f"ablation-{k}" for k in changes
    }
    for name, change in changes.items():
        recipe = Recipe.load(facts.recipe(f"ablation-{name}"))
        assert recipe.prepare == published.prepare
        assert facts.config(recipe.config) == facts.config(published.config | change)


def test_bands_are_not_matched_without_a_label():
    with pytest.raises(ValueError, match="match_bands needs the label"):
        Config(match_bands=True, conditional=False)
