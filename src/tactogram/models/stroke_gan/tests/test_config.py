"""Numbers of the paper."""

PAPER = {
    "latent": 100, "channels": (1024, 512, 256, 128, 64), "kernel": 25, "stride": 4, "leak": 0.2, "length": 16_384,
    "batch_size": 64, "phase_shuffle": 2, "penalty": 10, "generator_updates": 2, "critic_updates": 1,
    "learning_rate": 1e-4, "betas": (0.5, 0.9), "repetition": "repeat", "repetitions": 10, "epochs": 40,
    "epoch_covers": "recordings", "steps": None,
}  # fmt: skip
"""Saga et al. 2020, Sec. III-B, Tables III and IV."""


def test_the_recipe_paper_has_the_papers_numbers(paper_values):
    assert paper_values("stroke_gan", PAPER) == PAPER
