from dataclasses import replace

import pytest

from tactogram.cli import main
from tactogram.errors import ParameterError
from tactogram_study.designs import find_design
from tactogram_study.power import PowerTable, power_text
from tactogram_study.study_file import Study
from tactogram_study.workflows.power import power_options, study_power


def test_a_power_table_is_printed(capsys):
    given = ["study", "power", "two_area", "--participants", "10", "--trials", "10", "--simulations", "200"]
    assert main(given) == 0
    said = capsys.readouterr().out
    assert "simulated participants" in said
    assert "GEE by participant" in said
    assert main(["study", "power", "two_area", "--participants", "ten"]) == 1
    assert "whole numbers" in capsys.readouterr().err


def test_a_size_at_which_the_test_itself_errs_is_named():
    rows = [
        {"participants": 20, "trials": trials, "type_1": wrong} for trials, wrong in ((30, 0.2), (60, 0.06))
    ]
    design = find_design("pairwise")
    table = PowerTable("pairwise", design.power["pairwise"], 2000, 0, 0.05, tuple(rows), {30: None, 60: 40})
    method = design.power_method("strengths")
    assert "With 20 x 30 (participants x trials) the test has false positives" in power_text(table, method)
    right = replace(table, rows=tuple(rows[1:]))
    assert "what is not there more often" not in power_text(right, method)


def test_a_studys_own_margin_and_trials_are_taken_for_its_power():
    found = study_power("preference", participants=[6], simulations=100)
    assert (found["design"], found["assumed"]["margin"], found["assumed"]["items"]) == ("pairwise", 0.7, 6)
    assert [row["trials"] for row in found["rows"]] == [60]
    assert "to show equivalence of a pair within ±0.7 in 80% of studies" in found["text"]
    own = study_power("abx", participants=[6], margin=0.2, person_sd=0.0, simulations=100)["assumed"]
    assert (own["margin"], own["person_sd"]) == (0.2, 0.0)


def test_the_power_of_a_study_has_its_alpha_and_a_staircases_trials_are_not_the_most():
    study = Study.load("threshold", changes={"analysis.alpha": 0.01})
    options = power_options(study)
    assert options["alpha"] == 0.01
    assert 50 <= options["trials"][0] <= 70  # 12 reversals; at most 120 trials
    few = Study.load("threshold", changes={"design.most_trials": 30})
    assert power_options(few)["trials"] == (30,)


def test_ten_votes_cannot_show_equivalence():
    assert study_power("evoked", participants=[10], simulations=100)["rows"][0]["equivalence"] == 0.0


def test_a_power_table_that_is_not_there_is_named():
    with pytest.raises(
        ParameterError, match="design must be one of abx, .*, two_area, realism, or a study, got 'abc'"
    ):
        study_power("abc")
