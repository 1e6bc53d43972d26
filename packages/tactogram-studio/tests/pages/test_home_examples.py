"""Sounds and pictures of the start page's examples."""

import io

import numpy as np
import pytest
import soundfile

from tactogram.errors import DataError
from tactogram.signal.io import read_metadata
from tactogram_studio.pages.home_examples import EXAMPLES, FOLDER, _picture, _wav


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_example_is_heard_and_drawn(name):
    x, rate = soundfile.read(io.BytesIO(_wav(name)))
    assert rate == 48_000
    assert 0.25 < np.abs(x).max() <= 0.51
    assert 0.05 < len(x) / rate < 5
    picture = _picture(name)
    assert "corduroy.webp" in picture if name == "photograph" else picture.count(",") > 200


def test_the_stroke_says_that_it_is_simulated():
    assert read_metadata(FOLDER / "sandpaper.flac")["simulated"] is True
    assert "simulated" in EXAMPLES["sandpaper"].about


def test_an_unknown_example_is_refused():
    with pytest.raises(DataError, match="no such example"):
        _wav("nothing")
