"""Numbers of the paper."""

PAPER = {
    "noise": 100, "widths": (512, 256, 128, 64), "size": 64, "leak": 0.2, "image_weight": 5000,
    "learning_rate": 0.002, "betas": (0.5, 0.999), "epsilon": 1e-8, "batch_size": 32, "updates": 1000,
}  # fmt: skip
"""Hatori et al. 2025, Sec. II-C, Tables 2 to 4, Fig. 5."""


def test_the_recipe_paper_has_the_papers_numbers(paper_values):
    assert paper_values("tactile_image_cgan", PAPER) == PAPER
