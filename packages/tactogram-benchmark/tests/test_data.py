"""Data of a task."""

import pytest

from tactogram.errors import DataError
from tactogram_benchmark.data import open_task
from tactogram_benchmark.task import find_task


@pytest.fixture(name="copied")
def copied_fixture(tasks, tmp_path):
    """Give a function that copies a task with one text replaced, and returns the folder."""

    def copy(old, new, name="name"):
        for suffix in (".toml", "-split.json"):
            text = (tasks.folder / f"{name}{suffix}").read_text()
            (tmp_path / f"{name}{suffix}").write_text(text.replace(old, new))
        return tmp_path

    return copy


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
