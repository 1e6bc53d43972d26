import os
import re
import shutil
import stat
import subprocess
import sys
import threading
from contextvars import Context
from pathlib import Path

import pytest

from tactogram.errors import ParameterError
from tactogram.signal.io.atomic import atomic_write, check_writable, host_name, sole_writer, write_text


def test_of_two_writers_each_writes_its_own_file_and_the_last_one_stays(tmp_path):
    path = tmp_path / "new" / "a.txt"
    with atomic_write(path) as first:
        first.write_text("first")
        with atomic_write(path) as second:
            second.write_text("second")
        assert path.read_text() == "second"
    assert path.read_text() == "first"
    assert list(path.parent.iterdir()) == [path]


def test_a_reader_meets_whole_files_while_writers_race(tmp_path):
    path, texts = tmp_path / "a.txt", {str(n) * 20_000 for n in range(4)}
    write_text(path, min(texts))
    going = [threading.Thread(target=lambda t=t: [write_text(path, t) for _ in range(25)]) for t in texts]
    for writer in going:
        writer.start()
    met = {path.read_text()}
    while any(writer.is_alive() for writer in going):
        met.add(path.read_text())
    met.add(path.read_text())
    assert met <= texts
    assert list(tmp_path.iterdir()) == [path]


def test_what_fails_leaves_the_old_file_and_no_other(tmp_path):
    path = tmp_path / "a.txt"
    write_text(path, "old")
    with pytest.raises(IsADirectoryError), atomic_write(path) as part:
        part.write_text("half") and tmp_path.write_text("fails")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_durable_file_is_on_the_disk_before_it_has_its_name(tmp_path, monkeypatch):
    path, seen = tmp_path / "a.txt", []
    monkeypatch.setattr("os.fsync", lambda _: seen.append(path.exists()))
    write_text(path, "short")
    assert seen == []
    path.unlink()
    with atomic_write(path, durable=True) as part:
        part.write_text("lasting")
    assert seen == [False]
    assert path.read_text() == "lasting"


def test_the_first_file_stays_where_none_may_be_written_over(tmp_path):
    path = tmp_path / "a.txt"
    for text in ("first", "second"):
        with atomic_write(path, over=False) as part:
            part.write_text(text)
    assert path.read_text() == "first"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_has_the_suffix_and_the_rights_of_any_other(tmp_path):
    plain = tmp_path / "plain.npz"
    plain.touch()
    with atomic_write(tmp_path / "a.npz") as part:
        assert part.suffix == ".npz"
        part.touch()
    assert stat.S_IMODE((tmp_path / "a.npz").stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)


def test_no_other_code_renames_a_part_of_a_file():
    root = Path(__file__).parents[3]
    found = {
        path.name
        for folder in (root / "src", root / "packages")
        for path in folder.glob("**/src/**/*.py" if folder.name == "packages" else "**/*.py")
        if re.search(r"os\.(replace|rename)\(|\bpart\.(replace|rename)\(", path.read_text(encoding="utf-8"))
    }
    folders = {"folder.py", "pending.py"}
    assert found == {"atomic.py", *folders}


@pytest.mark.parametrize("folder", [True, False])
def test_a_place_that_can_be_written_is_left_as_it_was(folder, tmp_path):
    check_writable(tmp_path / "a" / "b", folder=folder)
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_there_may_be_replaced(tmp_path):
    (tmp_path / "made.wav").write_bytes(b"before")
    check_writable(tmp_path / "made.wav")
    assert (tmp_path / "made.wav").read_bytes() == b"before"


@pytest.mark.parametrize("folder", [True, False])
@pytest.mark.parametrize("place", [__file__, "/proc"])
def test_a_place_that_takes_no_file_is_refused_with_the_reason(place, folder):
    if not Path(place).exists():
        pytest.skip("this system has no /proc")
    with pytest.raises(ParameterError, match=r"made: cannot be written \(.+\); give another place"):
        check_writable(Path(place) / "made", folder=folder)


def test_a_file_in_a_folders_place_is_refused_and_the_other_way_round(tmp_path):
    with pytest.raises(ParameterError, match="is a file; a folder is needed"):
        check_writable(Path(__file__), folder=True)
    with pytest.raises(ParameterError, match="is a folder; a file is needed"):
        check_writable(tmp_path)


WRITER = """
import sys
from pathlib import Path
from tactogram.signal.io.atomic import sole_writer

with sole_writer(Path(sys.argv[1])):
    print("writes", flush=True)
    sys.stdin.read()
"""


def test_a_second_writer_is_refused_at_once_and_the_first_is_named(tmp_path):
    path = tmp_path / "run"
    with subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout.readline() == b"writes\n"
        with pytest.raises(ParameterError, match=f"run: process {other.pid} writes it at present"):
            sole_writer(tmp_path / "x" / ".." / "run").__enter__()
        with sole_writer(tmp_path / "another"):
            other.kill()
    with sole_writer(path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_what_a_writer_calls_may_write_there_and_another_thread_may_not(tmp_path):
    def elsewhere():
        with pytest.raises(ParameterError, match=f"process {os.getpid()} writes it at present"):
            sole_writer(tmp_path).__enter__()

    with sole_writer(tmp_path):
        with sole_writer(tmp_path / "x" / ".."):
            Context().run(elsewhere)
        Context().run(elsewhere)
    with sole_writer(tmp_path):
        pass


def test_what_a_killed_process_was_writing_goes_with_the_next_writer(tmp_path):
    folder = tmp_path / "run" / "figures"
    folder.mkdir(parents=True)
    with atomic_write(folder / "loss.png") as own:
        own.touch()
        killed = own.with_name(own.name.replace(str(os.getpid()), "99999999"))
        elsewhere = killed.with_name(killed.name.replace(host_name()[:16], "elsewhere"))
        shutil.copy(own, killed), shutil.copy(own, elsewhere)
        with sole_writer(tmp_path / "run"):
            assert {*folder.iterdir()} == {own, elsewhere}
        shutil.copy(own, killed)
        with sole_writer(folder / "loss.png"):
            assert {*folder.iterdir()} == {own, elsewhere}
