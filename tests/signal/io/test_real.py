"""Files that nobody on this project made."""

import csv

import numpy as np
import pytest

from tactogram.signal.filters import bandpass
from tactogram.signal.io import read_file, read_signal, write_signal

pytestmark = pytest.mark.real_data


def test_wav_of_mixed_rates_and_channels(real_data):
    files = sorted((real_data("vibviz") / "wav").glob("*.wav"))
    signals = [read_signal(file) for file in files[::7]]
    assert {signal.rate for signal in signals} > {44100.0}
    assert {len(signal.axes) for signal in signals} <= {1, 2}
    assert all(0.1 <= signal.seconds <= 16 for signal in signals)
    assert all(0 < np.abs(signal.samples).max() <= 1 for signal in signals)


def test_flac_is_what_its_wav_is(real_data, tmp_path):
    folder = real_data("lmt108_sound")
    for wav in sorted((folder / "wav").glob("*.wav")):
        flac = read_signal(folder / "flac" / f"{wav.stem}.flac")
        assert (flac.rate, len(flac)) == (44100, 211611)
        np.testing.assert_array_equal(read_signal(wav).samples, flac.samples)
        write_signal(tmp_path / "a.flac", flac, subtype="PCM_16")
        np.testing.assert_array_equal(read_signal(tmp_path / "a.flac").samples, flac.samples)
        assert 0 < np.abs(bandpass(flac, 20, 1000).samples).max() < np.abs(flac.samples).max()


def test_worksheets_column_by_column(real_data):
    path = sorted((real_data("cdplab_friction") / "xlsx").glob("*.xlsx"))[0]
    signal = read_signal(path, axes=["speed", "friction"], rate=1000)
    assert signal.axes == ("speed", "friction")
    assert 18_000 < len(signal) < 20_000
    assert 0 < signal.axis("friction").mean() < 2


def test_time_stamps_of_a_finger(real_data):
    path = sorted((real_data("biotac_slide") / "raw_csv").glob("*_bio.csv"))[0]
    file = read_file(path, axes=["pdc"])
    with path.open() as stream:
        rows = sum(1 for _ in csv.reader(stream)) - 1
    assert file.timing.samples == rows
    assert file.signal.rate == pytest.approx(100, rel=1e-3)
    assert 0 < file.timing.jitter_rms < 1e-3
