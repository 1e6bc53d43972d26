"""Cells of a table as columns."""

import numpy as np
import pytest

from tactogram.signal.io.table_columns import (
    converted,
    footer_of,
    is_empty,
    start_and_rate,
    text_columns,
    with_unit,
)


@pytest.mark.parametrize(
    ("lines", "separator", "expected"),
    [
        (["1.5,-2e3", "nan,4"], ",", [[1.5, np.nan], [-2000, 4]]),
        (["1,5;2", "0,25;4"], ";", [[1.5, 0.25], [2, 4]]),
        (['"1,234.5";1', "17.25;2"], ";", [[1234.5, 17.25], [1, 2]]),
        (["0,5;1.234", "0,6;12.345"], ";", [[0.5, 0.6], [1234, 12345]]),
    ],
    ids=["points", "decimal commas", "grouped by commas", "grouped by points"],
)
def test_numbers_are_read_as_they_are_grouped(lines, separator, expected):
    sample = [cell.strip('"') for line in lines for cell in line.split(separator)]
    columns, units = text_columns(lines, sample, 2, separator)
    np.testing.assert_array_equal(columns, expected)
    assert units == [None, None]


def test_a_unit_behind_each_number_is_of_the_column():
    column, unit = with_unit(["1.5 mV", None, "-2,5 mV"])
    np.testing.assert_array_equal(column, [1.5, np.nan, -2.5])
    assert unit == "mV"
    words, unit = with_unit(["1.5 mV", "2 V"])
    assert (words.tolist(), unit) == (["1.5 mV", "2 V"], None)


def test_digits_of_date_and_time_are_stamps():
    [column], _ = text_columns(["20260102102345000", "20260102102345010"], [], 1, ",")
    assert column.tolist() == ["2026-01-02 10:23:45.0000", "2026-01-02 10:23:45.0100"]


def test_missing_cells_are_nan_among_numbers_and_none_among_words():
    np.testing.assert_array_equal(converted(["1", "", 3]), [1, np.nan, 3])
    assert converted(["1", "", "cork"]).tolist() == ["1", None, "cork"]
    assert [is_empty(converted([1, *[""] * count])) for count in (4, 5)] == [False, True]


def test_words_below_numbers_are_the_footer():
    numbers = np.arange(40.0)
    assert footer_of([converted([*numbers, "Mean", 3]), converted([*numbers, 1, "Max"])]) == 2
    assert footer_of([converted([1, "bumped", *numbers])]) == 0
    assert footer_of([converted([*numbers[:20], "Mean"])]) == 0


def test_columns_may_begin_with_their_start_and_rate():
    columns = [np.array([1.7e9, 64.0, *range(start, start + 5)]) for start in (0, 7)]
    assert start_and_rate(columns) == 64
    assert start_and_rate([columns[0], columns[1] + 1]) is None
    assert start_and_rate([]) is None
