import io
import stat
import zipfile

import numpy as np
import pytest
import soundfile
from scipy.io import savemat

from tactogram.errors import DataError
from tactogram_studio.workspace import received, uploads
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.received import ReceivedFolders, safe_path

TABLE = b"t,x\n0,1\n"


@pytest.fixture
def folders(tmp_path):
    return ReceivedFolders(Workspace.at(tmp_path / "workspace"))


def files(*paths, data=TABLE):
    return [(path, io.BytesIO(data)) for path in paths]


def zipped(members, kind=zipfile.ZIP_DEFLATED):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", kind) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return file


def kept(path):
    return sorted(each.relative_to(path).as_posix() for each in path.rglob("*") if each.is_file())


def nothing_left(folders):
    return folders.all() == [] and [*folders.workspace.folder.rglob("*.csv")] == []


@pytest.mark.parametrize(
    ("paths", "name", "found"),
    [
        (["lab/cork/1.csv", "lab/felt/1.csv"], "lab", ["cork/1.csv", "felt/1.csv"]),
        (["lab/recordings.csv", "lab/cork/1.csv"], "lab", ["cork/1.csv", "recordings.csv"]),
        (["cork/1.csv", "cork/2.csv"], "recordings", ["cork/1.csv", "cork/2.csv"]),
        (["cork/1.csv", "felt/1.csv"], "recordings", ["cork/1.csv", "felt/1.csv"]),
        (["1.csv"], "recordings", ["1.csv"]),
        (["cork\\a b (2).csv", "Kork ä/1.csv"], "recordings", ["Kork ä/1.csv", "cork/a b (2).csv"]),
        (["cork/1.csv", "cork/.DS_Store", "__MACOSX/cork/1.csv"], "recordings", ["cork/1.csv"]),
    ],
)
def test_materials_stay_in_their_folders(folders, paths, name, found):
    path = folders.keep(files(*paths))
    assert (path.name, kept(path)) == (name, found)
    assert folders.all() == [path]
    as_zip = folders.keep([("of mine.zip", zipped(dict.fromkeys(paths, TABLE)))])
    assert (as_zip.name, kept(as_zip)) == ("of mine" if name == "recordings" else name, found)
    folders.remove(path)
    assert folders.all() == [as_zip]


@pytest.mark.parametrize("path", ["../a.csv", "cork/../../a.csv", "/etc/a.csv", "C:\\a.csv", "..\\a.csv"])
def test_a_path_that_leads_out_is_refused(folders, path):
    for sent in (files("cork/1.csv", path), [("a.zip", zipped({"cork/1.csv": TABLE, path: TABLE}))]):
        with pytest.raises(DataError, match="leads out of the folder"):
            folders.keep(sent)
    assert nothing_left(folders)


def test_names_are_ones_that_every_system_accepts():
    assert safe_path("Kork: 1/a?.csv") == ("Kork_ 1", "a_.csv")
    assert safe_path("con/nul.csv") == ("_con", "_nul.csv")
    assert safe_path("cork /take. /1\x00.csv.") == ("cork", "take", "1_.csv")
    [long] = safe_path("ä" * 300 + ".csv")
    assert len(long.encode()) == 164
    with pytest.raises(DataError, match="at most 11 folders, got 12"):
        safe_path("a/" * 12 + "1.csv")


def test_a_zip_that_would_fill_the_disk_is_refused(folders, monkeypatch):
    monkeypatch.setattr(received, "MOST_UNPACKED", 2**20)
    with pytest.raises(DataError, match="a.zip: must unpack to at most 1 MiB"):
        folders.keep([("a.zip", zipped({"cork/1.csv": bytes(2**21)}))])
    with pytest.raises(DataError, match="cork/2.csv: all files together must have at most 1 MiB; put the"):
        folders.keep(files("cork/1.csv", "cork/2.csv", data=bytes(600_000)))
    assert nothing_left(folders)


