import math

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_study.answers import COLUMNS, Answer, Answers, cells, read_answers, write_answers


def some():
    return Answers(
        (
            Answer(
                "s",
                "P1",
                design="abx",
                question="which",
                answer="A",
                correct=True,
                value=1.0,
                more={"step": "1"},
            ),
            Answer(
                "s", "P2", design="rating", question="rough", answer="3", value=3.0, scale_low=1, scale_high=7
            ),
            Answer("s", "P2", design="questions", question="comment", answer='a, "b"\nc', simulated=True),
        )
    )


@pytest.mark.parametrize("suffix", ["csv", "tsv", "parquet"])
def test_a_table_comes_back_as_it_was(tmp_path, suffix):
    path = tmp_path / f"answers.{suffix}"
    write_answers(path, some())
    back = read_answers(path)
    assert cells(back) == cells(some())
    assert back.rows[0].correct is True
    assert back.rows[1].correct is None
    assert math.isnan(back.rows[2].value)
    assert back.rows[0].more == {"step": "1"}


def test_rows_are_chosen_and_grouped_by_columns():
    answers = some()
    assert len(answers.where(participant="P2", simulated=False)) == 1
    assert len(answers.where(design=("abx", "rating"))) == 2
    assert {code: len(rows) for code, rows in answers.by("participant").items()} == {"P1": 1, "P2": 2}
    assert answers.numbers()[:2].tolist() == [1, 3]
    with pytest.raises(ParameterError, match="got 'nothing'"):
        answers.column("nothing")


@pytest.mark.parametrize(
    ("column", "cell", "message"),
    [
        ("trial", "first", "row 2: trial: must be a whole number, got 'first'"),
        ("value", "much", "row 2: value: must be a number, got 'much'"),
        ("correct", "maybe", "row 2: correct: must be true or false, got 'maybe'"),
    ],
)
def test_a_cell_that_is_none_of_its_column_is_named(tmp_path, column, cell, message):
    headings, rows = cells(some())
    rows[0][COLUMNS.index(column)] = cell
    path = tmp_path / "a.csv"
    path.write_text("\n".join(",".join(row[: len(COLUMNS)]) for row in (headings, rows[0])))
    with pytest.raises(DataError, match=message):
        read_answers(path)


def test_a_table_without_a_needed_column_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("study,participant\ns,P1\n")
    with pytest.raises(DataError, match="lacks the column design, question, answer"):
        read_answers(path)


def test_a_parquet_file_of_too_many_rows_is_refused_by_its_head(tmp_path, monkeypatch):
    path = tmp_path / "a.parquet"
    pq.write_table(pa.table({"study": pa.array(["a"] * 2_000_001)}), path)
    monkeypatch.setattr(pq, "read_table", lambda _: pytest.fail("read"))
    with pytest.raises(DataError, match="a.parquet: must have at most 2000000 rows and 256 MiB, got 2000001"):
        read_answers(path)
