"""What an import promises: all or nothing, the same data once, and a name for every broken file."""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import psutil
import pytest
from PIL import Image as Pillow
from tests.datasets.importers.sample_files import write_noise, write_photo

from tactogram.cli import main
from tactogram.datasets import add_recordings, open_store
from tactogram.datasets.importing import import_dataset
from tactogram.datasets.store import writer
from tactogram.datasets.store.store import problems
from tactogram.errors import DataError, ParameterError
from tactogram_benchmark.importers import biotac_slide

IMPORT = """
import sys
from pathlib import Path
from tactogram.datasets.importing import import_dataset

if __name__ == "__main__":
    import_dataset("biotac_slide", Path(sys.argv[1]), Path(sys.argv[2]), workers=2,
                   progress=lambda done, total: print(done, flush=True))
"""


def test_a_killed_import_leaves_no_process_behind(source, tmp_path):
    script = source / "import.py"
    script.write_text(IMPORT)
    process = subprocess.Popen(
        [sys.executable, script, source, tmp_path / "s"], stdout=subprocess.PIPE, text=True
    )
    process.stdout.readline()
    children = psutil.Process(process.pid).children(recursive=True)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    _, alive = psutil.wait_procs(children, timeout=60)
    assert len(children) >= 2
    assert alive == []


def write_material(folder, number, *, recordings=3, frames=20, **changes):
    """Write ``matNN.npz`` as BioTac_slide has it."""
    rng = np.random.default_rng(number)
    rows = recordings * frames
    arrays = {
        "pac": rng.integers(0, 900, (rows, 22), dtype=np.int16),
        "tdc": rng.integers(0, 9, rows, dtype=np.int16),
        "tac": rng.integers(0, 200, rows, dtype=np.int16),
        "pdc": rng.integers(0, 200, rows, dtype=np.int16),
        "electrodes": rng.integers(0, 99, (rows, 19), dtype=np.int16),
        "lengths": np.full(recordings, frames, np.int32),
        "recording": np.arange(1, recordings + 1, dtype=np.int16),
        "pac_rate_hz": np.int32(2200),
        "frame_rate_hz": np.int32(100),
    }
    folder.mkdir(exist_ok=True)
    np.savez(folder / f"mat{number:02d}.npz", **(arrays | changes))
    return arrays


@pytest.fixture
def source(tmp_path):
    folder = tmp_path / "source"
    for number in range(1, 5):
        write_material(folder, number)
    (folder / "materials.csv").write_text(
        "material_id,name,code\n" + "".join(f"{n},Material {n},M{n}\n" for n in range(1, 5))
    )
    (folder / "images").mkdir()
    Pillow.new("RGB", (6, 4), (200, 100, 50)).save(folder / "images" / "mat02.jpg")
    return folder


def left_in(folder, source):
    return sorted(p.name for p in folder.iterdir() if p != source)


@pytest.mark.parametrize("workers", [1, 2])
def test_what_is_in_the_files_is_in_the_store(source, tmp_path, workers):
    seen = []
    report = import_dataset(
        *("biotac_slide", source, tmp_path / "s"), workers=workers, progress=lambda d, t: seen.append((d, t))
    )
    store = open_store(tmp_path / "s")
    assert report["recordings"] == len(store) == 12
    assert [i.source for i in store.index][:4] == ["mat01.npz#1", "mat01.npz#2", "mat01.npz#3", "mat02.npz#1"]
    assert seen == [(1, 4), (2, 4), (3, 4), (4, 4)]
    first = store.index[3]
    assert (first.material, first.labels["recording"]) == ("Material 2", "1")
    pac = write_material(source, 2)["pac"]
    np.testing.assert_array_equal(store.signal(first.id, "pac").samples[0], pac[:20].reshape(-1))
    assert store.image(first.id).pixels.shape == (4, 6, 3)
    assert store.image(store.index[0].id) is None
    assert problems(store) == []
    assert left_in(tmp_path, source) == ["s"]


