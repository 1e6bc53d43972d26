"""The papers' own numbers, held against every place where the project states them."""

import pytest

from tactogram import models
from tactogram.recipe import Recipe
from tactogram.workflows.results_table import table
from tactogram_benchmark.experiments import (
    frictgan_figure3,
    stroke_cnn_table2,
    visual_tactile_gan_table3,
    visual_tactile_gan_table4,
)

PAPER = {
    # Saga et al. 2020, Sec. II-B.
    "stroke_cnn": {"window": 200, "filters": (64, 64, 128, 128, 256, 256), "kernel": 5, "pool": 2},
    # Saga et al. 2020, Sec. III-B, Tables III and IV.
    "stroke_gan": {
        "latent": 100, "channels": (1024, 512, 256, 128, 64), "kernel": 25, "stride": 4, "leak": 0.2, "length": 16_384,
        "batch_size": 64, "phase_shuffle": 2, "penalty": 10, "generator_updates": 2, "critic_updates": 1,
        "learning_rate": 1e-4, "betas": (0.5, 0.9), "repetition": "repeat", "repetitions": 10, "epochs": 40,
        "epoch_covers": "recordings", "steps": None,
    },
    # Hatori and Takemura, Sec. III-B, IV-A and IV-C, Tables 2 to 4.
    "ultrasonic_cgan": {
        "stable_s": 2, "hop_s": 0.05, "bins": 1000, "generator_widths": (1024, 512, 256, 128), "dropout_after": (2, 4),
        "dropout": 0.5, "discriminator_widths": (64, 32), "leak": 0.01, "learning_rate": 0.001,
        "betas": (0.9, 0.999), "epsilon": 1e-8, "batch_size": 64, "iterations": 200_000, "rate_low": 0.4,
        "rate_high": 0.6,
    },
    # Neshov et al. 2026, Sec. 3.1, 3.2 and 4.1, Tables 1 and 2.
    "visual_tactile_gan": {
        "widths": (64, 128, 256, 512, 512, 512, 512, 512), "discriminators": 3, "layers": 3, "width": 64, "gain": 0.02,
        "l1": 10, "feature_matching": 40, "batch_size": 32, "learning_rate": 2e-4, "betas": (0.5, 0.999),
        "epochs": 200, "constant": 0.5, "choose_by": "lpips", "label": "predicted", "steps": None,
        "predictor.trunk": "densenet201", "predictor.hidden": 256, "predictor.leak": 0.01, "predictor.scale": 1.5,
        "predictor.batch_size": 64, "predictor.epochs": 30, "predictor.halve_every": 5,
        "predictor.learning_rate": 2e-4, "pairs.n_fft": 512, "pairs.hop": 128, "pairs.frames": 256, "pairs.size": 256,
        "pairs.crop": 256, "pairs.per_photo": 10, "pairs.per_recording": 10, "pairs.repeats": 10,
    },
    # Hatori et al. 2025, Sec. II-C, Tables 2 to 4, Fig. 5.
    "tactile_image_cgan": {
        "noise": 100, "widths": (512, 256, 128, 64), "size": 64, "leak": 0.2, "image_weight": 5000,
        "learning_rate": 0.002, "betas": (0.5, 0.999), "epsilon": 1e-8, "batch_size": 32, "updates": 1000,
    },
    # Cai et al. 2020, Sec. 3.1, 3.2 and 4.
    "frictgan": {
        "pixels": 1024, "offset": 2, "windows": 600, "shares": (2 / 3, 1 / 6, 1 / 6), "n_fft": 512, "hop": 128,
        "bins": 257, "frames": 11, "latent": 128, "noise": 50, "encoder_dropout": 3, "loss": "wasserstein", "l1": 100,
        "learning_rate": 5e-5, "critic_learning_rate": None, "batch_size": 2,
    },
}  # fmt: skip
TABLE_II = {"100": 89.0, "200": 88.0, "400": 93.2, "mixed": 88.9}
"""Saga et al. 2020: windows classified correctly, %."""
NINE_TEXTURES = [96.9, 91.8, 85.7, 76.5]
"""Published with the recordings of Saga et al.: three axes, first principal component, one axis, DFT321."""
TABLE_3 = [
    (0.3442, 0.0106), (0.3486, 0.0099), (0.3458, 0.0080), (0.3337, 0.0084),
    (0.3254, 0.0078), (0.3328, 0.0090), (0.3294, 0.0084), (0.3258, 0.0100),
    (0.3291, 0.0102), (0.3308, 0.0096), (0.3113, 0.0087), (0.3202, 0.0073),
    (0.3200, 0.0079), (0.3274, 0.0072), (0.3194, 0.0057), (0.3205, 0.0101),
]  # fmt: skip
"""Neshov et al. 2026: LPIPS of 1 to 4 discriminators (rows) of 1 to 4 layers, mean and sd."""
TABLE_4 = {
    "pix2pix": ((0.3513, 0.0089), (52.23, 2.01)),
    "pix2pixHD": ((0.3345, 0.0105), (43.60, 1.88)),
    "Residue-Fusion GAN": ((0.3198, 0.0075), (40.76, 1.83)),
    "without CBN": ((0.3439, 0.0093), (45.42, 2.10)),
    "without L1": ((0.3278, 0.0087), (41.67, 2.14)),
    "without FM": ((0.3247, 0.0068), (41.29, 1.98)),
    "one discriminator": ((0.3458, 0.0080), (47.60, 1.91)),
    "proposed": ((0.3113, 0.0087), (38.77, 1.92)),
}
"""Neshov et al. 2026: LPIPS and FID, mean and sd."""
FABRICS = (0.006, 0.005, 0.014, 0.005, 0.005)
"""Cai et al. 2020, Sec. 4: mean squared error of each of five fabrics, "averagely 0.035"."""


