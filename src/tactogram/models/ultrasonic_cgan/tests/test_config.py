"""Numbers and names of the paper, and ranges that hold nothing."""

import pytest

from tactogram import models
from tactogram.models.ultrasonic_cgan import Config
from tactogram.recipe import Recipe

PAPER = {
    "stable_s": 2, "hop_s": 0.05, "bins": 1000, "generator_widths": (1024, 512, 256, 128), "dropout_after": (2, 4),
    "dropout": 0.5, "discriminator_widths": (64, 32), "leak": 0.01, "learning_rate": 0.001,
    "betas": (0.9, 0.999), "epsilon": 1e-8, "batch_size": 64, "iterations": 200_000, "rate_low": 0.4,
    "rate_high": 0.6,
}  # fmt: skip
"""Hatori and Takemura, Sec. III-B, IV-A and IV-C, Tables 2 to 4."""


def test_the_recipe_paper_has_the_papers_numbers(paper_values):
    assert paper_values("ultrasonic_cgan", PAPER) == PAPER


@pytest.mark.parametrize(
    ("count", "group"), [(1, "group A"), (4, "group D"), (12, "group E"), (5, "5 clusters")]
)
def test_groups_have_the_names_of_the_paper(count, group):
    assert Config(clusters=count).group == group


@pytest.mark.parametrize(("letter", "clusters"), [("a", 1), ("b", 2), ("c", 3), ("d", 4), ("e", 12)])
def test_a_groups_recipe_differs_from_paper_in_its_clusters_alone(letter, clusters):
    """Sec. IV-B: group A "with no clustering", B to D with two to four clusters, E with 12."""
    facts = models.find("ultrasonic_cgan")
    published, group = (Recipe.load(facts.recipe(name)) for name in ("paper", f"group-{letter}"))
    assert facts.config(group.config) == facts.config({**published.config, "clusters": clusters})
    assert (group.prepare, group.training) == (published.prepare, published.training)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rate_low": 0.6, "rate_high": 0.6}, "rate_low must be < rate_high, got 0.6 and 0.6"),
        ({"dropout_after": (2, 5)}, r"dropout_after must name hidden layers 1 to 4, got \(2, 5\)"),
    ],
)
def test_ranges_that_hold_nothing_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        Config(**changes)