def test_importing_again_changes_nothing(source, tmp_path):
    first = import_dataset("biotac_slide", source, tmp_path / "s")
    before = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "s").iterdir()}
    again = import_dataset("biotac_slide", source, tmp_path / "s")
    assert (first["unchanged"], again["unchanged"]) == (False, True)
    assert first["sha256"] == again["sha256"]
    assert {p.name: p.stat().st_mtime_ns for p in (tmp_path / "s").iterdir()} == before


def test_importing_something_else_to_the_same_place_is_refused(source, tmp_path):
    import_dataset("biotac_slide", source, tmp_path / "s")
    sha256 = open_store(tmp_path / "s").sha256
    (source / "mat03.npz").unlink()
    with pytest.raises(DataError, match=r"holds something else .* \(9 recordings here, 12 there\)"):
        import_dataset("biotac_slide", source, tmp_path / "s")
    write_material(source, 7)
    with pytest.raises(DataError, match=r"mat07.npz#1 is another or new"):
        import_dataset("biotac_slide", source, tmp_path / "s")
    (source / "materials.csv").write_text("material_id,name\n1,Renamed\n")
    with pytest.raises(DataError, match=r"mat01.npz#1 is another or new"):
        import_dataset("biotac_slide", source, tmp_path / "s", skip_bad=True)
    assert open_store(tmp_path / "s").sha256 == sha256


def test_what_was_added_by_hand_is_not_overwritten(source, tmp_path):
    import_dataset("biotac_slide", source, tmp_path / "s")
    other = tmp_path / "other"
    write_material(other, 9)
    add_recordings(open_store(tmp_path / "s"), biotac_slide.read(biotac_slide.find(other)[0]))
    with pytest.raises(DataError, match="12 recordings here, 15 there"):
        import_dataset("biotac_slide", source, tmp_path / "s")
    assert len(open_store(tmp_path / "s")) == 15


def test_a_folder_that_is_no_store_is_not_touched(source, tmp_path):
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / "mine.txt").write_text("x")
    with pytest.raises(DataError, match="is not a store"):
        import_dataset("biotac_slide", source, tmp_path / "s")
    assert os.listdir(tmp_path / "s") == ["mine.txt"]
    with pytest.raises(DataError, match="mine.txt is not a store"):
        import_dataset("biotac_slide", source, tmp_path / "s" / "mine.txt")


BROKEN = {
    "empty": (lambda p: p.write_bytes(b""), "mat03.npz: empty file"),
    "truncated": (lambda p: p.write_bytes(p.read_bytes()[:500]), "mat03.npz: truncated or damaged"),
    "text": (lambda p: p.write_text("hello"), "mat03.npz: "),
    "no pac": (lambda p: np.savez(p, tdc=np.zeros(3)), "lacks pac, tac"),
    "ragged": (
        lambda p: write_material(p.parent, 3, tdc=np.zeros(7)),
        "tdc must have 60 rows as lengths say, got 7",
    ),
    "rate": (lambda p: write_material(p.parent, 3, pac_rate_hz=np.int32(0)), "must be 100 and 2200 Hz"),
    "narrow": (lambda p: write_material(p.parent, 3, pac=np.zeros((60, 21))), "pac must have 22 columns"),
    "nan": (
        lambda p: write_material(p.parent, 3, tdc=np.full(60, np.nan)),
        "samples must be finite, got nan",
    ),
    "pickle": (
        lambda p: write_material(p.parent, 3, tdc=np.array([{}] * 60, dtype=object)),
        "holds pickled objects",
    ),
    "no samples": (lambda p: write_material(p.parent, 3, recordings=0), "holds no recording"),
}


@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_file_stops_the_import_and_is_named(source, tmp_path, kind):
    damage, says = BROKEN[kind]
    damage(source / "mat03.npz")
    with pytest.raises(DataError) as caught:
        import_dataset("biotac_slide", source, tmp_path / "s")
    assert says in str(caught.value)
    assert "mat03.npz" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "leave it out by `skip_bad`" in str(caught.value)
    assert left_in(tmp_path, source) == []


