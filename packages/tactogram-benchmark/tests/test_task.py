"""Task files: what is refused."""

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_benchmark.data import open_task
from tactogram_benchmark.task import available_tasks, find_task
from tactogram_benchmark.workflows import run_benchmark


@pytest.fixture(name="copied")
def copied_fixture(tasks, tmp_path):
    """Give a function that copies a task with one text replaced, and returns the folder."""

    def copy(old, new, name="name"):
        for suffix in (".toml", "-split.json"):
            text = (tasks.folder / f"{name}{suffix}").read_text()
            (tmp_path / f"{name}{suffix}").write_text(text.replace(old, new))
        return tmp_path

    return copy


def test_a_changed_split_is_refused(copied):
    folder = copied('"by": "order"', '"by": "recording"')
    with pytest.raises(DataError, match=r"name-split.json: SHA-256 must be .*as name.toml states"):
        find_task("name", [folder]).load_split()


def test_an_unknown_key_is_refused(copied):
    folder = copied("title =", 'titel = "x"\ntitle =')
    with pytest.raises(ParameterError, match="unknown key 'titel'; known here: .*title"):
        available_tasks([folder])


def test_two_tasks_of_one_name_are_refused(copied, tasks):
    folder = copied("tiny", "tinier")
    with pytest.raises(ParameterError, match="two tasks are called 'name'"):
        available_tasks([tasks.folder, folder])
    assert "name" in available_tasks([tasks.folder, tasks.folder])


def test_other_simulated_data_is_refused(copied, tmp_path):
    folder = copied('sha256 = "', 'sha256 = "0')  # the hash of the store loses its last digit below
    text = (folder / "name.toml").read_text()
    lines = [line[:-2] + '"' if line.startswith("sha256") else line for line in text.splitlines()]
    (folder / "name.toml").write_text("\n".join(lines).replace('split_sha256 = "0', 'split_sha256 = "'))
    task = find_task("name", [folder])
    small = task.model_copy(
        update={
            "data": task.data.model_copy(
                update={"simulate": {"set_name": "surfaces", "random": 1, "per_class": 1, "seconds": 0.5}}
            )
        }
    )
    with pytest.raises(DataError, match="simulated data must have SHA-256 0"):
        open_task(small, tmp_path / "work")


def test_recorded_data_that_is_not_at_hand_is_skipped_and_said(tmp_path):
    report = run_benchmark(["cdplab-photo-to-friction"], folder=tmp_path)
    assert report["results"] == 0
    (line,) = report["skipped"]
    assert "import it by `tactogram data import cdplab" in line


def test_unknown_names_are_refused(tasks):
    with pytest.raises(ParameterError, match="task must be one of .*got 'nome'"):
        find_task("nome")
    with pytest.raises(ParameterError, match=r"model must be one that fits .*stroke_cnn.*got 'ar_texture'"):
        run_benchmark(["name", "ar_texture"], folder=tasks.work, task_folders=[tasks.folder])
