"""Tables in long form."""

import numpy as np

from tactogram.signal.io.content import RawTable
from tactogram.signal.io.long_tables import split_by_sensor


def table(tmp_path, **columns):
    """Return a table; words are columns of objects."""
    made = [
        np.array(cells, dtype=object if isinstance(cells[0], str) else float) for cells in columns.values()
    ]
    return RawTable(tmp_path, tuple(columns), tuple(made))


def test_rows_of_sensors_by_turns_are_a_table_of_each(tmp_path):
    found = split_by_sensor(
        table(tmp_path, hand=["L", "R"] * 3, t_ms=[0, 1, 10, 11, 20, 21], ax_g=[1, 2, 3, 4, 5, 6])
    )
    assert [part.headings for part in found] == [("t_ms", "L ax_g"), ("t_ms", "R ax_g")]
    np.testing.assert_array_equal(found[0].columns, [[0, 10, 20], [1, 3, 5]])
    np.testing.assert_array_equal(found[1].columns, [[1, 11, 21], [2, 4, 6]])
    assert [list(part.rows) for part in found] == [[0, 2, 4], [1, 3, 5]]
    assert found[0].notes == ("rows apart by 'hand'",)


def test_axes_by_turns_on_one_clock_are_columns(tmp_path):
    found = split_by_sensor(
        table(tmp_path, t_ms=[0, 0, 10, 10, 20, 20], axis=["x", "y"] * 3, value=[1, 2, 3, 4, 5, 6])
    )
    assert [part.headings for part in found] == [("t_ms", "x value", "y value")]
    np.testing.assert_array_equal(found[0].columns, [[0, 10, 20], [1, 3, 5], [2, 4, 6]])


def test_labels_switches_and_blocks_of_other_columns_are_no_sensors(tmp_path):
    for other in (
        {"material": ["cork", "felt"] * 3},  # a label, for the cut of the table
        {"pressed": ["on", "off"] * 3},
        {"sensor": ["L"] * 6},
        {"sensor 1": [1, 2] * 3},  # a measurement of sensor 1
    ):
        whole = table(tmp_path, t_ms=[0, 1, 10, 11, 20, 21], ax_g=[1, 2, 3, 4, 5, 6], **other)
        assert split_by_sensor(whole) == [whole]
