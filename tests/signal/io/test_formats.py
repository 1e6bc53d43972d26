"""Formats read through libraries: each file is made by the library, and read with its right answer."""

import bz2
import gzip
import json
import lzma
import zipfile

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.feather
import pyarrow.parquet
import pytest
import soundfile
from nptdms import ChannelObject, RootObject, TdmsWriter
from PIL import Image

from tactogram.errors import DataError, ParameterError
from tactogram.signal.io import read_file, read_image, read_signal

N = 200


T = np.arange(N) / 500


X, Y, Z = np.sin(0.3 * np.arange(N)), np.cos(0.2 * np.arange(N)), 1 + 0.1 * np.sin(np.arange(N))


XYZ = np.stack([X, Y, Z])


RECORDS = [{"t": t, "acc": {"x": x, "y": y, "z": z}} for t, x, y, z in zip(T, X, Y, Z, strict=True)]


def tdms(path):
    facts = {"wf_increment": 0.002, "wf_start_offset": 0.0, "unit_string": "g"}
    with TdmsWriter(path) as file:
        channels = [ChannelObject("acc", name, each, facts) for name, each in zip("xyz", XYZ, strict=True)]
        file.write_segment([RootObject(), *channels])


def hdf5(path, **attributes):
    with h5py.File(path, "w") as file:
        data = file.create_dataset("run/acc", data=XYZ.T, compression="gzip")
        data.attrs.update({"unit": "g", "fs": 500.0} | attributes)


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
        f"{t},{x},{y},{z}" for t, x, y, z in zip(T, X, Y, Z, strict=True)
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
        path, ax=X, ay=Y, az=Z, time=np.datetime64("2026-01-02") + np.arange(N) * np.timedelta64(2, "ms")
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


def test_channels_of_tdms_have_rates_of_their_own(tmp_path):
    with TdmsWriter(tmp_path / "a.tdms") as file:
        fast = ChannelObject("A", "ai0", np.tile(X, 5), {"wf_increment": 1e-4, "unit_string": "V"})
        file.write_segment([fast, ChannelObject("A", "force", X, {"wf_increment": 1e-3, "unit_string": "N"})])
    file = read_file(tmp_path / "a.tdms")
    assert (file.stream, file.signal.rate, file.others["voltage"].rate) == (
        "force",
        pytest.approx(1000),
        pytest.approx(10000),
    )


def test_a_tdms_that_is_cut_off_is_read_and_said(tmp_path):
    tdms(tmp_path / "a.tdms")
    (tmp_path / "a.tdms").write_bytes((tmp_path / "a.tdms").read_bytes()[:-1000])
    assert "last segment is cut off: what is there is read" in read_file(tmp_path / "a.tdms").notes


SOUNDS = {
    ".aiff": ("AIFF", "PCM_16"), ".au": ("AU", "PCM_16"), ".caf": ("CAF", "PCM_16"), ".w64": ("W64", "FLOAT"),
    ".rf64": ("RF64", "PCM_24"), ".ogg": ("OGG", "VORBIS"), ".opus": ("OGG", "OPUS"), ".mp3": ("MP3", "MPEG_LAYER_III"),
}  # fmt: skip


@pytest.mark.parametrize("suffix", SOUNDS)
def test_sounds_of_others_are_read(tmp_path, suffix):
    form, subtype = SOUNDS[suffix]
    wave = 0.5 * np.sin(2 * np.pi * 250 * np.arange(24000) / 48000)
    soundfile.write(tmp_path / f"a{suffix}", wave, 48000, subtype, format=form)
    signal = read_signal(tmp_path / f"a{suffix}")
    assert (signal.rate, signal.unit, len(signal)) == (48000, "1", 24000)
    np.testing.assert_allclose(signal.samples[0, 4000:20000], wave[4000:20000], atol=0.02)


@pytest.mark.parametrize("suffix", [".aiff", ".au", ".caf", ".w64", ".rf64", ".mp3"])
def test_a_sound_that_is_cut_off_is_refused(tmp_path, suffix):
    form, subtype = SOUNDS[suffix]
    soundfile.write(tmp_path / f"a{suffix}", np.tile(XYZ[:2], 50).T / 2, 48000, subtype, format=form)
    raw = (tmp_path / f"a{suffix}").read_bytes()
    (tmp_path / f"a{suffix}").write_bytes(raw[: 2 * len(raw) // 3])
    with pytest.raises(DataError, match="truncated|damaged"):
        read_signal(tmp_path / f"a{suffix}")


def test_a_sound_of_a_phone_says_how_to_convert_it(tmp_path):
    (tmp_path / "a.m4a").write_bytes(b"\0\0\0\x20ftypM4A ")
    with pytest.raises(ParameterError, match="convert it to .wav, e.g. `ffmpeg -i a.m4a a.wav`"):
        read_signal(tmp_path / "a.m4a")


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


def test_a_photograph_of_a_phone_is_read(tmp_path):
    heif = pytest.importorskip("pillow_heif")
    heif.register_heif_opener()
    Image.new("RGB", (64, 48), (200, 100, 50)).save(tmp_path / "a.heic", quality=95)
    image = read_image(tmp_path / "a.heic")
    assert image.pixels.shape == (48, 64, 3)
    np.testing.assert_allclose(image.pixels.mean(axis=(0, 1)), (200, 100, 50), atol=4)
