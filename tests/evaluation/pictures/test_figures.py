import io

import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.figures import (
    GeneratorRow,
    PictureCase,
    failures_figure,
    generated_figure,
    pictures_figure,
    worst_cases,
)
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.signal import Image

PICTURE = SpectrogramPicture(
    rate=1000.0, floor_db=-80.0, ceiling_db=20.0, n_fft=32, hop=8, frames=16, rows=16, columns=16
)


def case(title="cork", value=0.0, channels=1, **changes):
    pictures = {"real": torch.zeros(1, 16, 16), "generated": torch.full((1, 16, 16), value)}
    return PictureCase(title, torch.zeros(channels, 8, 8), pictures, **changes)


def test_pictures_are_drawn_in_decibels_on_one_scale():
    figure = pictures_figure([case(value=0.5), case("tile", -1.0, channels=3)], PICTURE)
    shown = [[place.images[0] for place in figure.axes[row * 3 : row * 3 + 3]] for row in range(2)]
    assert np.asarray(shown[0][1].get_array()).mean() == pytest.approx(-30)  # halfway from -80 to 20
    assert np.asarray(shown[0][2].get_array()).mean() == pytest.approx(-5)
    assert np.asarray(shown[1][2].get_array()).mean() == pytest.approx(-80)
    assert {image.get_clim() for row in shown for image in row[1:]} == {(-80.0, 20.0)}
    assert [place.get_title() for place in figure.axes[:3]] == ["photo", "real", "generated"]
    assert figure.axes[1].images[0].get_extent() == [0, 15 * 8 / 1000, 0, 500]


def test_attention_is_laid_over_its_picture():
    """Neshov et al. 2026, Sec. 4.4: "visualized with a jet colormap overlay"."""
    figure = pictures_figure([case(attention={"generated": torch.rand(16, 16)})], PICTURE)
    under, over = figure.axes[3].images
    assert under.get_cmap().name == "gray"
    assert over.get_cmap().name == "jet"
    assert over.get_clim() == (0, 1)
    assert figure.axes[3].get_title() == "attention, generated"


def test_what_must_be_said_of_attention_stands_above_it():
    notes = {"generated": "the layer gives one channel: this is the picture itself"}
    shown = case(attention={"generated": torch.rand(16, 16)})
    figure = pictures_figure([shown], PICTURE, attention_notes=notes)
    assert figure.axes[3].get_title().replace("\n", " ") == f"attention, generated {notes['generated']}"
    assert figure.axes[2].get_title() == "generated"


def test_the_worst_cases_are_those_of_largest_error_one_per_material():
    errors = [0.1, 0.9, 0.8, 0.3, 0.2]
    assert worst_cases(errors, ["a", "a", "a", "b", "c"]) == [1, 3, 4]
    assert worst_cases(errors, ["a", "a", "a", "b", "c"], count=1) == [1]


def test_failures_are_chosen_by_error_and_say_it():
    """Neshov et al. 2026, Sec. 4.5: "some of the most challenging cases"."""
    cases = [case("cork", 0.1), case("cork", 0.9), case("tile", 0.4)]
    figure = failures_figure(cases, [0.1, 0.9, 0.4], PICTURE, measure="L1")
    assert figure.axes[0].get_ylabel() == "cork\n0.9 (median 0.4)"
    assert figure.axes[3].get_ylabel() == "tile\n0.4 (median 0.4)"
    assert np.asarray(figure.axes[2].images[0].get_array()).mean() == pytest.approx(-80 + 100 * 0.95)
    figure.savefig(io.BytesIO(), dpi=40)


def test_bad_input_is_one_line():
    with pytest.raises(ParameterError, match=r"at least one case"):
        pictures_figure([], PICTURE)
    with pytest.raises(ParameterError, match=r"must have pictures real, generated, got those of tile"):
        pictures_figure(
            [case(), PictureCase("tile", torch.zeros(1, 8, 8), {"real": torch.zeros(1, 16, 16)})], PICTURE
        )
    with pytest.raises(ParameterError, match=r"as many as cases \(1\)"):
        worst_cases([1.0, 2.0], ["a"])
    with pytest.raises(ParameterError, match=r"finite"):
        worst_cases([float("nan")], ["a"])


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
