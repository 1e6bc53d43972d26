"""Hundreds of simulated studies say how often an interval covers; here a few, and how they are counted."""

import json

import pytest
from benchmarks.experiments import staircase_bias, studies_coverage
from benchmarks.experiments.studies_coverage import KINDS, _lines, _Prepared, summary_of
from benchmarks.experiments.study_cases import STUDIES

from tactogram.errors import ParameterError
from tactogram.workflows.progress import silent
from tactogram_study.session.store import SessionStore
from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.simulated_participants import simulate, simulated_answers
from tactogram_study.study_file import Study


def test_studies_are_counted_and_not_simulated_again(tmp_path):
    first = studies_coverage.run(
        tmp_path, paper=False, progress=silent, studies="magnitude", seeds=2, participants=4
    )
    written = (tmp_path / "magnitude-none.jsonl").read_bytes()
    [exponent, _] = first["studies"]["magnitude"]["effect"]["looked"]
    assert (exponent["studies"], exponent["put_in"]) == (2, pytest.approx(0.8))
    assert exponent["covered"]["n"] == 2
    assert "| magnitude | margin | all [log-log] | 1 | 0.100 exponent |" in first["text"]
    (tmp_path / "magnitude-none.jsonl").write_bytes(written + b'{"cut sh')
    again = studies_coverage.run(
        tmp_path, paper=False, progress=silent, studies="magnitude", seeds=2, participants=4
    )
    assert again == first
    assert (tmp_path / "magnitude-none.jsonl").read_bytes() == written
    assert [line["seed"] - KINDS["none"] for line in _lines(tmp_path / "magnitude-none.jsonl")] == [1, 2]
    studies_coverage.run(tmp_path, paper=False, progress=silent, studies="magnitude", seeds=3, participants=4)
    assert (tmp_path / "magnitude-none.jsonl").read_bytes().startswith(written)
    assert [line["seed"] - KINDS["none"] for line in _lines(tmp_path / "magnitude-none.jsonl")] == [1, 2, 3]
    with pytest.raises(ParameterError, match="studies must be of plate-words"):
        studies_coverage.run(tmp_path, paper=False, progress=silent, studies="else")


def test_at_the_margin_the_truth_is_the_margin():
    for name in ("plate-words", "abx", "preference", "threshold", "two-area"):
        prepared = _Prepared(name, STUDIES[name], paper=False)
        effect = SimulatedEffect(**prepared.effects["margin"])
        for place in STUDIES[name].at_margin.values():
            one = prepared.findings[place.place]
            apart = abs(one.truth(effect, prepared.study, 0) - one.nothing)
            assert apart == pytest.approx(prepared.study.planned.values[place.margin], rel=1e-6)


def test_coverage_is_a_share_with_an_interval():
    said = [
        {"put_in": 0.0, "estimate": e, "covers": abs(e) < 1, "verdict": "shown" if e > 1 else "not shown"}
        | {"others": 2, "others_covered": 2, "others_shown": int(e > 1), "others_equivalent": 0}
        for e in (-0.5, 0.0, 0.5, 2.0)
    ]
    found = summary_of(said)
    assert (found["covered"]["count"], found["covered"]["n"]) == (3, 4)
    assert found["bias"] == pytest.approx(0.5)
    assert (found["others_shown"]["count"], found["others_shown"]["n"]) == (1, 8)
    assert found["any_other_shown"]["share"] == 0.25
    assert found["covered"]["low"] < 0.75 < found["covered"]["high"]
    assert summary_of([]) == {"studies": 0}


def test_answers_without_a_session_are_those_of_one(tmp_path):
    study = Study.load("abx", changes={"design.repeats": 1, "practice.trials": 1})
    effect = SimulatedEffect(d_prime=1.0)
    with SessionStore(tmp_path / "session", study) as store:
        simulate(store, 2, effect=effect, seed=5)
        stored = store.answers()
    alone = simulated_answers(study, 2, effect=effect, seed=5)
    assert [row.answer for row in alone] == [row.answer for row in stored]
    assert [row.stimulus for row in alone] == [row.stimulus for row in stored]
    assert all(alone.column("simulated"))


def test_a_row_for_each_length_and_slope(tmp_path, monkeypatch):
    monkeypatch.setattr(staircase_bias, "SPREADS_DB", (4.0,))
    monkeypatch.setattr(staircase_bias, "LENGTHS", {8: 80})
    found = staircase_bias.run(tmp_path, paper=False, progress=silent, observers=30)
    [row] = found["rows"]
    assert abs(row["fit"]["bias"]) < 4 * row["fit"]["se"]
    assert 30 < row["trials"] < 60
    assert json.loads(json.dumps(found)) == found
    assert (tmp_path / "staircase_bias.md").read_text().startswith("| spread, dB")
