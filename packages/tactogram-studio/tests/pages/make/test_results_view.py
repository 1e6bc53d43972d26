import numpy as np
import pytest

from tactogram.rendering.files import haptic_formats, read_haptic
from tactogram.signal import Signal
from tactogram.signal.io import read_signal
from tactogram_studio.pages.make.results_view import encoded, titles
from tactogram_studio.workspace.shelf import ResultArchive


def stored(folder, **changes):
    values = {"rate": 1000.0, "unit": "m/s^2", "axes": ("x", "y", "z")} | changes
    noise = np.random.default_rng(0).normal(size=(len(values["axes"]), 1000)).astype(np.float32)
    return ResultArchive(folder).keep(Signal(noise, **values), title="tile: 50 %, seed 0", facts={})


def test_signals_and_haptic_files_are_offered():
    assert {"wav", "csv", "npz"} <= set(titles())
    assert set(haptic_formats()) <= set(titles())


def test_a_wav_has_the_samples_and_their_unit(tmp_path):
    result = stored(tmp_path / "made")
    name, data, loss = encoded(result, "wav")
    (tmp_path / name).write_bytes(data)
    assert (name, loss) == ("tile-50-seed-0.wav", "")
    read = read_signal(tmp_path / name)
    assert (read.unit, read.rate) == ("m/s^2", 1000.0)
    np.testing.assert_allclose(read.samples, result.signal().samples, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("format", sorted(haptic_formats()))
@pytest.mark.parametrize("domain", ["time", "displacement"])
def test_a_haptic_file_can_be_read_back_and_its_loss_is_said(format, domain, tmp_path):
    over = {"rate": 10.0, "unit": "1", "axes": ("along",), "domain": "displacement"}
    result = stored(tmp_path / "made", **({} if domain == "time" else over))
    name, data, loss = encoded(result, format)
    (tmp_path / name).write_bytes(data)
    assert read_haptic(tmp_path / name).signal.seconds == pytest.approx(1.0, abs=0.2)
    assert "keeps" in loss
    assert ". Verdict: " in loss
    assert ("mm/s" in loss) is (domain != "time")
