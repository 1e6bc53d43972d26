import os
import socket
import tempfile
import time

import pytest

from tactogram.datasets.scratch import LOCK_FILE, prefix, scratch, scratch_of
from tactogram.signal.io.atomic import lock


@pytest.fixture(autouse=True)
def temporary(tmp_path, monkeypatch):
    """Give a system's temporary folder of one's own."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def leftover(folder, name, *, hours=2.0):
    """Make what a killed process leaves: a folder that nobody holds."""
    path = folder / name
    path.mkdir()
    (path / LOCK_FILE).touch()
    (path / "a.npy").write_bytes(b"samples")
    then = time.time() - 3600 * hours
    os.utime(path, (then, then))
    return path


def test_a_folder_goes_at_the_end_of_the_with_also_after_an_error(temporary):
    def broken(path):
        (path / "a.npy").write_bytes(b"samples")
        raise OSError("no space")

    with pytest.raises(OSError, match="no space"), scratch() as path:
        broken(path)
    assert list(temporary.iterdir()) == []


def test_a_folder_goes_with_its_owner(temporary):
    class Owner:
        pass

    owner = Owner()
    path = scratch_of(owner)
    assert path.is_dir()
    del owner
    assert not path.exists()


def test_what_a_killed_process_left_goes_when_the_next_folder_is_made(temporary):
    left = leftover(temporary, f"{prefix()}left")
    with scratch() as path:
        assert not left.exists()
        assert path.is_dir()


def test_what_a_process_killed_while_it_removed_left_goes_too(temporary):
    left = leftover(temporary, f"{prefix()}left")
    (left / LOCK_FILE).unlink()
    os.utime(left, (time.time() - 7200,) * 2)
    with scratch():
        assert not left.exists()


def test_what_is_another_machine_s_stays(temporary, monkeypatch):
    other = leftover(temporary, f"{prefix()}left")
    monkeypatch.setattr(socket, "gethostname", lambda: "other.lab")
    with scratch() as path:
        assert path.name.startswith("tactogram-prepared-other_lab-")
        assert other.exists()


def test_what_is_held_or_young_or_another_s_stays(temporary):
    held, young = leftover(temporary, f"{prefix()}held"), leftover(temporary, f"{prefix()}young", hours=0.1)
    other = leftover(temporary, "tactogram-other")
    with (held / LOCK_FILE).open("rb") as file:
        assert lock(file.fileno())
        with scratch():
            pass
    assert held.exists()
    assert young.exists()
    assert other.exists()
    with scratch():  # nobody holds it any more
        assert not held.exists()


def test_a_folder_in_use_is_held(temporary):
    with scratch() as path, (path / LOCK_FILE).open("rb") as file:
        assert not lock(file.fileno())
