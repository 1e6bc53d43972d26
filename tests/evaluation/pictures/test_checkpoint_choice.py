import pytest
import torch

from tactogram.errors import DataError, MissingExtraError
from tactogram.evaluation.pictures import checkpoint_choice
from tactogram.evaluation.pictures.checkpoint_choice import picture_choice
from tactogram.nn.photo_translation import row_statistics_distance


def test_where_lpips_is_missing_the_note_says_what_takes_its_place_and_why(monkeypatch, tmp_path):
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))
    choice = picture_choice("lpips")
    assert (choice.name, choice.distance) == ("row_statistics", row_statistics_distance)
    assert choice.note.startswith("weights are chosen by row_statistics in place of LPIPS: ")
    assert "\n" not in choice.note


def test_what_was_asked_for_needs_no_note(monkeypatch):
    monkeypatch.setattr(
        checkpoint_choice, "Lpips", lambda weights, option: lambda real, made: (made - real).flatten(1).sum(1)
    )
    assert picture_choice("row_statistics").note == ""
    choice = picture_choice("lpips")
    assert (choice.name, choice.note) == ("lpips", "")
    made, real = torch.tensor([[[[1.0, 2.0]]], [[[5.0, 0.0]]]]), torch.ones(2, 1, 1, 2)
    assert choice.distance(made, real).item() == pytest.approx((1 + 3) / 2)


def test_a_file_that_is_named_and_absent_is_refused(tmp_path):
    with pytest.raises((DataError, MissingExtraError)):
        picture_choice("lpips", str(tmp_path / "none.pth"))