def test_a_file_is_as_large_as_one_that_is_uploaded_alone(folders, monkeypatch):
    monkeypatch.setitem(received.most_bytes_of.__globals__["MOST_BYTES"], ".csv", 1000)
    with pytest.raises(DataError, match="cork/2.csv: must have at most 0 MiB; put the folder into"):
        folders.keep([*files("cork/1.csv"), *files("cork/2.csv", data=bytes(1001))])
    assert nothing_left(folders)
    folders.keep([*files("cork/1.csv"), *files("cork/film.mp4", data=bytes(1001))])


def test_a_file_that_unpacks_to_too_much_is_refused_and_a_damaged_one_is_kept(folders, monkeypatch):
    monkeypatch.setattr(uploads, "MOST_UNPACKED", 2**20)
    monkeypatch.setattr(uploads, "MOST_SAMPLES", 1000)
    silence, samples = io.BytesIO(), np.zeros(2000)
    soundfile.write(silence, samples, 1000, format="FLAC")
    silence.seek(0)
    arrays = zipped({"x.npy": bytes(2**21)})
    savemat(matrix := io.BytesIO(), {"x": np.zeros(2**18)}, do_compression=True)
    for suffix, file in {".FLAC": silence, ".npz": arrays, ".mat": matrix}.items():
        raw = file.getvalue()
        with pytest.raises(DataError, match=f"cork/1{suffix}: must .*; cut it; put the folder into the work"):
            folders.keep([(f"cork/1{suffix}", io.BytesIO(raw))])
        assert folders.all() == []
        kept = folders.keep([(f"cork/1{suffix}", io.BytesIO(raw[:40]))])
        assert (kept / f"cork/1{suffix}").read_bytes() == raw[:40]
        folders.remove(kept)


@pytest.mark.parametrize(
    ("sent", "says"),
    [
        (files, "no files; choose a folder"),
        (lambda: files("cork/a?.csv", "cork/a_.csv"), "the same name as cork/a..csv; rename one"),
        (lambda: files("cork/a.csv", "cork/A.csv"), "the same name as cork/a.csv; rename one"),
        (lambda: files("cork/a.csv", "cork/a.csv"), "two files have the same name"),
        (lambda: files(*(f"{i}.csv" for i in range(5001))), "at most 5000 files, got 5001; put the folder"),
        (lambda: [("a.zip", io.BytesIO(b"PK\x03\x04 nothing"))], "a.zip: truncated or damaged"),
        (lambda: [("a.zip", io.BytesIO(b""))], "a.zip: truncated or damaged"),
    ],
)
def test_what_cannot_be_kept_is_refused_and_leaves_nothing(folders, sent, says):
    with pytest.raises(DataError, match=says):
        folders.keep(sent())
    assert nothing_left(folders)


def test_a_damaged_encrypted_or_linking_zip_leaves_nothing(folders):
    raw = bytearray(zipped({"cork/1.csv": TABLE * 1000}, zipfile.ZIP_STORED).getvalue())
    raw[100] ^= 1
    with pytest.raises(DataError, match="a.zip: damaged: Bad CRC-32"):
        folders.keep([("a.zip", io.BytesIO(raw))])
    encrypted = zipped({"cork/1.csv": TABLE}).getvalue()
    entry = encrypted.index(b"PK\x01\x02")
    encrypted = encrypted[: entry + 8] + b"\1" + encrypted[entry + 9 :]
    with pytest.raises(DataError, match="is encrypted; save it without a password"):
        folders.keep([("a.zip", io.BytesIO(encrypted))])
    link = zipfile.ZipInfo("cork/2.csv")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    with pytest.raises(DataError, match="no files"):
        folders.keep([("a.zip", zipped({link: b"/etc/passwd"}))])
    assert nothing_left(folders)


def test_what_was_sent_is_no_run_or_store_of_the_workspace(folders):
    folders.keep(files("a/dataset.json", "a/recipe.toml", "a/answers.sqlite", "a/design.toml"))
    workspace = folders.workspace
    assert (workspace.stores(), workspace.runs(), workspace.sessions(), workspace.files(".toml")) == (
        [],
        [],
        [],
        [],
    )
    with pytest.raises(DataError, match="is not a received folder"):
        folders.remove(workspace.folder)
