from datetime import UTC, datetime

import pytest

from tactogram_studio.workspace.folder import DatedFolders


def written(text):
    return lambda part: (part / "x").write_text(text)


def test_folders_are_named_in_order_and_found_by_name(tmp_path):
    folders = DatedFolders(tmp_path / "new")
    assert folders.names() == []
    first, second = (folders.add(written(text)) for text in "ab")

    assert folders.names() == [second, first]
    assert (folders.find(first) / "x").read_text() == "a"
    folders.remove(first)
    assert folders.names() == [second]
    assert folders.find(first) is folders.find("..") is folders.find("") is None


def test_two_of_the_same_instant_get_names_of_their_own(tmp_path, monkeypatch):
    class Stopped(datetime):
        @classmethod
        def now(cls, tz=None):
            return datetime(2026, 1, 2, 3, 4, 5, 6, tzinfo=tz)

    monkeypatch.setattr("tactogram_studio.workspace.folder.datetime", Stopped)
    folders = DatedFolders(tmp_path)
    inner = []
    outer = folders.add(lambda part: inner.append(folders.add(written("b"))))
    assert [outer, *inner] == ["20260102-030405-000006", "20260102-030405-000007"]
    assert folders.names() == [*inner, outer]


def test_what_fails_leaves_nothing(tmp_path):
    def broken(part):
        (part / "x").write_text("half")
        raise OSError("no space")

    with pytest.raises(OSError, match="no space"):
        DatedFolders(tmp_path).add(broken)

    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_server_left_goes_when_the_next_is_added(tmp_path):
    old, new = "20200101-000000-000000", f"{datetime.now(UTC):%Y%m%d-%H%M%S-%f}"
    for name in (f".{old}.part", f".{old}.gone", f".{new}.gone", f".{new}.part", ".mine.part", old):
        (tmp_path / name).mkdir()
        (tmp_path / name / "x").write_text("half")
    added = DatedFolders(tmp_path).add(written("a"))
    assert {path.name for path in tmp_path.iterdir()} == {f".{new}.part", ".mine.part", old, added}