@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_file_is_skipped_and_reported_when_asked(source, tmp_path, kind):
    damage, says = BROKEN[kind]
    damage(source / "mat03.npz")
    report = import_dataset("biotac_slide", source, tmp_path / "s", skip_bad=True)
    [skipped] = report["skipped"]
    assert skipped["source"] == "mat03.npz"
    assert says in skipped["reason"]
    store = open_store(tmp_path / "s")
    assert len(store) == 9
    assert store.facts.skipped == (skipped,)


def test_a_broken_photograph_is_named(source, tmp_path):
    (source / "images" / "mat02.jpg").write_text("no picture")
    with pytest.raises(DataError, match=r"mat02.jpg: not a readable picture"):
        import_dataset("biotac_slide", source, tmp_path / "s")
    report = import_dataset("biotac_slide", source, tmp_path / "s", skip_bad=True)
    assert report["recordings"] == 12
    assert "mat02.jpg" in report["skipped"][0]["source"]


def test_nothing_but_broken_files_makes_no_store(tmp_path):
    source = tmp_path / "source"
    source.mkdir()
    (source / "mat01.npz").write_text("x")
    with pytest.raises(DataError, match="no recordings"):
        import_dataset("biotac_slide", source, tmp_path / "s", skip_bad=True)
    assert left_in(tmp_path, source) == []


def test_the_same_samples_in_two_files_are_one_recording_and_it_is_said(source, tmp_path):
    (source / "materials.csv").unlink()
    (source / "raw_csv").mkdir()
    held = dict(np.load(source / "mat01.npz"))
    np.savez(source / "mat01.npz", **(held | {"pac": np.tile(held["pac"][:20], (3, 1))}))
    held = dict(np.load(source / "mat01.npz"))
    same = {
        n: np.concatenate([v[:20]] * 2 + [v[40:]]) if len(v) == 60 else v for n, v in held.items() if v.shape
    }
    np.savez(source / "mat01.npz", **(held | same))
    report = import_dataset("biotac_slide", source, tmp_path / "s")
    [twice] = report["duplicates"]
    assert (twice["kept"], twice["dropped"]) == ("mat01.npz#1", "mat01.npz#2")
    assert report["recordings"] == 11
    assert import_dataset("biotac_slide", source, tmp_path / "s")["unchanged"]


def test_unknown_sets_and_places_are_refused(source, tmp_path):
    with pytest.raises(ParameterError, match="must be one of biotac_slide, cdplab, cluster"):
        import_dataset("lmt", source, tmp_path / "s")
    with pytest.raises(DataError, match="must be a folder"):
        import_dataset("biotac_slide", tmp_path / "nowhere", tmp_path / "s")
    with pytest.raises(DataError, match=r"must hold matNN.npz or"):
        import_dataset("biotac_slide", source / "images", tmp_path / "s")
    with pytest.raises(ParameterError, match="workers must be >= 1"):
        import_dataset("biotac_slide", source, tmp_path / "s", workers=0)
    assert left_in(tmp_path, source) == []


KILLED_AT_EACH_STEP = """
import os, shutil, sys
from pathlib import Path
import pandas  # by pyarrow on its first use: here once, not in each child
import pyarrow.parquet as pq
from tactogram.datasets import add_recordings, open_store
from tactogram_benchmark.importers import biotac_slide
from tactogram.datasets.store import shards, writer
from tactogram.datasets.importer import importers
from tactogram.datasets.importing import import_dataset

kind, source, folder = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
shards.GROUP_ROWS, shards.SHARD_ROWS = 2, 6
writer.KEPT_S = 0 if kind == "keep" else writer.KEPT_S
importers()

def add(out):
    store = open_store(out)
    return lambda: add_recordings(store, biotac_slide.read(biotac_slide.find(source)[0]))

def work(step):
    out = folder / f"step{step}" / "s"
    out.parent.mkdir()
    if kind == "add":
        shutil.copytree(folder / "s", out)
    task = add(out) if kind == "add" else lambda: import_dataset("biotac_slide", source, out, workers=1)
    left = step

    def killing(real):
        def call(*args, **options):
            nonlocal left
            left -= 1
            if left == 0:
                os.kill(os.getpid(), 9)
            return real(*args, **options)
        return call

    for name in ("replace", "unlink", "write_text", "mkdir", "rename"):
        setattr(Path, name, killing(getattr(Path, name)))
    for name in ("write_table", "close"):
        setattr(pq.ParquetWriter, name, killing(getattr(pq.ParquetWriter, name)))
    task()

for step in range(1, 200):
    child = os.fork()
    if child == 0:
        work(step)
        os._exit(0)
    if os.waitpid(child, 0)[1] == 0:
        break
"""


