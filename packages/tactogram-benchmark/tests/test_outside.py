"""Questions and answers in files, for models in any framework."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_benchmark.outside import score_answers, write_questions
from tactogram_benchmark.result import BenchmarkResult, check_result
from tactogram_benchmark.task import available_tasks

EXAMPLE = Path(__file__).parents[3] / "examples" / "benchmark_numpy.py"


@pytest.mark.parametrize("name", ["name", "none", "retrieve", "generate"])
def test_plain_numpy_takes_part(tasks, tmp_path, name):
    opened = tasks.open(name)
    report = write_questions(opened, tmp_path / "questions")
    assert report["train"] == len(opened.examples("train"))
    command = [sys.executable, str(EXAMPLE), str(tmp_path / "questions"), str(tmp_path / "answers")]
    subprocess.run(command, check=True, cwd=tmp_path)
    results = score_answers(opened, tmp_path / "answers", tmp_path / "results")
    assert len(results) == (3 if name == "generate" else 1)
    for result in results:
        check_result(
            BenchmarkResult.load(result.file(tmp_path / "results")), available_tasks([tasks.folder]), where=""
        )
        assert (result.model, result.entry) == ("numpy_bands", "outside")
        main_figure = result.main
        better = (
            main_figure.value < 1
            if main_figure.better == "lower"
            else main_figure.value > main_figure.ceiling
        )
        assert better, main_figure.value  # than another material, or chance


def test_questions_tell_neither_materials_nor_what_the_judge_learns_from(tasks, tmp_path):
    write_questions(tasks.open("generate"), tmp_path / "generate")
    listed = json.loads((tmp_path / "generate" / "task.json").read_text())
    ids = [question["id"] for question in listed["questions"]]
    assert all(re.fullmatch("[0-9a-f]{16}", id) for id in ids)
    assert ids == sorted(ids)  # in the store's order those of one material would be neighbours
    report = write_questions(tasks.open("words"), tmp_path / "words")
    assert "validation" not in report
    assert {file.name for file in (tmp_path / "words").iterdir()} == {
        "task.json",
        "train.npz",
        "questions.npz",
    }


def test_the_numpy_example_declines_what_it_cannot(tasks, tmp_path):
    write_questions(tasks.open("rate"), tmp_path / "questions")
    command = [sys.executable, str(EXAMPLE), str(tmp_path / "questions"), str(tmp_path / "answers")]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert run.stderr.startswith("rate: asks for scores")


def test_answers_without_facts_or_files_are_refused(tasks, tmp_path):
    opened = tasks.open("name")
    with pytest.raises(DataError):
        score_answers(opened, tmp_path, tmp_path / "results")
    (tmp_path / "about.json").write_text('{"model": "m y", "how": "?"}')
    with pytest.raises(ParameterError, match=r"about.json: model: "):
        score_answers(opened, tmp_path, tmp_path / "results")
    for taken in ("stroke_cnn", "linear_discriminant"):
        (tmp_path / "about.json").write_text(json.dumps({"model": taken, "how": "by hand"}))
        with pytest.raises(
            ParameterError, match=f"model {taken} is one of this package; choose another name"
        ):
            score_answers(opened, tmp_path, tmp_path / "results")
    (tmp_path / "about.json").write_text('{"model": "mine", "how": "by hand"}')
    with pytest.raises(DataError, match=r"expected answers as 0.npz, 1.npz, … by seed, found none"):
        score_answers(opened, tmp_path, tmp_path / "results")
    np.savez(tmp_path / "0.npz", other=np.ones(6))
    with pytest.raises(ParameterError, match="expected an answer to each of 12 questions"):
        score_answers(opened, tmp_path, tmp_path / "results")
    assert not (tmp_path / "results").exists()
