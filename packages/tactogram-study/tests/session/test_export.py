import json
import shutil

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_study.answers import cells, read_answers, write_answers
from tactogram_study.session.answer_import import TableMapping, import_answers
from tactogram_study.session.export import export_bids
from tactogram_study.session.store import SessionStore
from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.simulated_participants import simulate
from tactogram_study.study_file import Study


@pytest.fixture(scope="module")
def taken(tmp_path_factory, make_study_once):
    folder = tmp_path_factory.mktemp("taken")
    with SessionStore(folder / "session", make_study_once("two_area")) as store:

        def play(participant, page):
            for presented in page.presented:
                store.log_played(
                    participant.code,
                    page.token,
                    presented.slot,
                    sha256="a" * 64,
                    level="gain=1",
                    display="audio",
                )

        simulate(store, 2, effect=SimulatedEffect(d_prime=1.0), play=play)
        yield store


@pytest.fixture(scope="module")
def bids(taken, tmp_path_factory):
    return export_bids(taken, tmp_path_factory.mktemp("bids") / "set")


def test_a_bids_folder_is_valid_and_holds_every_answer(taken, bids, bids_issues):
    assert bids_issues(bids) == []
    tables = sorted(bids.glob("sub-*/ses-1/beh/*_beh.tsv"))
    assert len(tables) == 2
    assert sum(len(path.read_text().splitlines()) - 1 for path in tables) == len(taken.answers())
    assert len(list(bids.glob("sub-*/ses-1/beh/*_events.tsv"))) == 2
    assert json.loads((bids / "dataset_description.json").read_text())["Simulated"] is True
    assert "0 participants and 2 simulated participants" in (bids / "README").read_text()


@pytest.mark.parametrize(
    ("name", "changes", "practice"),
    [
        ("threshold", {"design.most_trials": 2, "practice.trials": 1}, {}),
        ("abx", {"design.repeats": 1, "practice.trials": 1}, {"practice": "practice"}),
    ],
)
def test_names_are_levels_of_the_columns_that_hold_keys(tmp_path, bids_issues, name, changes, practice):
    study = Study.load(name, changes=changes)
    with SessionStore(tmp_path / "session", study) as store:
        simulate(store, 1)
        folder = export_bids(store, tmp_path / "bids")
    [sidecar] = folder.glob("sub-*/ses-1/beh/*_beh.json")
    facts = json.loads(sidecar.read_text(encoding="utf-8"))
    names = {key: name.texts["en"] for key, name in study.display_names.items()}
    assert facts["stimulus"]["Levels"] == names | practice
    assert "Levels" not in facts["question"]
    assert bids_issues(folder) == []


def test_what_bids_does_not_allow_is_found(bids, tmp_path, bids_issues):
    folder = tmp_path / "set"
    shutil.copytree(bids, folder)
    (folder / "dataset_description.json").write_text('{"Name": "x"}')
    [first, second] = sorted(folder.glob("sub-*/ses-1/beh/*_beh.tsv"))
    second.with_suffix(".json").write_text("{}")
    first.with_suffix(".json").unlink()
    assert {"JSON_KEY_REQUIRED BIDSVersion", "TSV_ADDITIONAL_COLUMNS_UNDEFINED answer"} <= set(
        bids_issues(folder)
    )


def test_a_folder_that_holds_something_is_left_alone(taken, tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(DataError, match="is not empty; give a new folder"):
        export_bids(taken, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_the_tidy_table_comes_back_as_the_store_holds_it(taken, tmp_path):
    write_answers(tmp_path / "a.csv", taken.answers())
    assert cells(read_answers(tmp_path / "a.csv")) == cells(taken.answers())


THEIRS = "subject,texture,kind,response,correct,rt,trial_index\ns1,cork,1,left,yes,512.5,7\ns1,tile,0,right,no,NA,8\n"


def test_anothers_table_is_read_by_a_mapping(tmp_path):
    path = tmp_path / "theirs.csv"
    path.write_text(THEIRS)
    mapped = TableMapping(
        columns={
            "participant": "subject",
            "stimulus": "texture",
            "condition": "kind",
            "answer": "response",
            "rt_ms": "rt",
        },
        constants={"design": "two_area", "question": "which"},
    )
    first, second = import_answers(path, mapped)
    assert (first.study, first.participant, first.condition, first.answer) == (
        "theirs",
        "s1",
        "1",
        "left",
    )
    assert (first.correct, first.value, first.rt_ms, first.trial) == (True, 1.0, 512.5, 1)
    assert (second.condition, second.correct, second.value, second.trial) == ("0", False, 0.0, 2)
    assert second.rt_ms != second.rt_ms
    assert first.more == {"trial_index": "7"}


def test_an_export_of_a_questionnaire_is_read_by_the_reader_of_ratings(tmp_path):
    path = tmp_path / "q.csv"
    path.write_text(
        'StartDate,EndDate,Status,ResponseId,kind,Q1_1,Q1_2\n"Start Date","End Date",Status,"Response ID",kind,'
        'How rough? - tile,How rough? - cork\n"{""ImportId"":""a""}",,,,,,\n'
        "2026-01-02,2026-01-02,Survey Preview,R_p,0,1,1\n2026-01-02,2026-01-02,IP Address,R_1,1,6,2\n"
    )
    answers = import_answers(
        path, TableMapping(columns={"condition": "kind"}, constants={"design": "rating"})
    )
    found = [(row.participant, row.stimulus, row.question, row.value, row.condition) for row in answers]
    assert found == [("R_1", "tile", "rough", 6.0, "1"), ("R_1", "cork", "rough", 2.0, "1")]
    assert "rows left out of previews: 1, the first is row 4" in answers.notes


def test_trials_of_jspsych_that_are_mapped_are_kept(tmp_path):
    path = tmp_path / "j.csv"
    path.write_text(
        "trial_type,trial_index,response,stimulus,subject\nhtml-keyboard-response,0,f,cork,s1\n"
        "html-button-response,1,0,tile,s1\npreload,2,,,s1\n"
    )
    columns = {"participant": "subject", "answer": "response", "stimulus": "stimulus"}
    answers = import_answers(
        path, TableMapping(columns, constants={"design": "two_area", "question": "which"})
    )
    assert [(row.stimulus, row.answer) for row in answers] == [("cork", "f"), ("tile", "0")]
    assert answers.notes == ("rows left out without stimulus and answer: 1, the first is row 4",)


@pytest.mark.parametrize(
    ("mapped", "message"),
    [
        ({"columns": {"participant": "who"}}, "has no column 'who' for participant, has subject"),
        ({"columns": {"stimulus": "texture"}}, "row 2: participant must not be empty"),
        (
            {"columns": {"participant": "subject", "correct": "kind", "value": "texture"}},
            "value: must be a number",
        ),
        (
            {"columns": {"participant": "subject", "correct": "texture"}},
            "correct must be true or false, got 'cork'",
        ),
    ],
)
def test_what_is_wrong_with_anothers_table_is_said(tmp_path, mapped, message):
    path = tmp_path / "theirs.csv"
    path.write_text(THEIRS)
    with pytest.raises(DataError, match=message):
        import_answers(path, TableMapping(**mapped))


def test_a_mapping_of_a_column_that_is_none_is_refused():
    with pytest.raises(ParameterError, match="got 'colour'"):
        TableMapping(columns={"colour": "x"})
    with pytest.raises(ParameterError, match="participant is given as a column and as a constant"):
        TableMapping(columns={"participant": "x"}, constants={"participant": "y"})
