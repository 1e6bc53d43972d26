"""Files."""

import numpy as np
import pytest
import soundfile

from tactogram.errors import ParameterError
from tactogram.signal.io import read_signal

X = np.sin(np.arange(40))


def written(tmp_path, text, name="a.csv"):
    path = tmp_path / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def test_options_that_mean_nothing_are_refused(tmp_path):
    soundfile.write(tmp_path / "a.wav", X, 1000)
    with pytest.raises(ParameterError, match="time does not apply to .wav"):
        read_signal(tmp_path / "a.wav", time="t")
    with pytest.raises(ParameterError, match="full_scale"):
        read_signal(written(tmp_path, "1\n2\n"), full_scale=2, rate=1)
