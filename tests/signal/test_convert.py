import itertools

import numpy as np
import pytest

from tactogram.signal import Signal
from tactogram.signal.io import WRITABLE, read_metadata, read_signal, write_signal
from tactogram.workflows.data.convert import convert


@pytest.mark.parametrize(("source", "target"), list(itertools.product(WRITABLE, WRITABLE)))
def test_every_format_to_every_other(tmp_path, source, target):
    signal = Signal(np.random.default_rng(0).normal(size=(3, 60)), 333.3, "m/s^2")
    write_signal(tmp_path / f"a{source}", signal, metadata={"simulated": True})
    facts = convert(tmp_path / f"a{source}", tmp_path / "made" / f"b{target}")
    back = read_signal(tmp_path / "made" / f"b{target}")
    assert (back.rate, back.unit, back.axes) == (signal.rate, signal.unit, signal.axes)
    np.testing.assert_allclose(back.samples, signal.samples, atol=1e-6)
    assert read_metadata(tmp_path / "made" / f"b{target}") == {"simulated": True}
    assert (facts["samples"], facts["unit"], facts["rate_hz"]) == (60, "m/s^2", 333.3)
    assert facts["rms"] == pytest.approx(1, abs=0.2)


def test_a_foreign_table_is_described_on_the_way(tmp_path):
    rng = np.random.default_rng(1)
    t = (np.arange(500) + 0.05 * rng.normal(size=500)) / 200
    rows = "\n".join(f"{a:.6f},{b:.6f}" for a, b in zip(t, rng.normal(size=500), strict=True))
    (tmp_path / "a.csv").write_text("t [s],x\n" + rows)
    facts = convert(tmp_path / "a.csv", tmp_path / "b.wav", unit="g", axes=["vertical"], resample_to=400)
    signal = read_signal(tmp_path / "b.wav")
    assert (signal.rate, signal.unit, signal.axes) == (400, "m/s^2", ("vertical",))
    assert read_metadata(tmp_path / "b.wav")["timing"] == facts["timing"]
    assert facts["timing"]["jitter_rms"] == pytest.approx(0.05 / 200, rel=0.1)


def test_a_file_can_be_converted_in_place(tmp_path):
    write_signal(tmp_path / "a.wav", Signal(np.arange(9), 100, "N"), subtype="PCM_16")
    convert(tmp_path / "a.wav", tmp_path / "a.wav", subtype="FLOAT")
    assert read_signal(tmp_path / "a.wav").unit == "N"
    assert [path.name for path in tmp_path.iterdir()] == ["a.wav"]
