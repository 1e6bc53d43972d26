"""Distances of pictures: against formulas written out, and honest where weights are absent."""

import json
from dataclasses import asdict
from importlib.util import find_spec

import numpy as np
import pytest
import torch

from tactogram.errors import DataError, MissingExtraError, ParameterError
from tactogram.evaluation.pictures import distances
from tactogram.evaluation.pictures.distances import (
    MEASURES,
    ImageQuality,
    ImageSpread,
    PictureEvaluator,
    image_spread,
    mean_distance,
    picture_choice,
)
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.nn.photo_translation import row_statistics_distance

needs_vision = pytest.mark.skipif(
    find_spec("torchvision") is None, reason="the extra vision is not installed"
)
PICTURE = SpectrogramPicture(
    rate=1000.0,
    floor_db=-80.0,
    ceiling_db=20.0,
    n_fft=64,
    hop=16,
    frames=32,
    rows=32,
    columns=32,
)


def pictures(count, seed=0, size=32):
    return torch.from_numpy(np.random.default_rng(seed).uniform(-1, 1, (count, 1, size, size))).float()


@needs_vision
def test_what_cannot_be_had_is_missing_and_never_replaced(tmp_path, monkeypatch):
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))
    found = PictureEvaluator(PICTURE)(pictures(2, 1), pictures(2, 2))
    assert set(found.missing) == {"lpips", "fid"}
    assert set(found.values) == set(MEASURES) - {"lpips", "fid"}
    assert "alexnet-owt" in found.missing["lpips"]
    read = json.loads(json.dumps(asdict(found), allow_nan=False))
    assert read["pictures"] == 2
    assert "256 x 256" in read["protocol"]


@needs_vision
def test_our_measures_by_hand():
    judge = PictureEvaluator(PICTURE, networks=False)
    real = torch.zeros(2, 1, 32, 32)
    louder = real + 0.2  # 0.2 of 2 is 10 dB of 100
    found = judge(real, louder).values
    assert found["log_spectral_distance_db"] == pytest.approx(10, abs=1e-3)
    assert found["level_difference_db"] == pytest.approx(10, abs=1e-4)
    assert found["l1"] == pytest.approx(0.2, abs=1e-6)
    assert found["psnr_db"] == pytest.approx(20, abs=1e-4)  # 10 log10(2^2 / 0.2^2)
    same = judge(real, real).values
    assert same["psnr_db"] == 100
    assert same["ssim"] == pytest.approx(1)
    assert same["log_spectral_distance_db"] == same["level_difference_db"] == same["l1"] == 0


def test_order_in_time_does_not_count_in_the_log_spectral_distance():
    judge = PictureEvaluator(PICTURE, networks=False)
    real = pictures(2)
    assert judge(real, real.flip(-1)).values["log_spectral_distance_db"] == pytest.approx(0, abs=1e-5)
    assert judge(real, real.flip(-2)).values["log_spectral_distance_db"] > 1


def test_bad_input_is_one_line():
    judge = PictureEvaluator(PICTURE, networks=False)
    with pytest.raises(ParameterError, match=r"as many pictures of one size"):
        judge(pictures(2), pictures(3))
    with pytest.raises(ParameterError, match=r"-1..1"):
        judge(pictures(2), 2 * pictures(2))
    with pytest.raises(ParameterError, match=r"-1..1"):
        judge(pictures(2), pictures(2) * float("nan"))
    with pytest.raises(ParameterError, match=r"at least 2 pairs"):
        judge(pictures(1), pictures(1))
    with pytest.raises(ParameterError, match=r"\(picture, 1, rows, columns\)"):
        judge(pictures(2)[:, 0], pictures(2)[:, 0])
    with pytest.raises(ParameterError, match=r"\(1, 32, 32\)"):
        judge(pictures(2, size=16), pictures(2, size=16))


def test_where_lpips_is_missing_the_note_says_what_takes_its_place_and_why(monkeypatch, tmp_path):
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))
    choice = picture_choice("lpips")
    assert (choice.name, choice.distance) == ("row_statistics", row_statistics_distance)
    assert choice.note.startswith("weights are chosen by row_statistics in place of LPIPS: ")
    assert "\n" not in choice.note


def test_what_was_asked_for_needs_no_note(monkeypatch):
    monkeypatch.setattr(
        distances, "Lpips", lambda weights, option: lambda real, made: (made - real).flatten(1).sum(1)
    )
    assert picture_choice("row_statistics").note == ""
    choice = picture_choice("lpips")
    assert (choice.name, choice.note) == ("lpips", "")
    made, real = torch.tensor([[[[1.0, 2.0]]], [[[5.0, 0.0]]]]), torch.ones(2, 1, 1, 2)
    assert choice.distance(made, real).item() == pytest.approx((1 + 3) / 2)


def test_a_file_that_is_named_and_absent_is_refused(tmp_path):
    with pytest.raises((DataError, MissingExtraError)):
        picture_choice("lpips", str(tmp_path / "none.pth"))


def test_distance_is_that_of_every_pair():
    images = np.random.default_rng(0).uniform(-1, 1, (5, 3, 4, 4)).astype(np.float32)
    slow = [np.sqrt(np.mean((images[a] - images[b]) ** 2)) for a in range(5) for b in range(a)]
    assert mean_distance(images) == pytest.approx(np.mean(slow), rel=1e-5)
    assert mean_distance(images[[0, 0]]) == pytest.approx(0, abs=1e-6)


def test_one_image_differs_from_nothing():
    with pytest.raises(ParameterError, match="at least 2 to differ, got 1"):
        mean_distance(np.zeros((1, 3, 4, 4), np.float32))


def test_noise_and_label_are_told_apart():
    """Images of one grey value: the noise times 0.1 plus the label."""

    def make(noises, labels):
        return np.broadcast_to((0.1 * noises + labels)[:, :, None, None], (len(noises), 1, 4, 4))

    labels, noises = np.array([[0.0], [0.5]]), np.array([[0.0], [1.0]])
    found = image_spread(make, labels, noises, real=0.5)
    assert found.by_noise == pytest.approx(0.1)
    assert found.by_label == pytest.approx(0.5)
    assert found.noise_share == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("noise", "label", "said"),
    [
        (0.5, 0.5, ""),
        (0.04, 0.5, "one image per label, whatever the noise"),
        (0.5, 0.04, "the label makes no difference"),
        (0.04, 0.04, "one image for all labels and noises"),
    ],
)
def test_collapse_is_called_what_it_is(noise, label, said):
    spread = ImageSpread(0.5, noise, label)
    assert spread.collapse == said
    assert spread.as_dict()["collapsed"] == bool(said)


class Distance:
    """Stands in for a network: the difference of the means."""

    def frechet(self, real, made):
        return abs(float(made.mean() - real.mean()))


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
