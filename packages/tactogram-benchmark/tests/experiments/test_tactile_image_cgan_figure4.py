"""Fig. 4 of Hatori et al. 2025: what is trained, kept and said; nothing is trained here."""

import numpy as np
import pytest
from made_up_images import MadeUpWorkflows

from tactogram.errors import ParameterError
from tactogram.signal import Image
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments import (
    artifacts,
    cross_modal,
    image_cells,
    tactile_image_cgan_figure4 as figure4,
)


@pytest.fixture(autouse=True)
def made_up(stand_in):
    return stand_in(MadeUpWorkflows(), figure4, cross_modal, image_cells, artifacts)


@pytest.fixture
def quality(monkeypatch):
    class Quality:
        def __init__(self, real):
            self.real, self.missing = real, {"fid": "weights are not here"}

        def __call__(self, made):
            return {"efficientnet_lite0_frechet_distance": float((made.mean() - self.real.mean()).abs())}

    monkeypatch.setattr(figure4, "ImageQuality", Quality)
    monkeypatch.setattr(figure4, "of_real_images", lambda images, rater: None)


def test_figure_4_trains_four_weights_and_says_which_follow(tmp_path, quality, made_up):
    """Hatori et al. 2025, Sec. III-A: "two trials using different initial random noise inputs"."""
    found = figure4.run(tmp_path, paper=False, progress=silent)
    painters = [row for row in made_up.trained if row[0] == "tactile_image_cgan"]
    assert [row[4]["config.image_weight"] for row in painters] == [1, 1000, 5000, 10000]
    assert {row[3] for row in painters} == {"all"}
    follows = {weight: row[0]["following"]["correlation"] for weight, row in found["variants"].items()}
    assert follows["weight 1"] > 0.1
    assert follows["weight 5,000"] == pytest.approx(0, abs=1e-9)
    assert found["variants"]["weight 5,000"][0]["collapse"] == "the label makes no difference"
    assert found["variants"]["weight 1,000"][0]["losses"]["discriminator"] == 1.0
    assert "simulated" in found["text"]
    assert "fid: weights are not here" in found["text"]
    assert (tmp_path / "figure4.png").is_file()
    assert (tmp_path / "trade_off.png").is_file()


def test_figure_4_reads_what_it_judged_before(tmp_path, quality, monkeypatch):
    first = figure4.run(tmp_path, paper=False, progress=silent, weights="1,10")
    assert set(first["variants"]) == {"weight 1", "weight 10"}
    monkeypatch.setattr(figure4, "score", None)
    assert figure4.run(tmp_path, paper=False, progress=silent, weights="1,10") == first


@pytest.mark.parametrize("weights", ["", "0,1", "heavy", "1,2,3,4,5,6,7,8,9"])
def test_weights_that_are_none_are_refused(tmp_path, weights):
    with pytest.raises(ParameterError, match="weights must be 1 to 8 whole numbers"):
        figure4.run(tmp_path, paper=False, progress=silent, weights=weights)


def test_black_is_minus_1_and_white_is_1():
    pixels = np.zeros((4, 6, 3), np.uint8)
    pixels[0, :, 1] = 255
    tensor = figure4.as_tensor([Image(pixels)])
    assert tensor.shape == (1, 3, 4, 6)
    assert tensor[0, 1, 0].tolist() == pytest.approx([1.0] * 6)
    assert tensor[0, 0].unique().tolist() == [-1.0]
