"""Files of all formats: what is written comes back, what is broken is refused in one line that names the file."""

import bz2
import gzip
import json
import lzma
import os
import struct
import time
import zipfile
from datetime import datetime

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.feather
import pyarrow.parquet
import pytest
import soundfile
from hypothesis import given, settings, strategies as st
from hypothesis.extra import numpy as hnp
from tests.signal.io.sample_files import WAVE, XYZ, N, T, X, Y, Z, hdf5, noise, refusal, tdms, wav, written

from tactogram.errors import DataError, ParameterError
from tactogram.signal import UNITS, Signal
from tactogram.signal.io import WRITABLE, read_file, read_metadata, read_signal, write_signal
from tactogram.workflows.data.convert import convert


def test_options_that_mean_nothing_are_refused(tmp_path):
    soundfile.write(tmp_path / "a.wav", X, 1000)
    with pytest.raises(ParameterError, match="time does not apply to .wav"):
        read_signal(tmp_path / "a.wav", time="t")
    with pytest.raises(ParameterError, match="full_scale"):
        read_signal(written(tmp_path, "1\n2\n"), full_scale=2, rate=1)


@pytest.mark.parametrize("suffix", [*WRITABLE, ".txt"])
def test_an_empty_file_is_refused(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    path.touch()
    assert refusal(path) == "empty file"


@pytest.mark.parametrize("suffix", [".wav", ".flac", ".npz", ".xlsx"])
def test_a_text_under_another_name_is_refused(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    path.write_text("hello, this is a text and nothing else\n" * 20)
    line = refusal(path)
    assert "not a" in line
    if suffix in (".wav", ".flac"):
        assert "at byte 0, got b'hell" in line


@pytest.mark.parametrize("suffix", [".wav", ".flac", ".npz", ".xlsx"])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.9, 0.99])
def test_a_truncated_file_is_refused(tmp_path, suffix, share):
    whole = tmp_path / f"whole{suffix}"
    write_signal(whole, Signal(np.random.default_rng(0).normal(size=(3, 5000)), 1000, "N"))
    path = tmp_path / f"a{suffix}"
    raw = whole.read_bytes()
    path.write_bytes(raw[: int(share * len(raw))])
    assert refusal(path)


def test_a_rate_of_zero_is_refused(tmp_path):
    path = wav(tmp_path, subtype="PCM_16")
    raw = bytearray(path.read_bytes())
    raw[24:28] = struct.pack("<I", 0)
    path.write_bytes(raw)
    assert refusal(path) == "rate must be > 0 Hz, got 0 at byte 24"
    np.savez(tmp_path / "a.npz", x=np.zeros(9), rate=0.0)
    assert refusal(tmp_path / "a.npz", axes=["x"]) == "rate must be > 0 and finite, got 0"
    (tmp_path / "a.csv").write_text("1\n2\n")
    with pytest.raises(DataError, match=r"a\.csv: rate must be > 0 and finite, got 0$"):
        read_signal(tmp_path / "a.csv", rate=0)
    with pytest.raises(ParameterError, match="rate must be greater than 0, got 0"):
        convert(tmp_path / "a.csv", tmp_path / "b.wav", rate=0)


def test_no_file_is_no_file(tmp_path):
    for function in (read_signal, read_file, read_metadata):
        with pytest.raises(DataError, match="no such file"):
            function(tmp_path / "a.wav")
        (tmp_path / "b.wav").mkdir(exist_ok=True)
        with pytest.raises(DataError, match="is a folder"):
            function(tmp_path / "b.wav")


