"""Sources of a conversion: signals, photographs and what has no use for an option."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.io import write_image, write_signal
from tactogram.workflows.data.sources import read_source, suffix_of, target_format

READING = dict.fromkeys(("unit", "rate", "axes", "time", "sheet", "part", "full_scale"))
CHANGES = dict.fromkeys(("axis", "map", "play_at", "width_mm", "resample_to"))


def test_a_signal_over_displacement_is_played_and_resampled(tmp_path):
    ridges = Signal(np.sin(np.arange(400) / 3)[None], 10.0, "1", ("mu",), "displacement")
    write_signal(tmp_path / "x.npz", ridges, metadata={"material": "denim"})
    given = read_source(tmp_path / "x.npz", READING, **CHANGES | {"play_at": 50.0, "resample_to": 1000.0})
    assert (given.signal.domain, given.signal.rate, given.signal.seconds) == ("time", 1000.0, 0.8)
    assert given.metadata["played_at_mm_s"] == 50.0
    assert given.metadata["material"] == "denim"
    plain = read_source(tmp_path / "x.npz", READING, **CHANGES)
    np.testing.assert_array_equal(plain.signal.samples, ridges.samples)


def test_a_photograph_is_drawn_over_its_width(tmp_path):
    pixels = np.random.default_rng(0).integers(0, 256, (32, 64, 3), np.uint8)
    write_image(tmp_path / "x.png", Image(pixels))
    given = read_source(tmp_path / "x.png", READING, **CHANGES | {"width_mm": 50.0, "play_at": 100.0})
    assert given.mapped == {"by": "relief", "width_mm": 50.0, "speed_mm_s": 100.0}
    assert given.signal.seconds == pytest.approx(0.5, abs=0.02)
    with pytest.raises(ParameterError, match="a photograph has no use for unit or map; omit it"):
        read_source(tmp_path / "x.png", READING | {"unit": "g"}, **CHANGES | {"map": "pitch"})


def test_a_format_has_its_suffix():
    assert (suffix_of("wav"), suffix_of("ahap")) == (".wav", ".ahap")
    with pytest.raises(ParameterError, match="format must be one of"):
        suffix_of("tape")


def test_the_target_has_the_suffix_of_its_format(tmp_path):
    assert target_format(tmp_path / "x.ahap", "ahap").name == "ahap"
    assert target_format(tmp_path / "x.wav", "wav") is None
    assert target_format(tmp_path / "x.ahap", None).name == "ahap"
    with pytest.raises(ParameterError, match="format ahap is written as .ahap, got x.json"):
        target_format(tmp_path / "x.json", "ahap")