@pytest.fixture(scope="module")
def rows():
    return [row for row in table() if row["published"] is not None]


def published(rows, model, words):
    """What a model's results say is published of the figures whose name holds ``words``."""
    return [row["published"] for row in rows if row["model"] == model and words in row["what"]]


@pytest.mark.parametrize("name", PAPER)
def test_the_recipe_paper_has_the_papers_numbers(name):
    facts = models.find(name)
    config = facts.config(Recipe.load(facts.recipe("paper")).config)
    for path, expected in PAPER[name].items():
        value = config
        for part in path.split("."):
            value = getattr(value, part)
        assert value == (pytest.approx(expected) if isinstance(expected, float | tuple) else expected), path


def test_a_published_figure_says_where_it_is_published(rows):
    assert [(row["model"], row["what"]) for row in rows if not row["where"]] == []


def test_table_ii_of_saga_et_al(rows):
    assert stroke_cnn_table2.PUBLISHED == TABLE_II
    stated = published(rows, "stroke_cnn", "windows of 200 samples")
    assert stated == list(TABLE_II.values())


def test_accuracies_published_with_the_recordings_of_saga_et_al(rows):
    assert published(rows, "stroke_cnn", "strokes over 9 textures") == NINE_TEXTURES


def test_tables_3_and_4_of_neshov_et_al(rows):
    assert list(visual_tactile_gan_table3.PUBLISHED.values()) == TABLE_3
    assert published(rows, "visual_tactile_gan", " layers") == [mean for mean, _ in TABLE_3]
    assert visual_tactile_gan_table4.PUBLISHED == TABLE_4
    names = {
        "pix2pix": "pix2pix", "pix2pixhd": "pix2pixHD", "residue_fusion_gan": "Residue-Fusion GAN",
    }  # fmt: skip
    for model, method in names.items():
        assert published(rows, model, "") == [mean for mean, _ in TABLE_4[method]]
    variants = {
        "without CBN": "without CBN", "without L1": "without L1 loss", "without FM": "without FM loss",
        "one discriminator": "single discriminator", "proposed": "full model",
    }  # fmt: skip
    for method, words in variants.items():
        assert published(rows, "visual_tactile_gan", words) == [mean for mean, _ in TABLE_4[method]]


def test_frictgans_average_is_a_sum(rows):
    assert frictgan_figure3.PUBLISHED == FABRICS
    assert set(published(rows, "frictgan", "sum over fabrics")) == {round(sum(FABRICS), 6)}
    assert set(published(rows, "frictgan", "mean over fabrics")) == {round(sum(FABRICS) / 5, 6)}
