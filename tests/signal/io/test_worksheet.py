"""Worksheets."""

import numpy as np
import openpyxl
import pytest
from tests.signal.io.sample_files import WAVE, T, Y, Z, refusal

from tactogram.errors import DataError
from tactogram.signal import Signal
from tactogram.signal.io import read_file, read_signal, write_signal


def test_a_bad_cell_of_a_worksheet_is_refused(tmp_path):
    book = openpyxl.Workbook()
    for row in (["t [s]", "x"], [0, 1], [0.1, "one"], [0.2, None]):
        book.active.append(row)
    book.save(tmp_path / "a.xlsx")
    assert refusal(tmp_path / "a.xlsx").startswith("row 3, column 'x': expected a number, got 'one'")


def test_a_worksheet_of_others(tmp_path):
    book = openpyxl.Workbook()
    book.active.title = "first"
    sheet = book.create_sheet("second")
    sheet.append([None, None])
    sheet.append(["time [ms]", "force [mN]"])
    for i in range(20):
        sheet.append([2 * i, 1000 * i])
    book.save(tmp_path / "a.xlsx")
    signal = read_signal(tmp_path / "a.xlsx", sheet="second")
    assert (signal.rate, signal.unit, signal.axes) == (500, "N", ("force",))
    np.testing.assert_array_equal(signal.samples[0], np.arange(20))
    with pytest.raises(DataError, match="which sheet.*first, second"):
        read_signal(tmp_path / "a.xlsx")
    with pytest.raises(DataError, match="no sheet 'third'"):
        read_signal(tmp_path / "a.xlsx", sheet="third")
    with pytest.raises(DataError, match="no rows"):
        read_signal(tmp_path / "a.xlsx", sheet="first")


def test_the_workbook_of_phyphox_has_one_sheet_of_data(tmp_path):
    book = openpyxl.Workbook()
    book.active.title = "Raw Data"
    for row in (["Time (s)", "Acceleration x (m/s^2)"], *([k / 100, k] for k in range(20))):
        book.active.append(row)
    for name in ("Metadata Device", "Metadata Time"):
        book.create_sheet(name).append(["property", "value"])
    book.save(tmp_path / "a.xlsx")
    assert read_signal(tmp_path / "a.xlsx").axes == ("x",)


def test_a_worksheet_without_heading_and_one_with_remarks(tmp_path):
    book = openpyxl.Workbook()
    for row in zip(T, WAVE, Y, Z, strict=True):
        book.active.append([*map(float, row)])
    book.save(tmp_path / "a.xlsx")
    assert read_signal(tmp_path / "a.xlsx", unit="g").axes == ("x", "y", "z")
    book.active.insert_rows(1)
    for column, text in enumerate(("t [s]", "x [g]", "y [g]", "z [g]", "remark"), 1):
        book.active.cell(1, column, text)
    book.active.cell(9, 5, "touched here")
    book.save(tmp_path / "a.xlsx")
    assert any("remark" in note for note in read_file(tmp_path / "a.xlsx").notes)


def test_a_worksheet_whose_last_cell_is_filled_does_not_take_all_memory(tmp_path):
    book = openpyxl.Workbook()
    book.active.append([1, 2])
    book.active.cell(1_048_576, 16_384, 3)
    book.save(tmp_path / "a.xlsx")
    with pytest.raises(
        DataError, match="at most 33554432 cells up to its last, got 17179869184; save it as CSV"
    ):
        read_signal(tmp_path / "a.xlsx")


def test_a_worksheet_over_displacement_may_have_coarse_steps(tmp_path):
    signal = Signal(np.arange(6.0), 5.0, "1", domain="displacement")
    write_signal(tmp_path / "a.xlsx", signal)
    back = read_signal(tmp_path / "a.xlsx")
    assert (back.rate, back.domain) == (5.0, "displacement")
    np.testing.assert_array_equal(back.samples, signal.samples)
