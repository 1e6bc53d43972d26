import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures import distances
from tactogram.evaluation.pictures.distances import ImageQuality
from tactogram.evaluation.pictures.image_figures import (
    GeneratorRow,
    TradeOff,
    generated_figure,
    trade_off_figure,
)
from tactogram.signal import Image


class Distance:
    """Stands in for a network: the difference of the means."""

    def frechet(self, real, made):
        return abs(float(made.mean() - real.mean()))


def row(count=3):
    pixels = np.random.default_rng(0).integers(0, 256, (2, count, 8, 8, 3), np.uint8)
    losses = {name: [(n, 1.0 / n) for n in range(1, 50)] for name in ("generator", "discriminator")}
    return GeneratorRow("weight 1", [[Image(p) for p in trial] for trial in pixels], losses)


def test_every_image_and_loss_is_drawn():
    figure = generated_figure([row(), row()], ["ID1", "ID2", "ID3"])
    shown = [axes for axes in figure.axes if axes.images]
    assert len(shown) == 2 * 2 * 3
    assert sum(len(axes.lines) for axes in figure.axes) == 2 * 2 * 2


def test_a_trial_with_another_number_of_images_is_refused():
    with pytest.raises(ParameterError, match="weight 1: each trial needs 2 images"):
        generated_figure([row()], ["ID1", "ID2"])


def test_the_trade_off_names_every_weight():
    weights = [
        TradeOff(f"weight {w:,}", [r], [d], [0.5], [0.2]) for w, r, d in ((1, 0.6, 90.0), (1000, 0.3, 50.0))
    ]
    figure = trade_off_figure(weights, distance="FID", best=0.9)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert {"weight 1", "weight 1,000"} <= set(texts)
    assert "FID" in figure.axes[0].get_xlabel()


def test_a_distance_that_cannot_be_had_is_said(tmp_path, monkeypatch):
    monkeypatch.setattr(distances, "TrunkDistance", Distance)
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))
    quality = ImageQuality(torch.zeros(2, 3, 8, 8))
    assert "fid" in quality.missing
    assert "\n" not in quality.missing["fid"]
    assert quality(torch.ones(3, 3, 8, 8)) == {"efficientnet_lite0_frechet_distance": 1.0}


def test_one_real_image_is_too_few():
    with pytest.raises(ParameterError, match="at least 2 real images"):
        ImageQuality(torch.zeros(1, 3, 8, 8))
