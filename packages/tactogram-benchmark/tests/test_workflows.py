"""Runs, results, tables, the page, and answers from other frameworks."""

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.errors import DataError, ParameterError
from tactogram.workflows.progress import silent
from tactogram_benchmark.outside import write_questions
from tactogram_benchmark.result import BenchmarkResult, brief, check_result, committed_results
from tactogram_benchmark.task import available_tasks
from tactogram_benchmark.task_kind import kind_of
from tactogram_benchmark.workflows import rank_results, run_benchmark

EXAMPLE = Path(__file__).parents[3] / "examples" / "benchmark_numpy.py"
MODELS = ["linear_discriminant", "stroke_cnn", "replay", "ar_texture", "mean"]


@pytest.fixture(scope="module")
def results(tasks):
    """Give the folder of results of several models on three tasks."""
    options = {"folder": tasks.work, "task_folders": [tasks.folder]}
    for names, models, seeds in ((["name"], MODELS[:2], 2), (["generate", "rate"], MODELS[2:], 1)):
        report = run_benchmark([*names, *models], seeds=seeds, **options)
        assert report["failed"] == []
    return Path(report["out"])


def test_a_result_says_what_was_measured(results, tasks):
    result = BenchmarkResult.load(results / "name" / "stroke_cnn-1.json")
    task = available_tasks([tasks.folder])["name"]
    assert result.task_sha256 == task.sha256
    assert result.data.simulated
    assert result.settings["seed"] == 1
    assert result.settings["config"]["steps"] == 30
    assert result.training_s > 0
    assert result.code.startswith("0.1.0")
    assert len(result.main.by_item) == 12
    assert 0 <= result.main.low <= result.main.value <= result.main.high <= 1


def test_a_run_goes_on_and_keeps_what_is_there(results, tasks):
    before = {file: file.stat().st_mtime_ns for file in results.glob("*/*.json")}
    (results / "name" / "linear_discriminant-0.json").unlink()
    options = {"folder": tasks.work, "task_folders": [tasks.folder], "seeds": 2}
    report = run_benchmark(["name", *MODELS[:2]], **options)
    assert (report["results"], report["kept"]) == (1, 2)
    again = {file: file.stat().st_mtime_ns for file in results.glob("*/*.json")}
    changed = {file.name for file in again if before.get(file) != again[file]}
    assert changed == {"linear_discriminant-0.json"}


def test_the_same_seed_gives_the_same_figures(results, tasks, tmp_path):
    run_benchmark(
        ["generate", "ar_texture"], seeds=1, folder=tasks.work, out=tmp_path, task_folders=[tasks.folder]
    )
    one, other = (BenchmarkResult.load(f / "generate" / "ar_texture-0.json") for f in (results, tmp_path))
    assert one.figures == other.figures
    assert other.training_s == one.training_s > 0  # of the kept training


def in_folder(folder, tasks):
    """Return options of a run in a work folder of its own, of one seed."""
    stores = [tasks.work / "stores"]
    return {"folder": folder, "stores": stores, "task_folders": [tasks.folder], "seeds": 1}


def test_a_long_training_is_stopped_and_continued_the_next_time(tasks, tmp_path):
    options = in_folder(tmp_path, tasks)
    report = run_benchmark(["name", "stroke_cnn"], longest_min=1e-9, **options)
    assert len(report["failed"]) == 1
    assert "not trained within 1e-09 minutes" in report["failed"][0]
    file = tmp_path / "results" / "name" / "stroke_cnn-0.json"
    assert "not trained within" in BenchmarkResult.load(file).failed
    assert run_benchmark(["name", "stroke_cnn"], **options)["failed"] == []
    assert not BenchmarkResult.load(file).failed


def test_a_result_by_another_recipe_is_measured_again(tasks, tmp_path):
    options = in_folder(tmp_path, tasks)
    for recipe, written in (("", 1), ("tiny", 1), ("tiny", 0)):
        report = run_benchmark(["rate", "rater"], recipe=recipe, **options)
        assert (report["results"], report["failed"]) == (written, [])
        found = BenchmarkResult.load(tmp_path / "results" / "rate" / "rater-0.json")
        assert found.recipe == (recipe or "quick")


@pytest.mark.parametrize(
    ("names", "options", "message"),
    [
        (["nome"], {}, "no task or model is called 'nome': `tactogram benchmark list`"),
        (["name"], {"seeds": 4}, "seeds must be at most 3, those that the tasks state, got 4"),
    ],
)
def test_what_is_not_there_is_refused_before_anything_is_simulated(tasks, tmp_path, names, options, message):
    with pytest.raises(ParameterError, match=message):
        run_benchmark(names, folder=tmp_path, task_folders=[tasks.folder], **options)
    assert not (tmp_path / "stores").exists()


