"""Columns of labels, and tables cut by them."""

import numpy as np
import pytest

from tactogram.signal.io.content import RawTable
from tactogram.signal.io.files import read_contents
from tactogram.signal.io.labels import cut, label_columns, label_of_cell


def table(tmp_path, **columns):
    return RawTable(tmp_path, tuple(columns), tuple(np.asarray(column) for column in columns.values()))


def words(*cells):
    return np.array(cells, dtype=object)


def test_headings_say_which_columns_are_labels(tmp_path):
    found = table(
        tmp_path,
        t=np.arange(2.0),
        Texture=words("cork", "felt"),
        LABEL=np.array([1.0, 2.0]),
        Trial=np.array([3.0, np.nan]),
    )
    assert label_columns(found, 0) == {"material": 1, "trial": 3}
    assert label_columns(found, 1) == {"material": 2, "trial": 3}
    gestures = table(
        tmp_path, ax=np.arange(2.0), target=np.array([0.0, 1.0]), target_name=words("up", "down")
    )
    assert label_columns(gestures, None) == {"material": 2}  # as EloquentArduino writes them


def test_measurements_are_no_labels_and_without_a_material_there_are_none(tmp_path):
    assert label_columns(table(tmp_path, material=np.array([0.5, 1.0]), session=words("a", "b")), None) == {}


@pytest.mark.parametrize(
    ("cell", "label"),
    [(3.0, "3"), (" cork ", "cork"), ("2.50", "2.50"), (None, ""), (np.nan, ""), (-1, "-1")],
)
def test_codes_are_whole_numbers(cell, label):
    assert label_of_cell(cell) == label


def test_a_table_is_cut_where_a_label_changes_time_goes_back_or_is_missing(tmp_path):
    times = [0, 1, 2, 3, 4, 5, 20, 21, 0, 1]
    labels = ["cork"] * 4 + ["felt"] * 5 + [""]
    rows = "".join(
        f"{0.01 * t},{k},{label}\n" for k, (t, label) in enumerate(zip(times, labels, strict=True))
    )
    (tmp_path / "a.csv").write_text("time [s],x [g],material\n" + rows)
    found = cut(read_contents(tmp_path / "a.csv", labelled=True))
    assert [(each.labels.get("material"), each.rows) for each in found] == [
        ("cork", (2, 5)),
        ("felt", (6, 7)),
        ("felt", (8, 9)),
        ("felt", (10, 10)),
        (None, (11, 11)),
    ]
    [second] = found[1].contents
    np.testing.assert_allclose(second.samples, 9.80665 * np.array([[4, 5]]), rtol=1e-6)
    np.testing.assert_allclose(second.times, [0.04, 0.05])
    assert second.place(0, 1) == "row 7, column 'x [g]'"