@pytest.mark.parametrize("kind", ["import", "add"])
def test_killed_at_any_step_there_is_nothing_or_the_old_store_or_the_new(source, tmp_path, kind):
    more = tmp_path / "more"
    write_material(more, 9)
    import_dataset("biotac_slide", source, tmp_path / "s")
    argument = source if kind == "import" else more
    subprocess.run([sys.executable, "-c", KILLED_AT_EACH_STEP, kind, argument, tmp_path], check=True)
    found = []
    steps = sorted(tmp_path.glob("step*"), key=lambda p: int(p.name[4:]))
    for folder in steps:
        if (folder / "s").exists():
            store = open_store(folder / "s")
            assert problems(store) == []
            found.append(len(store))
        else:
            found.append(0)
            assert all(p.name.startswith("s.part-") for p in folder.iterdir())
    before, after = (0, 12) if kind == "import" else (12, 15)
    assert len(steps) > 6
    assert set(found) == {before, after}
    assert found == sorted(found)
    if kind == "import":
        halfway = steps[len(steps) // 2]
        assert os.listdir(halfway) != []
        assert import_dataset("biotac_slide", source, halfway / "s")["stale_parts"] == []
        assert os.listdir(halfway) == ["s"]


@pytest.mark.slow
def test_killed_at_any_step_an_import_goes_on_from_its_last_checkpoint(source, tmp_path, monkeypatch):
    shutil.copy(source / "mat01.npz", source / "mat05.npz")  # duplicates are listed once
    with (source / "materials.csv").open("a") as names:
        names.write("5,Material 1,M5\n")
    expected = import_dataset("biotac_slide", source, tmp_path / "s")
    subprocess.run([sys.executable, "-c", KILLED_AT_EACH_STEP, "keep", source, tmp_path], check=True)
    monkeypatch.setattr(writer, "KEPT_S", 0)
    read = []

    def counting(item):
        read.append(item.name)
        return real(item)

    real = biotac_slide.read
    monkeypatch.setattr(biotac_slide, "read", counting)
    reads = []
    for folder in sorted(tmp_path.glob("step*"), key=lambda p: int(p.name[4:])):
        if (folder / "s").exists():
            continue
        read.clear()
        report = import_dataset("biotac_slide", source, folder / "s", workers=1)
        assert os.listdir(folder) == ["s"]
        assert problems(open_store(folder / "s")) == []
        for fact in ("sha256", "recordings", "photographs", "duplicates", "skipped"):
            assert report[fact] == expected[fact]
        reads.append(len(read))
    assert set(reads) == {0, 1, 2, 3, 4, 5}


def test_a_changed_file_makes_an_interrupted_import_begin_anew(source, tmp_path, monkeypatch):
    monkeypatch.setattr(writer, "KEPT_S", 0)

    def interrupted(done, total):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        import_dataset("biotac_slide", source, tmp_path / "s", workers=1, progress=interrupted)
    (part,) = tmp_path.glob("s.part-*")
    with pytest.raises(DataError, match="unfinished; repeat the import"):
        open_store(part)
    write_material(source, 1, recordings=2)
    assert import_dataset("biotac_slide", source, tmp_path / "s", workers=1)["recordings"] == 11
    assert left_in(tmp_path, source) == ["s"]


def test_file_names_that_are_not_utf_8_are_one_line(tmp_path, capfd):
    source = tmp_path / "takes" / "cork"
    source.mkdir(parents=True)
    (source / "good.csv").write_text("1\n2\n3\n")
    (source / os.fsdecode(b"b\xe4d.csv")).write_text("4\n5\n6\n")
    options = {"rate": 100.0}
    message = r"^cork/b\\udce4d.csv: file names must be UTF-8; rename the file or folder; leave it out by `skip_bad`$"
    with pytest.raises(DataError, match=message):
        import_dataset("folder", source.parent, tmp_path / "s", options=options)
    command = [
        "data",
        "import",
        "folder",
        str(source.parent),
        "--out",
        str(tmp_path / "s"),
        "--set",
        "rate=100",
    ]
    assert main([*command, "--skip-bad"]) == 0
    assert capfd.readouterr().out.encode()
    store = open_store(tmp_path / "s")
    assert [info.source for info in store.index] == ["cork/good.csv"]
    assert [entry["source"] for entry in store.facts.skipped] == [r"cork/b\udce4d.csv"]
    Pillow.new("RGB", (40, 40)).save(source / os.fsdecode(b"p\xe4.png"), "PNG")
    Pillow.new("RGB", (50, 40)).save(source / "q.png")
    report = import_dataset("folder", source.parent, tmp_path / "t", options=options, skip_bad=True)
    assert [entry["source"] for entry in report["skipped"]] == [r"cork/b\udce4d.csv", r"cork/p\udce4.png"]
    os.rename(source.parent, os.fsencode(tmp_path) + b"/t\xe4kes")
    folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/t\xe4kes"))
    assert import_dataset("folder", folder, tmp_path / "u", options=options, skip_bad=True)["recordings"] == 1


KILLED_AT_EACH_STEP_WITH_PHOTOGRAPHS = """
import os, sys
from pathlib import Path
import pandas  # by pyarrow on its first use: here once, not in each child
import pyarrow.parquet as pq
from tactogram.datasets.importer import importers
from tactogram.datasets.importing import import_dataset

source, folder = Path(sys.argv[1]), Path(sys.argv[2])
importers()

def work(step):
    out = folder / f"step{step}" / "s"
    out.parent.mkdir()
    left = step

    def killing(real):
        def call(*args, **options):
            nonlocal left
            left -= 1
            if left == 0:
                os.kill(os.getpid(), 9)
            return real(*args, **options)
        return call

    for name in ("replace", "unlink", "write_text", "mkdir", "rename"):
        setattr(Path, name, killing(getattr(Path, name)))
    for name in ("write_table", "close"):
        setattr(pq.ParquetWriter, name, killing(getattr(pq.ParquetWriter, name)))
    import_dataset("folder", source, out, workers=1)

for step in range(1, 200):
    child = os.fork()
    if child == 0:
        work(step)
        os._exit(0)
    if os.waitpid(child, 0)[1] == 0:
        break
"""


@pytest.mark.slow
def test_killed_at_any_step_there_is_nothing_or_all_photographs(tmp_path):
    source = tmp_path / "source"
    write_noise(source / "cork" / "a.wav", 0)
    for n in range(3):
        write_photo(source / "cork" / f"p{n}.png", n)
    subprocess.run([sys.executable, "-c", KILLED_AT_EACH_STEP_WITH_PHOTOGRAPHS, source, tmp_path], check=True)
    found = []
    for folder in sorted(tmp_path.glob("step*"), key=lambda p: int(p.name[4:])):
        if (folder / "s").exists():
            store = open_store(folder / "s")
            assert problems(store) == []
            found.append(len(store.photographs_of("cork")))
        else:
            found.append(0)
            assert all(name.startswith("s.part-") for name in os.listdir(folder))
    assert len(found) > 6
    assert set(found) == {0, 3}
    assert found == sorted(found)