def test_a_result_of_another_version_of_the_task_is_refused(results, tasks):
    known = available_tasks([tasks.folder])
    result = BenchmarkResult.load(results / "name" / "linear_discriminant-0.json")
    with pytest.raises(
        ParameterError, match=r"task_sha256 must be .*another version of the task; run it again"
    ):
        check_result(result.model_copy(update={"task_sha256": 64 * "0"}), known, where="x.json")
    with pytest.raises(
        ParameterError, match="judge must be 1, the version of classification, got 2; run it again"
    ):
        check_result(result.model_copy(update={"judge": 2}), known, where="x.json")
    turned = dataclasses.replace(result.main, better="lower")
    with pytest.raises(
        ParameterError, match="first figure must be accuracy, higher is better, got accuracy, lower"
    ):
        check_result(result.model_copy(update={"figures": {"accuracy": turned}}), known, where="x.json")
    with pytest.raises(ParameterError, match="task must be one of"):
        check_result(result.model_copy(update={"task": "nome"}), known, where="x.json")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": "x"}, "must say format 'tactogram-benchmark-result'"),
        ({"entry": "friend"}, "entry: must be 'model', 'baseline' or 'outside', got 'friend'"),
        ({"figures": {}}, "a result has figures, or states why it failed"),
        ({"colour": "red"}, "unknown key 'colour'"),
    ],
)
def test_a_foreign_file_is_refused_with_its_fault(results, tmp_path, change, message):
    values = json.loads((results / "name" / "stroke_cnn-0.json").read_text()) | change
    (tmp_path / "x.json").write_text(json.dumps(values))
    with pytest.raises((DataError, ParameterError), match=message):
        BenchmarkResult.load(tmp_path / "x.json")


def test_a_mean_that_is_not_that_of_its_items_is_refused(results, tmp_path):
    values = json.loads((results / "name" / "stroke_cnn-0.json").read_text())
    values["figures"]["accuracy"]["value"] = 0.999
    (tmp_path / "x.json").write_text(json.dumps(values))
    with pytest.raises(ParameterError, match="value must be the mean of by_item"):
        BenchmarkResult.load(tmp_path / "x.json")


def test_the_table_ranks_every_task(results, tasks):
    ranked = rank_results([results], task_folders=[tasks.folder])
    report, text = ranked["tasks"], ranked["text"]
    assert set(report) == {"name", "generate", "rate"}
    assert {row["model"] for row in report["name"]} == {"linear_discriminant", "stroke_cnn"}
    assert "tiny (simulated)" in text
    assert "`linear_discriminant` (baseline)" in text
    assert "`mean` (ignores what is given)" in text
    informed = {row["model"]: row["informed"] for row in report["generate"]}
    assert informed == {"replay": True, "ar_texture": True, "mean": None}
    assert {row["informed"] for row in report["name"]} == {None}  # without such rows
    ranks = [row["rank"] for row in report["generate"]]
    assert all(1 <= best <= worst <= 3 for best, worst in ranks)


