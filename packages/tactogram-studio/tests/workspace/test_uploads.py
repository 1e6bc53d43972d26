import gzip
import io
import pickle
import zipfile
import zlib

import numpy as np
import openpyxl
import pyarrow
import pyarrow.parquet
import pytest
from PIL import Image as Pillow

from tactogram.datasets import cells
from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.signal import Signal
from tactogram.signal.io import WRITABLE, read_signal, write_signal
from tactogram_studio.workspace import uploads
from tactogram_studio.workspace.uploads import (
    read_uploaded_image,
    read_uploaded_signal,
    read_uploaded_study,
    safe_name,
    save_upload,
)
from tactogram_study.study_file import shipped_studies

SIGNAL = Signal(np.sin(np.arange(300, dtype=np.float32)).reshape(3, 100), 1000.0, "m/s^2")


def signal_bytes(tmp_path, suffix=".wav", signal=SIGNAL):
    path = tmp_path / f"made{suffix}"
    write_signal(path, signal)
    return path.read_bytes()


def picture_bytes(size=(8, 6), kind="PNG", colour=(250, 10, 10)):
    file = io.BytesIO()
    Pillow.new("RGB", size, colour).save(file, kind)
    return file.getvalue()


def zipped(members, kind=zipfile.ZIP_DEFLATED):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", kind) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return file.getvalue()


def bomb_png(rows=60_000, columns=60_000):
    """A PNG of a few hundred bytes that says it is 3.6 thousand million pixels."""
    head = columns.to_bytes(4, "big") + rows.to_bytes(4, "big") + bytes([8, 2, 0, 0, 0])

    def chunk(kind, data):
        return len(data).to_bytes(4, "big") + kind + data + zlib.crc32(kind + data).to_bytes(4, "big")

    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


@pytest.mark.parametrize("suffix", WRITABLE)
def test_a_signal_comes_as_it_would_from_a_file(suffix, tmp_path):
    found = read_uploaded_signal(f"C:\\a b\\mine{suffix.upper()}", signal_bytes(tmp_path, suffix))
    np.testing.assert_allclose(found.samples, SIGNAL.samples, atol=1e-6)
    assert (found.rate, found.unit, found.axes) == (1000.0, "m/s^2", ("x", "y", "z"))


def test_options_go_to_the_reader():
    found = read_uploaded_signal("a.csv", b"x,y\n1,2\n3,4\n", rate=10.0, unit="N", axes=["y"])
    assert (found.rate, found.unit, found.samples.tolist()) == (10.0, "N", [[2.0, 4.0]])


def test_errors_name_the_upload_and_no_folder_of_the_server():
    with pytest.raises(DataError) as caught:
        read_uploaded_signal("mine.csv", b"x\n1\n2\n3\nb\n5\n6\n", rate=1.0)
    assert str(caught.value).startswith("mine.csv: row 5, column 'x': expected a number, got 'b'")


@pytest.mark.parametrize(
    ("name", "safe"),
    [
        ("a.wav", "a.wav"),
        ("../../etc/passwd", "passwd"),
        ("..\\..\\boot.ini", "boot.ini"),
        ("/abs/ö 1.WAV", "ö_1.wav"),
        ("触感.png", "触感.png"),
        ("..", "upload"),
        (".ssh", "upload.ssh"),
        ("a\r\nSet-Cookie: x.wav", "a_Set-Cookie_x.wav"),
        ("evil.wav\0.png", "upload.png"),
        ("con.csv", "_con.csv"),
        ("a;rm -rf $(x).csv", "a_rm_-rf_x.csv"),
        ("", "upload"),
        ("x" * 500 + ".csv", "x" * 160 + ".csv"),
        ("Messung 1.CSV.gz", "Messung_1.csv.gz"),
        ("<img src=x onerror=alert(1)>.png", "img_src_x_onerror_alert_1.png"),
    ],
)
def test_names_are_safe_in_any_folder(name, safe):
    assert safe_name(name) == safe


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.exe", b"MZ", "a.exe: expected one of .wav, .flac"),
        ("a", b"x", "a: expected one of .*, got no suffix"),
        ("a.wav", b"", "a.wav: empty file"),
        (
            "a.wav",
            b"MZ\x90\0" * 9,
            "a.wav: content does not match the suffix: must begin with b'RIFF', got b'MZ",
        ),
        ("a.flac", b"\x7fELF" * 9, "a.flac: content does not match the suffix"),
        ("a.csv", b"\x7fELF\0\0", "a.csv: not a text file: zero byte at byte 4"),
        ("a.csv", b"1,2\n\xff\xfe", "a.csv: no rows of numbers below the heading"),
        ("a.h5", b"MZ\x90\0" * 9, "a.h5: content does not match the suffix"),
        ("a.tdms", b"TDSm but not more", "a.tdms: no samples"),
        ("a.exe.gz", gzip.compress(b"MZ", mtime=0), "a_exe.gz: expected one of .wav"),
        ("a.csv.gz", b"1,2\n", "a.csv.gz: content does not match the suffix"),
        ("a.npz", b"PK\x03\x04 but not more", "a.npz: truncated or damaged"),
        ("a.xlsx", b"PK\x03\x04 but not more", "a.xlsx: truncated or damaged"),
        ("a.xlsx", zipped({"a.txt": b"no sheet"}), "a.xlsx: "),
    ],
)
def test_what_is_no_signal_is_refused_in_one_sentence(name, data, message):
    with pytest.raises(TactogramError, match=message) as caught:
        read_uploaded_signal(name, data)
    assert "\n" not in str(caught.value)


