import json

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra import numpy as hnp

from tactogram.errors import ParameterError
from tactogram.signal import UNITS, Signal
from tactogram.signal.io import WRITABLE, read_metadata, read_signal, write_signal

EXACT = [suffix for suffix in WRITABLE if suffix != ".flac"]


INTEGERS = [(".wav", "PCM_U8", 8), (".wav", "PCM_16", 16), (".wav", "PCM_24", 24), (".wav", "PCM_32", 32)]


INTEGERS += [(".flac", "PCM_S8", 8), (".flac", "PCM_16", 16), (".flac", "PCM_24", 24)]


def noise(axes=3, length=200, rate=333.3, unit="m/s^2", level=20.0, **kind):
    samples = level * np.random.default_rng(axes).normal(size=(axes, length))
    return Signal(samples, rate, unit, tuple(f"axis {i}" for i in range(axes)), **kind)


def assert_same_kind(a, b):
    assert (a.rate, a.unit, a.axes, a.domain, len(a)) == (b.rate, b.unit, b.axes, b.domain, len(b))


@pytest.mark.parametrize("suffix", WRITABLE)
@pytest.mark.parametrize("axes", [1, 2, 3, 6])
@pytest.mark.parametrize("domain", ["time", "displacement"])
def test_everything_survives(tmp_path, suffix, axes, domain):
    signal = noise(axes, domain=domain)
    metadata = {"simulated": True, "words": {"rough": 1.5, "näme": None}, "long": "x" * 20000}
    write_signal(tmp_path / f"a{suffix}", signal, metadata=metadata)
    back = read_signal(tmp_path / f"a{suffix}")
    assert_same_kind(back, signal)
    if suffix in EXACT:
        np.testing.assert_array_equal(back.samples, signal.samples)
    else:
        np.testing.assert_allclose(back.samples, signal.samples, atol=np.abs(signal.samples).max() / 2**23)
    assert read_metadata(tmp_path / f"a{suffix}") == metadata
    assert [file.name for file in tmp_path.iterdir()] == [f"a{suffix}"]


@given(
    samples=hnp.arrays(
        np.float32,
        st.tuples(st.integers(1, 4), st.integers(1, 12)),
        elements=st.floats(width=32, allow_nan=False, allow_infinity=False),
    ),
    rate=st.floats(0.1, 2e6),
    unit=st.sampled_from(UNITS),
    suffix=st.sampled_from([".wav", ".csv", ".tsv", ".npz"]),
    names=st.sampled_from([("a", "b", "c", "d"), ("1", "2", "3", "4"), ("time", "index", "1 g", "0")]),
)
@settings(deadline=None, max_examples=80)
def test_any_float32_survives_exactly(tmp_path_factory, samples, rate, unit, suffix, names):
    path = tmp_path_factory.mktemp("a") / f"a{suffix}"
    signal = Signal(samples, rate, unit, names[: len(samples)])
    write_signal(path, signal)
    assert_same_kind(read_signal(path), signal)
    np.testing.assert_array_equal(read_signal(path).samples, signal.samples)


def test_npz_holds_no_pickle_and_reads_in_numpy(tmp_path):
    signal = noise()
    write_signal(tmp_path / "a.npz", signal)
    with np.load(tmp_path / "a.npz", allow_pickle=False) as file:
        np.testing.assert_array_equal(file["samples"], signal.samples)
        assert json.loads(str(file["tactogram"]))["unit"] == "m/s^2"


def test_some_axes_can_be_read_by_name(tmp_path):
    for suffix in (".wav", ".csv", ".npz", ".xlsx"):
        path = tmp_path / f"a{suffix}"
        signal = noise()
        write_signal(path, signal)
        assert_same_kind(read_signal(path, axes=("axis 2", "axis 0")), signal.select("axis 2", "axis 0"))
        np.testing.assert_array_equal(read_signal(path, axes=["axis 1"]).samples[0], signal.axis("axis 1"))


def test_a_file_is_replaced_whole_or_not_at_all(tmp_path):
    path = tmp_path / "a.wav"
    write_signal(path, noise(1))
    before = path.read_bytes()
    with pytest.raises(ParameterError, match="full_scale must hold the peak"):
        write_signal(path, noise(1), subtype="PCM_16", full_scale=1.0)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("name", "options", "line"),
    [
        ("a.mp3", {}, "suffix must be one of .wav"),
        ("a", {}, "got none"),
        ("a.txt", {}, "suffix must be one of"),
        ("a.wav", {"subtype": "PCM_12"}, "subtype of .wav must be one of FLOAT"),
        ("a.flac", {"subtype": "FLOAT"}, "subtype of .flac must be one of PCM_24"),
        ("a.csv", {"subtype": "FLOAT"}, "are for .wav and .flac, got .csv"),
        ("a.wav", {"full_scale": 3.0}, "full_scale is for integer samples"),
        ("a.wav", {"subtype": "PCM_16", "full_scale": 0.0}, "full_scale must be > 0"),
        ("a.wav", {"metadata": {"x": object()}}, "metadata must be JSON"),
        ("a.wav", {"metadata": {"x": float("nan")}}, "metadata must be JSON"),
    ],
)
def test_what_cannot_be_written_is_refused_and_leaves_nothing(tmp_path, name, options, line):
    with pytest.raises(ParameterError, match=line) as refusal:
        write_signal(tmp_path / "new" / name, noise(1), **options)
    assert "\n" not in str(refusal.value)
    assert not list(tmp_path.rglob("*.*"))


@pytest.mark.parametrize(
    ("name", "signal", "line"),
    [
        ("a.flac", noise(9), "at most 8 axes, got 9"),
        ("a.flac", noise(1, rate=1e6), "at most 655350 Hz"),
        ("a.xlsx", Signal(np.zeros(1_048_576), 1000, "1"), "at most 1048575 samples"),
    ],
)
def test_formats_have_limits(tmp_path, name, signal, line):
    with pytest.raises(ParameterError, match=line):
        write_signal(tmp_path / name, signal)
    assert not list(tmp_path.iterdir())