def test_the_command_line_checks_and_prints(results, tasks, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("TACTOGRAM_TASKS", "")  # the command adds its folders to it
    file = str(results / "rate" / "mean-0.json")
    assert main(["benchmark", "check", file, "--tasks", str(tasks.folder), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["ok"]
    renamed = tmp_path / "other-0.json"
    renamed.write_bytes(Path(file).read_bytes())
    assert main(["benchmark", "check", str(renamed), "--tasks", str(tasks.folder)]) == 1
    assert "must be called mean-0.json" in capsys.readouterr().err
    command = ["benchmark", "run", "lmt108-name", "--folder", str(tasks.work), "--tasks", str(tasks.folder)]
    assert main(command) == 1  # it was asked for, and its data is missing
    assert "skipped: " in capsys.readouterr().out
    page = tmp_path / "page.html"
    command = ["benchmark", "table", str(results), "--tasks", str(tasks.folder), "--out", str(page)]
    assert main(command) == 0
    assert "3 tasks" in capsys.readouterr().out
    text = page.read_text()
    assert text.count("<section") == 3
    assert "data-sound" in text
    assert "http" not in text.replace("http-equiv", "")  # it needs nothing from elsewhere
    assert (
        main(["benchmark", "list", "--tasks", str(tasks.folder), "--folder", str(tasks.work), "--json"]) == 0
    )
    listed = json.loads(capsys.readouterr().out)
    assert listed["name"]["state"] == "available"
    assert listed["lmt108-name"]["state"] == "missing: import lmt108"
    assert main(["benchmark", "table", str(results), "--tasks", str(tasks.folder), "--out", "x.pdf"]) == 1
    assert "out must end with .md, .html or .json" in capsys.readouterr().err.replace("--out", "out")


def test_rows_that_ignore_the_input_have_several_seeds(tasks, tmp_path):
    options = in_folder(tmp_path, tasks) | {"seeds": 2}
    assert run_benchmark(["rate", "random", "mean"], **options)["results"] == 4
    one, other = (BenchmarkResult.load(tmp_path / f"results/rate/random-{seed}.json") for seed in (0, 1))
    assert one.main.by_item != other.main.by_item


def test_results_of_data_that_may_not_be_passed_on_hold_groups_alone(tasks, tmp_path):
    free = tasks.open("generate")
    bound = dataclasses.replace(free, task=free.task.model_copy(update={"aggregate_only": True}))
    assert bound.task.sha256 == free.task.sha256
    kind = kind_of("generation")
    answers = kind.baselines["mean"](free, kind.questions(free), 0)
    whole, kept = (kind.judged(each, answers, silent) for each in (free, bound))
    assert whole.shown
    assert not kept.shown
    assert set(whole.figures["distance"].by_item) == set(free.materials)
    assert set(kept.figures["distance"].by_item) == {"group 1"}  # of six
    assert kept.figures["distance"].value == whole.figures["distance"].value
    assert not any(name in repr(kept) for name in free.materials)


def test_a_score_says_mean_and_rank_among_the_results(tasks, tmp_path, capsys, monkeypatch, results):
    monkeypatch.setenv("TACTOGRAM_TASKS", "")
    kept = tmp_path / "kept.json"
    run_benchmark(["rate", "random", "mean"], **in_folder(tmp_path, tasks))
    found = [BenchmarkResult.load(file) for file in sorted(tmp_path.glob("results/rate/*.json"))]
    kept.write_text(brief(found))
    monkeypatch.setattr("tactogram_benchmark.result.COMMITTED", kept)
    assert [each.main for each in committed_results()] == [each.main for each in found]
    opened = tasks.open("rate")
    questions = kind_of("rating").questions(opened)
    write_questions(opened, tmp_path / "questions")
    ids = [each["id"] for each in json.loads((tmp_path / "questions/task.json").read_text())["questions"]]
    assert len(ids) == len(questions)
    (tmp_path / "answers").mkdir()
    (tmp_path / "answers/about.json").write_text('{"model": "sevens", "how": "7 throughout"}')
    for seed in (0, 1):
        np.savez(tmp_path / f"answers/{seed}.npz", **{id: np.full(2, 7.0) for id in ids})
    command = ["benchmark", "score", "rate", str(tmp_path / "answers"), "--tasks", str(tasks.folder)]
    command += ["--folder", str(tasks.work), "--out", str(tmp_path / "scored")]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert re.search(r"mean \d\.\d+ ± 0\.0+ \[.*\]: rank \d(–\d)? of 3 models with results", said)
    assert "not better than random and mean, which ignore what is given: no use of its input shown" in said
    assert main([*command, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["mean"] == facts["results"][0]["figures"]["error"]["value"]
    assert (facts["models"], facts["informed"]) == (3, False)


def test_a_model_of_a_folder_takes_part(tasks, tmp_path):
    source = Path(__file__).parents[3] / "src" / "tactogram" / "models" / "replay"
    (tmp_path / "models" / "echo").mkdir(parents=True)
    for file in ("model.toml", "__init__.py", "config.py", "learner.py"):
        if (source / file).is_file():
            text = (source / file).read_text().replace("tactogram.models.replay", "echo")
            (tmp_path / "models" / "echo" / file).write_text(text)
    (tmp_path / "models" / "echo" / "recipes").mkdir()
    (tmp_path / "models" / "echo" / "recipes" / "quick.toml").write_text('model = "echo"\n')
    report = run_benchmark(
        ["generate", "echo"], seeds=1, folder=tasks.work, out=tmp_path / "results",
        task_folders=[tasks.folder], model_folders=[tmp_path / "models"],
    )  # fmt: skip
    assert report["failed"] == []
    assert BenchmarkResult.load(tmp_path / "results" / "generate" / "echo-0.json").main.value < 1