@pytest.mark.parametrize("suffix", WRITABLE)
@given(data=st.data())
@settings(deadline=None, max_examples=40)
def test_damage_anywhere_is_one_line_or_harmless(tmp_path_factory, suffix, data):
    path = tmp_path_factory.mktemp("damaged") / f"a{suffix}"
    write_signal(path, Signal(np.random.default_rng(0).normal(size=(2, 30)), 500, "N", ("a", "b")))
    raw = bytearray(path.read_bytes())
    # A share of the file, in 1e-5: a worksheet's length depends on the time of day in it.
    share = st.integers(0, 99_999)
    for _ in range(data.draw(st.integers(1, 4))):
        raw[data.draw(share) * len(raw) // 100_000] = data.draw(st.integers(0, 255))
    path.write_bytes(raw[: 1 + data.draw(share) * len(raw) // 100_000])
    for function in (read_file, read_metadata):
        try:
            function(path)
        except DataError as error:
            assert "\n" not in str(error)  # noqa: PT017


EXACT = [suffix for suffix in WRITABLE if suffix != ".flac"]


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


@pytest.mark.parametrize("suffix", WRITABLE)
def test_a_file_does_not_state_when_it_was_written(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    begun = int(time.time())
    write_signal(path, Signal(np.random.default_rng(0).normal(size=(3, 500)), 1000, "N"))
    if zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as archive:
            assert {member.date_time for member in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
            content = b"".join(map(archive.read, archive.namelist()))
    else:
        content = path.read_bytes()
    assert f"{datetime.now():%Y-%m-}".encode() not in content
    assert not any(struct.pack("<I", at) in content for at in range(begun, int(time.time()) + 1))


@pytest.mark.skipif(os.name == "nt", reason="no limit of a file's size")
@pytest.mark.parametrize("suffix", WRITABLE)
def test_a_full_disk_is_named_and_the_old_file_stays(tmp_path, suffix):
    import resource

    signal = Signal(np.random.default_rng(0).normal(size=(3, 5000)), 1000, "N")
    path = tmp_path / f"a{suffix}"
    write_signal(path, signal)
    before = path.read_bytes()
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, limit[1]))
    try:
        with pytest.raises(OSError, match=f"File too large: '{path}'"):
            write_signal(path, signal)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    assert [file.read_bytes() for file in tmp_path.iterdir()] == [before]


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


RECORDS = [{"t": t, "acc": {"x": x, "y": y, "z": z}} for t, x, y, z in zip(T, WAVE, Y, Z, strict=True)]


def matlab73(path):
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in {"acc": XYZ, "Fs": np.array([[500.0]])}.items():
            file.create_dataset(name, data=values).attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM")


def arrow(path, write):
    fields = [pa.field("t_s", pa.float64())]
    fields += [pa.field(f"a{name}", pa.float32(), metadata={"unit": "g"}) for name in "xyz"]
    write(pa.table([T, *XYZ.astype(np.float32)], pa.schema(fields)), path)


def table_text():
    return "t [s],ax [g],ay [g],az [g]\n" + "\n".join(
        f"{t},{x},{y},{z}" for t, x, y, z in zip(T, WAVE, Y, Z, strict=True)
    )


def zipped(path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("take.csv", table_text())


FILES = {
    "a.tdms": tdms,
    "a.h5": hdf5,
    "matlab.mat": matlab73,
    "a.parquet": lambda path: arrow(path, pa.parquet.write_table),
    "a.feather": lambda path: arrow(path, pa.feather.write_feather),
    "acc.npy": lambda path: np.save(path, XYZ.T),
    "named.npy": lambda path: np.save(path, np.rec.fromarrays([T, *XYZ], names="t,ax,ay,az")),
    "rates.npz": lambda path: np.savez(path, acc=XYZ, fs=np.array([[500]]), cal=np.ones(3), note="cork"),
    "dated.npz": lambda path: np.savez(
        path, ax=WAVE, ay=Y, az=Z, time=np.datetime64("2026-01-02") + np.arange(N) * np.timedelta64(2, "ms")
    ),
    "a.jsonl": lambda path: path.write_text("\n".join(map(json.dumps, RECORDS))),
    "a.csv.gz": lambda path: path.write_bytes(gzip.compress(table_text().encode())),
    "a.txt.bz2": lambda path: path.write_bytes(bz2.compress(table_text().encode())),
    "a.csv.xz": lambda path: path.write_bytes(lzma.compress(table_text().encode())),
    "a.csv.zip": zipped,
}


@pytest.mark.parametrize("name", FILES)
def test_formats_of_others_are_read(tmp_path, name):
    FILES[name](tmp_path / name)
    stated = name not in ("matlab.mat", "a.jsonl") and not name.endswith((".npy", ".npz"))
    file = read_file(tmp_path / name, unit=None if stated else "g", rate=500 if name == "acc.npy" else None)
    assert (file.stream, file.signal.unit, file.signal.axes) == ("acceleration", "m/s^2", ("x", "y", "z"))
    assert file.signal.rate == pytest.approx(500)
    np.testing.assert_allclose(file.signal.samples, 9.80665 * XYZ, atol=1e-4)


@pytest.mark.parametrize(
    "suffix",
    [
        ".h5",
        ".tdms",
        ".parquet",
        ".feather",
        ".npy",
        ".jsonl",
        ".csv.gz",
        ".csv.xz",
        ".zip",
        ".xls",
        ".ods",
    ],
)
@pytest.mark.parametrize("raw", [b"", b"hello, no such file\n" * 20])
def test_a_file_of_another_kind_is_one_line(tmp_path, suffix, raw):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(raw)
    with pytest.raises(DataError) as caught:
        read_signal(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("path", [5, None, np.zeros(4)])
def test_what_is_no_path_is_refused_in_one_line(path, tmp_path):
    tick = Signal([0, 1, -1, 0], 1000, "m/s^2")
    for job in (read_signal, lambda each: write_signal(each, tick)):
        with pytest.raises(ParameterError, match=r"^path must be a path, got "):
            job(path)
    write_signal(tmp_path / "tick.wav", tick)
    with pytest.raises(DataError, match=r"tick\.wav: rate must be a number, got 'fast'$"):
        read_signal(tmp_path / "tick.wav", rate="fast")


def test_a_list_is_no_signal_and_is_not_written(tmp_path):
    with pytest.raises(ParameterError) as caught:
        write_signal(tmp_path / "x.wav", [0, 1])
    assert str(caught.value) == (
        "signal must be a Signal, which states its rate and unit, got list; make one, `Signal(samples, rate, unit)`"
    )
    assert not list(tmp_path.iterdir())
