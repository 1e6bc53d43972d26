"""Published results, held against every place where the project states them."""

import pytest

from tactogram.datasets import WORDS
from tactogram.models.ultrasonic_cgan.config import GROUPS
from tactogram.workflows.results_table import table
from tactogram_benchmark.experiments import (
    cross_modal,
    frictgan_figure3,
    stroke_cnn_table2,
    tactile_image_cgan_figure4,
    ultrasonic_cgan_figure7,
    ultrasonic_cgan_selection,
    visual_tactile_gan_table3,
    visual_tactile_gan_table4,
)
from tactogram_simulate.materials import PLATES

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


def test_groups_and_people_of_hatori_and_takemura(rows):
    """Sec. IV-C: "Groups A to D were used to train the model successfully"; V-A: B, C and D significantly better."""
    assert {letter: count for count, letter in GROUPS.items()} == ultrasonic_cgan_figure7.GROUPS
    succeeded = [letter for letter, well in ultrasonic_cgan_selection.PUBLISHED.items() if well]
    assert succeeded == ["A", "B", "C", "D"]
    assert set(published(rows, "ultrasonic_cgan", "groups whose training succeeded")) == {len(succeeded)}
    assert ultrasonic_cgan_figure7.SIGNIFICANT == ("B", "C", "D")
    assert ultrasonic_cgan_figure7.PEOPLE * len(PLATES) * len(WORDS) == 2400  # Fig. 7: "n = 2,400"


def test_errors_and_people_of_hatori_et_al(rows):
    """Abstract: "reduced the mean absolute error … from 2.2 to 1.6"; Sec. III-B: weights 1, 1,000 and 5,000."""
    assert cross_modal.PUBLISHED == {"weight 5000": 1.6, "without models": 2.2}
    assert set(published(rows, "tactile_image_cgan", "MAE with image and vibration")) == {1.6}
    assert published(rows, "ultrasonic_cgan", "mean absolute error") == [2.2]
    assert cross_modal.PUBLISHED_BETTER == (1, 1000, 5000)
    assert cross_modal.PUBLISHED_WORDS == (3, 8, ("rugged", "uneven"))
    assert cross_modal.PEOPLE * len(PLATES) * len(WORDS) == 2400  # Figs. 5 and 6: "n = 2,400"
    assert list(tactile_image_cgan_figure4.PUBLISHED) == [1, 1000, 5000, 10000]
    assert tactile_image_cgan_figure4.TRIALS == 2  # Fig. 4: "Images from two trials"
