"""Columns read by pyarrow, and records of JSON."""

import datetime
import json

import numpy as np
import pyarrow as pa
import pyarrow.feather
import pyarrow.parquet
import pytest

from tactogram.errors import DataError
from tactogram.signal.io.records import json_tables, tables


@pytest.mark.parametrize(
    ("suffix", "write"), [(".parquet", pa.parquet.write_table), (".feather", pa.feather.write_feather)]
)
def test_fields_are_columns_with_the_units_of_their_metadata(tmp_path, suffix, write):
    fields = [
        pa.field("force", pa.int32(), metadata={"Unit": "mN"}),
        pa.field("acc", pa.struct([pa.field("x", pa.float64()), pa.field("y", pa.float64())])),
        pa.field("since", pa.duration("ms")),
        pa.field("at", pa.timestamp("ms")),
    ]
    values = [
        [1, 2],
        [{"x": 0.5, "y": -1.0}, {"x": 1.5, "y": 2.0}],
        [250, 500],
        [datetime.datetime(2026, 5, 4, 10), None],
    ]
    write(pa.table(values, schema=pa.schema(fields)), tmp_path / f"a{suffix}")
    [table] = tables(tmp_path / f"a{suffix}")
    assert table.headings == ("force", "acc.x", "acc.y", "since", "at")
    assert table.units == ("mN", None, None, None, None)
    np.testing.assert_array_equal(table.columns[:4], [[1, 2], [0.5, 1.5], [-1, 2], [0.25, 0.5]])
    assert table.columns[4].tolist() == ["2026-05-04T10:00:00.000", None]


ROWS = [{"t": 0, "acc": {"x": 1.5}, "pair": [1, 2]}, {"t": 0.1, "pair": [3, 4], "note": "end"}]


@pytest.mark.parametrize("text", [json.dumps(ROWS), "\n".join(map(json.dumps, ROWS))], ids=["list", "lines"])
def test_objects_are_rows_and_inner_ones_have_columns_of_their_own(tmp_path, text):
    (tmp_path / "a.json").write_text(text)
    [table] = json_tables(tmp_path / "a.json")
    assert table.headings == ("t", "acc.x", "pair.1", "pair.2", "note")
    np.testing.assert_array_equal(table.columns[:4], [[0, 0.1], [1.5, np.nan], [1, 3], [2, 4]])
    assert table.columns[4].tolist() == [None, "end"]


def test_lists_by_name_are_arrays(tmp_path):
    force = np.sin(np.arange(12))
    (tmp_path / "a.json").write_text(json.dumps({"force": force.tolist(), "fs": 500, "note": "cork"}))
    [table] = json_tables(tmp_path / "a.json")
    assert (table.headings, table.rate) == (("force",), 500)
    np.testing.assert_array_equal(table.columns[0], force)


@pytest.mark.parametrize(
    ("text", "says"), [("", "empty file"), ("[1, 2]", "must hold objects of names and numbers")]
)
def test_what_holds_no_records_is_refused(tmp_path, text, says):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(DataError, match=says):
        json_tables(tmp_path / "a.json")
