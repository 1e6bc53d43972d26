"""Numbers of the paper."""

PAPER = {
    "penalty": 10, "critic_updates": 5, "learning_rate": 1e-4, "betas": (0.0, 0.9), "batch_size": 32, "epochs": 200,
    "steps": None,
}  # fmt: skip
"""Gulrajani et al. 2017, Algorithm 1; pairs per update and epochs of Neshov et al. 2026, Sec. 3.2."""


def test_the_recipe_paper_has_the_papers_numbers(paper_values):
    assert paper_values("residue_fusion_gan", PAPER) == PAPER
