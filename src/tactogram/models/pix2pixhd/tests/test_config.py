"""Numbers of the paper."""

PAPER = {
    "generator_width": 64, "downsamplings": 4, "blocks": 9, "discriminators": 3, "layers": 3, "width": 64, "gain": 0.02,
    "adversarial": "least-squares", "feature_matching": 10, "perceptual": 10, "batch_size": 32, "learning_rate": 2e-4,
    "betas": (0.5, 0.999), "epochs": 200, "constant": 0.5, "steps": None,
}  # fmt: skip
"""Wang et al. 2018, Sec. 3.2, 4 and 9; pairs per update of Neshov et al. 2026, Sec. 3.2."""


def test_the_recipe_paper_has_the_papers_numbers(paper_values):
    assert paper_values("pix2pixhd", PAPER) == PAPER
