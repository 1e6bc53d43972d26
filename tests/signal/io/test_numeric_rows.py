"""Rows of plain numbers, read at once and in blocks."""

import numpy as np
import pytest

from tactogram.errors import DataError
from tactogram.signal.io import files, numeric_rows, read_file
from tactogram.signal.io.table import table_by_lines, text_table

HEAD = "# logger 3\ntime [s],x [m/s^2],y [m/s^2]\n"


def text(rows, *, head=HEAD, form="{:.3f},{:.4f},{:.4f}\n"):
    x = np.random.default_rng(0).standard_normal((2, rows))
    return head + "".join(form.format(i / 1000, *x[:, i]) for i in range(rows))


@pytest.fixture
def short_blocks(monkeypatch):
    monkeypatch.setattr(files, "LONG_TEXT_BYTES", 1000)
    monkeypatch.setattr(numeric_rows, "BLOCK_BYTES", 2**15)


@pytest.mark.parametrize(
    "raw",
    [
        text(900),
        text(900).replace("\n", "\r\n"),
        text(900).replace(",", ";").replace(".", ","),
        text(900).replace(",", "\t"),
        text(900, head="Sample rate: 500 Hz\na b c\n", form="{:.3f} {:.4f} {:.4f}\n"),
        text(900, head=""),
        text(900).replace("0.500,", "0.500,nan,nan\n0.501,", 1).replace("0.600,", "0.600,,1\n0.600,", 1),
    ],
    ids=["comma", "crlf", "decimal comma", "tab", "blank", "no head", "missing"],
)
def test_the_columns_are_those_line_by_line(tmp_path, raw):
    fast = numeric_rows.numeric_table(tmp_path / "a.csv", raw.encode(), table_by_lines)
    slow = table_by_lines(tmp_path / "a.csv", raw.encode())
    np.testing.assert_allclose(np.stack(fast.columns), np.stack(slow.columns), rtol=1e-14)
    assert [*fast.rows] == [*slow.rows]
    assert (fast.headings, fast.units, fast.rate, fast.notes) == (
        slow.headings,
        slow.units,
        slow.rate,
        slow.notes,
    )


@pytest.mark.parametrize(
    ("line", "instead"),
    [
        ("0.700,", "0.700,1,"),
        ("0.700,", "# again\n0.700,"),
        ("0.700,", "\n0.700,"),
        ("0.700,", "logger restarted\n0.700,"),
        ("0.700,", "10:00:00.700,"),
        ("0.700,", '"0.700",'),
    ],
    ids=["cells", "comment", "empty line", "words", "stamp", "quotes"],
)
def test_any_other_line_is_left_to_the_reader_of_lines(tmp_path, line, instead):
    numeric_rows.numeric_table(
        tmp_path / "a.csv", text(900).encode(), table_by_lines
    )  # its head is known now
    raw = text(900).replace(line, instead, 1).encode()
    assert numeric_rows.numeric_table(tmp_path / "b.csv", raw, table_by_lines) is None


def test_a_known_head_over_other_columns_is_read_anew(tmp_path):
    first = text_table(tmp_path / "a.csv", b"a,b\n" + b"0.001,0.002\n0.002,0.003\n" * 40)
    second = text_table(tmp_path / "b.csv", b"a,b\n" + b"0,001;0,002\n0,002;0,003\n" * 40)
    np.testing.assert_array_equal(np.stack(first.columns), np.stack(second.columns))


def test_a_long_table_is_that_read_at_once(tmp_path, short_blocks, monkeypatch):
    path = tmp_path / "a.csv"
    path.write_text(text(5000).replace("[m/s^2]", "[g]"))
    long = read_file(path)
    monkeypatch.setattr(files, "LONG_TEXT_BYTES", 2**26)
    whole = read_file(path)
    np.testing.assert_array_equal(long.signal.samples, whole.signal.samples)
    assert long.signal.rate == whole.signal.rate
    assert (long.timing, long.columns, long.notes) == (whole.timing, whole.columns, whole.notes)


def test_a_message_of_the_logger_far_down_is_noted(tmp_path, short_blocks):
    path = tmp_path / "a.csv"
    path.write_text(text(5000).replace("3.000,", "battery low\n3.000,", 1))
    file = read_file(path)
    assert len(file.signal) == 5000
    assert any("1 lines without numbers left out" in note for note in file.notes)


def test_a_column_that_only_begins_constant_is_not_left_out_silently(tmp_path, short_blocks):
    head = "time [s],ax [g],ay [g],spare\n"
    flat, moving = ("{:.3f},{:.4f},{:.4f},7\n", "{:.3f},{:.4f},{:.4f},8.5\n")
    rows = text(5000, head="", form=flat).splitlines(keepends=True)
    rows[4000:] = text(5000, head="", form=moving).splitlines(keepends=True)[4000:]
    rows[4500] = rows[4500].replace("8.5", "8.4")
    (tmp_path / "a.csv").write_text(head + "".join(rows))
    with pytest.raises(DataError, match=r"column 'spare': no longer constant"):
        read_file(tmp_path / "a.csv")
