"""Columns of ratings, and tables of no survey tool."""

import csv
import io

import pytest

from tactogram.datasets import SEVEN_POINT
from tactogram.datasets.ratings.questions import RatingColumns
from tactogram.datasets.ratings.table import read_table
from tactogram.errors import DataError, ParameterError


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"named": {"who": "rater"}}, "a column must be one of rater, item, .*got 'who'"),
        ({"encoding": "utf-99"}, "one that Python knows, got 'utf-99'"),
        ({"item": "plate{a}"}, "a place for the cell"),
    ],
)
def test_columns_that_cannot_be_meant_are_refused(changes, says):
    with pytest.raises(ParameterError, match=says):
        RatingColumns(**changes)


ITEMS = ("tile", "carpet", "cork board", "cork")


def write(path, rows, *, divider=",", encoding="utf-8"):
    text = io.StringIO()
    csv.writer(text, delimiter=divider).writerows(rows)
    path.write_bytes(text.getvalue().encode(encoding))
    return path


def read(path, *, scale=SEVEN_POINT, **columns):
    return read_table(path, scale=scale, columns=RatingColumns(**columns), items=ITEMS)


def scores(table):
    """Return the scores by rater, item and word."""
    found = table.ratings
    keys = zip(found.rater, found.item, found.word, strict=True)
    return dict(zip(keys, found.score.tolist(), strict=True))


def test_other_tables_leave_out_unnamed_columns_and_empty_rows(tmp_path):
    rows = [
        ["", "rater", "item", "word", "score", "Age"],
        ["0", "r", "tile", "dry", "3", "9"],
        ["1", "r", "", "", "", "9"],
    ]
    path = write(tmp_path / "r.csv", rows)
    with pytest.raises(DataError, match=r"column 6 'Age' is neither.*ignore=HEADING \(or \*\)"):
        read(path)
    table = read(path, ignored=("*",))
    assert scores(table) == {("r", "tile", "dry"): 3}
    assert table.notes == (
        "columns left out, as they have no heading: 1",
        "columns left out: Age",
        "rows left out without item and score: 1, the first is row 3",
    )
