"""Tables of other programs, by a mapping."""

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_study.session.answer_import import TableMapping, import_answers

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
