"""Fig. 7 of Hatori & Takemura 2023: who rates, what failed, and real answers; nothing is trained here."""

import csv

import pytest
from made_up_signals import PLATES, MadeUpWorkflows, ratings_of

from tactogram.datasets.ratings.table import write_table
from tactogram.errors import ParameterError
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments import artifacts, ultrasonic_cgan_figure7


@pytest.fixture(autouse=True)
def made_up(stand_in):
    return stand_in(MadeUpWorkflows(), ultrasonic_cgan_figure7, artifacts)


def test_figure_7_is_told_by_simulated_raters_and_a_rater_model_and_says_what_failed(tmp_path, made_up):
    found = ultrasonic_cgan_figure7.run(tmp_path, paper=False, progress=silent, groups="A,B", trainings=2)
    told = found["told_by"]
    assert list(told) == ["simulated raters", "a rater model of simulated raters"]
    people = told["simulated raters"]
    assert list(people["conditions"]) == ["sensor", "nearest", "A", "B"]
    assert people["conditions"]["A"]["n"] > 0.95 * 20 * 3 * 10
    assert people["incomplete"] == ["B"]
    assert found["failed"] == {"B": {"plate02": "the training of cluster 2 failed"}}
    assert "group B, plate02: the training of cluster 2 failed" in found["text"]
    assert found["spread_over_trainings"]["A"]["sd"] is not None
    assert found["text"].count("rater model was trained on the display signals") == 1
    assert set(found["word_map"]["distance_to_target"]) >= {"sensor/plate01", "A/plate03", "B/plate01"}
    for file in (found["word_map"]["figure"], people["figure"], tmp_path / "items.csv"):
        assert (tmp_path / file).is_file()
    assert [run[1] for run in made_up.trained if run[0] == "ultrasonic_cgan"] == [1, 1, 2, 2]


def test_figure_7_of_real_answers_is_made_by_the_same_command(tmp_path, made_up):
    items = [f"{name}/{plate}" for name in ("sensor", "nearest", "A") for plate in PLATES]
    for run in ("A-0", "rater"):
        (tmp_path / "runs" / run).mkdir(parents=True)
        (tmp_path / "runs" / run / "recipe.toml").touch()
    write_table(tmp_path / "answers.csv", ratings_of(items, seed=3))
    found = ultrasonic_cgan_figure7.run(
        tmp_path, paper=False, progress=silent, groups="A", ratings=str(tmp_path / "answers.csv")
    )
    assert found["told_by"]["people"]["raters"] == 4
    assert found["told_by"]["people"]["conditions"]["A"]["n"] == 4 * 3 * 10
    assert found["word_map"]["told_by"] == "people"
    with (tmp_path / "items.csv").open(newline="") as file:
        assert [row["item"] for row in csv.DictReader(file)] == items
    assert all(run[3] for run in made_up.trained), "finished runs are continued, not made again"


@pytest.mark.parametrize("groups", ["", "A,F", "a"])
def test_groups_that_are_none_are_refused(tmp_path, groups):
    with pytest.raises(ParameterError, match="groups must be some of A, B, C, D, E"):
        ultrasonic_cgan_figure7.run(tmp_path, paper=False, progress=silent, groups=groups)