def test_a_compressed_table_is_read():
    assert len(read_uploaded_signal("a b.csv.gz", gzip.compress(b"x [g]\n1\n2\n3\n", mtime=0), rate=100)) == 3


def test_a_file_that_is_too_long_is_refused(monkeypatch):
    monkeypatch.setattr(uploads, "MOST_OTHER_BYTES", 10)
    with pytest.raises(DataError, match="a.csv: must have at most 0 MiB, got"):
        read_uploaded_signal("a.csv", b"1\n" * 6)


def test_a_sound_is_measured_by_its_head(tmp_path, monkeypatch):
    monkeypatch.setattr(uploads, "MOST_SAMPLES", 299)
    for suffix in (".wav", ".flac", ".csv"):
        with pytest.raises(
            DataError, match=f"made{suffix}: must have at most 299 samples in all axes, got 300; cut it"
        ):
            read_uploaded_signal(f"made{suffix}", signal_bytes(tmp_path, suffix))


def test_a_pickle_in_an_npz_is_not_loaded(tmp_path):
    class Evil:
        def __reduce__(self):
            return (open, (str(tmp_path / "ran"), "w"))

    file = io.BytesIO()
    np.savez(file, x=np.array([Evil()], dtype=object))
    raw = zipped({"x.npy": pickle.dumps(Evil())})
    for data in (file.getvalue(), raw):
        with pytest.raises(DataError, match="a.npz: .*(pickled objects, which are never loaded|damaged)"):
            read_uploaded_signal("a.npz", data)
    assert not (tmp_path / "ran").exists()


def npy(shape, dtype="<f8"):
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": dtype, "fortran_order": False, "shape": shape})
    return file.getvalue()


@pytest.mark.parametrize("shape", [(10**12,), (10**9, 10**9, 10**9), (-5,), (2, -(10**12))])
def test_an_array_that_claims_more_than_it_holds_is_refused(shape):
    with pytest.raises(DataError, match="a.npz: (x.npy claims|truncated or damaged)"):
        read_uploaded_signal("a.npz", zipped({"x.npy": npy(shape)}))


def test_a_zip_that_grows_too_large_is_refused(monkeypatch):
    monkeypatch.setattr(uploads, "MOST_UNPACKED", 2**20)
    bomb = zipped({"x.npy": npy((300_000,)) + bytes(2_400_000)})
    assert len(bomb) < 10_000
    for name in ("a.npz", "a.xlsx"):
        with pytest.raises(DataError, match="must unpack to at most 1 MiB in 200 parts, got 2 MiB in 1"):
            read_uploaded_signal(name, bomb)
    with pytest.raises(DataError, match="in 200 parts, got 0 MiB in 201"):
        read_uploaded_signal("a.npz", zipped({f"{n}.npy": npy((0,)) for n in range(201)}))


def test_an_entity_bomb_in_a_worksheet_ends_in_a_sentence():
    laughs = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 12))
    xml = f'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY l0 "lol">{laughs}]><workbook>&l11;</workbook>'
    book, file = openpyxl.Workbook(), io.BytesIO()
    book.save(file)
    with zipfile.ZipFile(file) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    members["xl/workbook.xml"] = xml.encode()
    with pytest.raises(TactogramError, match="a.xlsx: "):
        read_uploaded_signal("a.xlsx", zipped(members))


