"""Haptic files: the figures of an experiment on simulated effects."""

import numpy as np
import pytest
from benchmarks.experiments import haptic_files

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram.workflows.progress import silent


def effect(rate, channels, seconds=0.2):
    t = np.arange(round(seconds * rate)) / rate
    x = 0.8 * np.sin(np.pi * t / seconds) * np.sin(2 * np.pi * 140 * t)
    names = ("left", "right")[:channels]
    return Signal(np.stack([x, 0.5 * x][:channels]), rate, "1", names)


def test_every_format_has_its_figures_and_leaves_no_file(tmp_path):
    for k, (rate, channels) in enumerate([(8000, 1), (44100, 2), (22050, 1)]):
        write_signal(tmp_path / "in" / f"{k}.wav", effect(rate, channels), subtype="PCM_16")
    found = haptic_files.run(tmp_path / "out", paper=True, progress=silent, data=str(tmp_path / "in"))
    assert (found["effects"], found["channels"]) == (3, [1, 2])
    for name, row in found["formats"].items():
        assert (row["valid"], row["refused"]) == (3, []), name
    formats = found["formats"]
    assert formats["wav"]["envelope_error"]["p90"] == 0
    assert formats["hjif"]["snr_db"]["p10"] > 40
    assert formats["ahap"]["envelope_correlation"]["p10"] > 0.98
    assert formats["ahap"]["made_one_axis"] == 1
    assert (
        formats["vibration"]["envelope_error"]["median"] > 10 * formats["haptic"]["envelope_error"]["median"]
    )
    assert "ahap" in found["text"]
    assert not [p for p in (tmp_path / "out").rglob("*") if p.is_file()]


def test_without_files_it_says_what_it_needs(tmp_path):
    with pytest.raises(ParameterError, match="data must be a folder"):
        haptic_files.run(tmp_path, paper=False, progress=silent)
