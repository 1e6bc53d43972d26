import stat
import threading

import pytest

from tactogram.errors import DataError
from tactogram_study.participants.tickets import load_keys, write_secret


def test_a_secret_is_its_owner_s_and_the_first_one_stays_unless_it_is_to_go(tmp_path):
    path = tmp_path / "secret"
    write_secret(path, b"first")
    write_secret(path, b"second")
    assert path.read_bytes() == b"first"
    write_secret(path, b"third", replace=True)
    assert path.read_bytes() == b"third"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert list(path.parent.iterdir()) == [path]


def test_of_many_that_write_at_once_all_have_the_same(tmp_path):
    path, found = tmp_path / "secret", []

    def begin(number):
        write_secret(path, b"%d" % number)
        found.append(path.read_bytes())

    threads = [threading.Thread(target=begin, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 8
    assert len(set(found)) == 1
    assert list(tmp_path.iterdir()) == [path]


def test_without_links_it_is_renamed_and_what_fails_leaves_nothing(tmp_path, monkeypatch):
    def refused(*args):
        raise PermissionError

    monkeypatch.setattr("os.link", refused)
    write_secret(tmp_path / "secret", b"first")
    assert (tmp_path / "secret").read_bytes() == b"first"
    monkeypatch.setattr("os.fsync", refused)
    with pytest.raises(PermissionError):
        write_secret(tmp_path / "other", b"second")
    assert [one.name for one in tmp_path.iterdir()] == ["secret"]


def test_keys_are_read_by_their_owner_only(tmp_path):
    folder = tmp_path / "session"
    folder.mkdir()
    keys = load_keys(folder)
    path = folder / "keys.json"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    path.chmod(0o644)
    assert load_keys(folder) == keys
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert [found.name for found in folder.iterdir()] == ["keys.json"]


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", '{"join": "a"}', '{"join": "short", "secret": "00"}', '{"join": 1, "secret": "x"}'],
)
def test_damaged_keys_are_said_to_be(tmp_path, text):
    (tmp_path / "keys.json").write_text(text)
    with pytest.raises(DataError, match="keys"):
        load_keys(tmp_path)
