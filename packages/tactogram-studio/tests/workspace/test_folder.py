import json
import os
from datetime import UTC, datetime

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_studio.workspace.folder import MOST_FOLDERS, DatedFolders, Workspace


@pytest.fixture
def workspace(tmp_path):
    return Workspace.at(tmp_path / "work")


def made(folder, *names):
    folder.mkdir(parents=True)
    for name in names:
        (folder / name).write_text("")
    return folder


def test_runs_stores_and_sessions_are_found_by_the_file_that_makes_them_one(workspace):
    run = made(workspace.folder / "runs" / "demo" / "voices", "recipe.toml", "model.json")
    begun = made(workspace.folder / "runs" / "begun", "recipe.toml")
    store = made(workspace.folder / "surfaces", "dataset.json")
    session = made(workspace.folder / "sessions" / "one", "answers.sqlite")

    assert set(workspace.runs()) == {run, begun}
    assert workspace.finished_runs() == [run]
    assert workspace.stores() == [store]
    assert workspace.sessions() == [session]


def test_the_strokes_of_a_clone_are_no_store_to_choose(workspace):
    made(workspace.folder / "clones" / "cork", "recipe.toml", "model.json")
    made(workspace.folder / "clones" / "cork-strokes", "dataset.json")
    own = made(workspace.folder / "data" / "back-strokes", "dataset.json")  # no clone has this name

    assert workspace.stores() == [own]


def test_files_that_the_studio_made_for_itself_are_not_offered(workspace):
    for folder in ("spectra", "made/20260101-000000-000000", "exported", "kept/20260101-000000-000001"):
        made(workspace.studio_folder / folder, "signal.npz")
    made(workspace.studio_folder / "state", "answers.csv")
    made(workspace.studio_folder / "uploads", "mine.npz")
    made(workspace.folder / "lab", "take.npz", "answers.csv")

    names = [workspace.name_of(path) for path in workspace.signal_files()]
    assert names == ["lab/answers.csv", "lab/take.npz", "studio/uploads/mine.npz"]
    assert [path.parent.name for path in workspace.user_files(".csv")] == ["lab"]


def test_hidden_and_installed_folders_are_passed_over(workspace):
    made(workspace.folder / ".venv" / "run", "recipe.toml")
    made(workspace.folder / "node_modules" / "run", "recipe.toml")
    made(workspace.folder / "a" / "b" / "c" / "d" / "too-deep", "recipe.toml")

    assert workspace.runs() == []


def test_a_home_folder_does_not_hold_the_search_up(workspace, monkeypatch):
    monkeypatch.setattr("tactogram_studio.workspace.folder.MOST_FOLDERS", 3)
    for number in range(10):
        made(workspace.folder / f"{number}", "dataset.json")

    assert len(workspace.stores()) < 10 < MOST_FOLDERS


def test_folders_of_recordings_are_found_above_their_files(workspace):
    made(workspace.folder / "lab" / "cork", "1.csv")
    made(workspace.folder / "lab" / "felt", "1.WAV", "notes.md")
    made(workspace.folder / "papers", "a.pdf")
    made(workspace.folder / "runs" / "one", "recipe.toml", "losses.csv")
    made(workspace.folder / "studio" / "dropped", "1.csv")
    made(workspace.folder / "data.part-host-1", "shard-00000.parquet")  # a store that is being written

    names = [workspace.name_of(path) for path in workspace.recording_folders()]
    assert names == ["lab", "lab/cork", "lab/felt"]
    for name in ("server.log", "a.txt", "a.txt.gz"):
        (workspace.folder / name).touch()
    files = [workspace.name_of(path) for path in workspace.signal_files() if path.parent == workspace.folder]
    assert files == ["a.txt.gz"]


def test_a_study_is_a_file_with_a_design(workspace):
    (workspace.folder / "study.toml").write_text('[design]\nkind = "abx"\n')
    (workspace.folder / "display.toml").write_text('family = "linear"\n')
    (workspace.folder / "broken.toml").write_text("[design")

    assert [path.name for path in workspace.studies()] == ["study.toml"]


def test_errors_tell_the_name_of_a_path(workspace):
    with pytest.raises(DataError) as told, workspace.readable_errors():
        raise DataError(f"{workspace.folder}/runs/a/metrics.csv: lacks the column trial")
    assert str(told.value) == "runs/a/metrics.csv: lacks the column trial"


@pytest.mark.parametrize("path", ["../secret", "/etc/passwd", "a/../../b", "runs/\0"])
def test_a_path_that_leads_out_is_refused(workspace, path):
    with pytest.raises(ParameterError, match=r"outside of the workspace|NUL"):
        workspace.inside(path)


def test_a_link_that_leads_out_is_refused(workspace, tmp_path):
    (tmp_path / "secret").write_text("s")
    (workspace.folder / "link").symlink_to(tmp_path / "secret")

    with pytest.raises(ParameterError, match="outside of the workspace"):
        workspace.inside("link")


def test_a_path_inside_is_named_relative_to_the_workspace(workspace):
    whole = workspace.inside("runs/../runs/voices")

    assert whole == workspace.folder / "runs" / "voices"
    assert workspace.name_of(whole) == "runs/voices"


def test_a_file_is_no_workspace(tmp_path):
    (tmp_path / "file").write_text("")

    with pytest.raises(DataError, match="the workspace must be a folder, got a file"):
        Workspace.at(tmp_path / "file")


def test_a_folder_at_home_is_shown_from_there(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))

    assert Workspace.at(tmp_path / "lab" / "one").display_path == "~/lab/one"
    monkeypatch.setenv("HOME", str(tmp_path / "elsewhere"))
    assert Workspace.at(tmp_path / "lab").display_path == str(tmp_path / "lab")


def test_names_that_are_not_utf_8_are_shown_with_replacement_characters_and_refused(workspace):
    folder = os.fsencode(workspace.folder)
    os.mkdir(folder + b"/st\xe4rke")
    for name in (b"/st\xe4rke/dataset.json", b"/cork\xff.wav"):
        with open(folder + name, "wb"):
            pass

    names = [workspace.name_of(path) for path in (*workspace.stores(), *workspace.files(".wav"))]
    assert names == ["st�rke", "cork�.wav"]
    json.dumps(names).encode()
    for name in names:
        with pytest.raises(ParameterError, match=f"^{name}: this name is not UTF-8 on the disk; rename"):
            workspace.inside(name)
    with pytest.raises(DataError, match=r"^st\\udce4rke/a: broken") as told, workspace.readable_errors():
        raise DataError(f"{workspace.stores()[0]}/a: broken")
    str(told.value).encode()  # escaped


def test_a_toml_file_beyond_the_limits_hides_no_other(workspace):
    (workspace.folder / "study.toml").write_text('[design]\nkind = "abx"\n')
    (workspace.folder / "latin.toml").write_bytes(b"[design]\nkind = '\xe4'\n")
    (workspace.folder / "deep.toml").write_text("[design]\na = " + "[" * 40 + "]" * 40)
    (workspace.folder / "huge.toml").write_text("[design]\n" + "#" * 2**20)

    assert [path.name for path in workspace.studies()] == ["study.toml"]


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
