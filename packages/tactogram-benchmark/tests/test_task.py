"""Task files: what is refused, and the tasks of the package."""

import pytest
from benchmarks.make_tasks import family

from tactogram import models
from tactogram.datasets.importer import IMPORTERS
from tactogram.errors import DataError, ParameterError
from tactogram_benchmark.task import available_tasks, find_task
from tactogram_benchmark.task_kind import kind_of
from tactogram_benchmark.workflows import list_tasks, run_benchmark
from tactogram_simulate import simulate_to_store
from tactogram_simulate.sets import SETS

TASKS = available_tasks()


SIMULATED = {task.data.sha256: task.data for task in TASKS.values() if task.data.simulated}


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


@pytest.mark.parametrize("name", TASKS)
def test_a_task_is_whole(name):
    task = TASKS[name]
    split = task.load_split()  # refuses another file, and leaks
    assert split.test or split.photographs["test"]
    assert kind_of(task.kind).given
    assert bool(task.data.simulate) != bool(task.data.importer)
    assert task.data.importer in ("", *IMPORTERS.names())
    assert task.data.simulate.get("set_name", "stroking9") in SETS
    for model, chosen in task.recipes.items():
        facts = models.find(model)
        facts.recipe(chosen.recipe)


@pytest.mark.parametrize("name", TASKS)
def test_simulated_data_is_called_simulated(name):
    task = TASKS[name]
    assert not task.data.simulated or "simulated" in task.data.what + task.title


@pytest.mark.slow
@pytest.mark.parametrize("data", SIMULATED.values(), ids=lambda data: data.simulate["set_name"])
def test_the_simulator_still_makes_the_data_that_results_were_measured_on(data, tmp_path):
    assert simulate_to_store(**data.simulate, out=tmp_path / "store")["sha256"] == data.sha256


def test_the_kinds_that_a_paper_of_the_field_asks_are_there():
    kinds = {(task.kind, task.options.get("given", "")) for task in TASKS.values()}
    wanted = {"classification", "rejection", "retrieval", "mixing", "words", "rating"}
    assert wanted < {kind for kind, _ in kinds}
    assert {("generation", "image"), ("generation", "vibration")} < kinds
    assert len(TASKS) >= 20


def test_families_of_surfaces_are_in_one_part():
    """Two names for a family that the rule of `benchmarks.make_tasks` makes, and the groups of the split."""
    assert [family(name) for name in ("Canvas 2", "Styrofoam", "Sandpaper 100", "Wax Paper", "Cork")] == [
        "canvas", "foam", "sandpaper", "paper", "Cork",
    ]  # fmt: skip
    split = TASKS["hatt-name"].load_split()
    held = {
        part: {split.groups[segment.id] for segment in segments} for part, segments in split.parts.items()
    }
    assert not held["train"] & held["test"]
    assert not held["validation"] & (held["train"] | held["test"])
    assert {"foam", "carpet", "sandpaper"} < held["test"]


def test_a_task_of_ones_own_needs_no_importer(tmp_path):
    """As on docs/benchmark.md."""
    (tmp_path / "split.json").write_text("{}")
    (tmp_path / "knock-name.toml").write_text(
        'title = "Name the knocked material"\nkind = "classification"\nsplit = "split.json"\n'
        f'split_sha256 = "{"0" * 64}"\ndata = {{ name = "own", what = "knocks", sha256 = "{"0" * 64}" }}\n'
    )
    rows = list_tasks(task_folders=[tmp_path], stores=[tmp_path], folder=tmp_path)
    assert rows["knock-name"]["state"] == "missing: name its folder by --stores"
