"""Numbers of the paper."""

PAPER = {
    "widths": (64, 128, 256, 512, 512, 512, 512, 512), "dropout": 3, "layers": 3, "width": 64, "gain": 0.02, "l1": 100,
    "batch_size": 32, "learning_rate": 2e-4, "betas": (0.5, 0.999), "epochs": 200, "constant": 0.5, "steps": None,
}  # fmt: skip
"""Isola et al. 2017, Sec. 3.3, 4.2, 6.1 and 6.2; pairs per update of Neshov et al. 2026, Sec. 3.2."""


def test_the_recipe_paper_has_the_papers_numbers(paper_values):
    assert paper_values("pix2pix", PAPER) == PAPER