def test_time_stamps_that_span_ages_make_no_endless_signal():
    rows = "t,x\n" + "".join(f"{n / 1000},{n}\n" for n in range(50)) + "1e12,1\n"
    with pytest.raises(TactogramError, match="a.csv: "):
        read_uploaded_signal("a.csv", rows.encode(), time="t")


def test_a_picture_comes_as_it_would_from_a_file():
    image = read_uploaded_image("photo.JPG", picture_bytes(kind="PNG"), width_mm=4.0)
    assert (image.size, image.mm_per_pixel, image.pixels[0, 0].tolist()) == ((6, 8), 0.5, [250, 10, 10])


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.png", bomb_png(), "a.png: a picture must have at most"),
        ("a.png", picture_bytes()[:40], "a.png: not a readable picture"),
        ("a.jpg", b"MZ\x90\0" * 20, "a.jpg: not a readable picture: expected one of PNG"),
        ("a.png", b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n", "a.png: not a readable picture"),
        ("a.svg", b"<svg onload='alert(1)'/>", "a.svg: expected one of .png"),
        ("a.eps", b"%!PS", "a.eps: expected one of .png"),
    ],
)
def test_what_is_no_picture_is_refused_in_one_sentence(name, data, message):
    with pytest.raises(TactogramError, match=message) as caught:
        read_uploaded_image(name, data)
    assert "\n" not in str(caught.value)


def test_a_study_is_read_and_checked_by_its_keys():
    text = shipped_studies()["abx"].read_bytes()
    assert read_uploaded_study("My-Study.toml", text).design.model_dump()["kind"] == "abx"
    with pytest.raises(ParameterError, match="a.toml: .*unknown key 'exec'"):
        read_uploaded_study("a.toml", b'exec = "rm"\n' + text)


@pytest.mark.parametrize(
    "data",
    [
        b"x = [" + b"[" * 100_000,
        b"a." * 50_000 + b"b = 1",
        b"a . " * 400 + b"b = 1",
        b"seed = 1e999",
        b"= 1",
        b"\xff\xfe",
        b"name = 1",
    ],
)
def test_what_is_no_study_is_refused(data):
    with pytest.raises(TactogramError, match="a.toml: "):
        read_uploaded_study("a.toml", data)


def test_an_upload_is_kept_whole_under_a_name_of_its_own(tmp_path):
    data = signal_bytes(tmp_path)
    folder = tmp_path / "kept"
    first = save_upload(folder, "../../mine.wav", data, kind="signal")
    second = save_upload(folder, "mine.wav", data, kind="signal")
    assert (first, second) == (folder / "mine.wav", folder / "mine-2.wav")
    assert read_signal(second).samples.tolist() == SIGNAL.samples.tolist()
    assert sorted(path.name for path in folder.iterdir()) == ["mine-2.wav", "mine.wav"]


def test_what_is_refused_leaves_nothing_behind(tmp_path):
    folder = tmp_path / "kept"
    for name, data, kind in [
        ("a.wav", b"RIFF", "signal"),
        ("a.png", picture_bytes()[:50], "image"),
        ("a.toml", b"x = 1", "study"),
        ("a.parquet", b"PAR1 no more", "table"),
        ("a.py", b"import os", "table"),
    ]:
        with pytest.raises(TactogramError, match=name):
            save_upload(folder, name, data, kind=kind)
    assert not folder.exists()


def test_a_link_that_lies_in_the_folder_is_not_followed(tmp_path):
    outside = tmp_path / "outside.csv"
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "a.csv").symlink_to(outside)
    assert save_upload(tmp_path / "kept", "a.csv", b"1\n", kind="table").name == "a-2.csv"
    assert not outside.exists()


def test_a_table_in_parquet_is_measured_by_its_head(tmp_path, monkeypatch):
    file = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.table({"a": list(range(100))}), file)
    assert save_upload(tmp_path, "a.parquet", file.getvalue(), kind="table").is_file()
    monkeypatch.setattr(cells, "MOST_ROWS", 99)
    with pytest.raises(DataError, match="a.parquet: must have at most 99 rows"):
        save_upload(tmp_path, "a.parquet", file.getvalue(), kind="table")
