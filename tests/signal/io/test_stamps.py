"""Calendar stamps and times of day."""

from datetime import datetime, time

import numpy as np
import openpyxl
import pytest
from tests.signal.io.sample_files import X, written

from tactogram.errors import DataError
from tactogram.signal.io import read_file, read_signal

STAMPS = {
    "T and fraction": "2026-05-04T10:59:59.{:06d}",
    "blank": "2026-05-04 10:59:59.{:06d}",
    "UTC": "2026-05-04T10:59:59.{:06d}Z",
    "time zone": "2026-05-04T10:59:59.{:06d}+09:00",
    "slashes": "2026/05/04 10:59:59.{:06d}",
    "nanoseconds": "2026-05-04T10:59:59.{:06d}000",
}


@pytest.mark.parametrize("name", STAMPS)
@pytest.mark.parametrize("heading", ["timestamp,x", "when it was,x", None])
def test_calendar_stamps_are_times(tmp_path, name, heading):
    rows = [f"{STAMPS[name].format(2000 * k)},{value:.6f}" for k, value in enumerate(X)]
    file = read_file(written(tmp_path, "\n".join([heading, *rows] if heading else rows)), unit="g")
    assert (file.signal.rate, file.times[0]) == (pytest.approx(500), 0)
    assert file.columns[0].role == "time"
    np.testing.assert_allclose(file.signal.samples[0], 9.80665 * X, atol=1e-4)


def test_calendar_stamps_go_on_after_midnight_and_through_a_gap(tmp_path):
    first = np.datetime64("2026-12-31T23:59:59.900", "us")
    rows = [f"{first + np.timedelta64(10000 * k, 'us')};{'' if k == 20 else k / 10}" for k in range(40)]
    text = "time;x [g]\n" + "\n".join(rows).replace(".", ",")
    file = read_file(written(tmp_path, text))
    assert (file.signal.rate, file.timing.dropped) == (pytest.approx(100), 1)
    np.testing.assert_allclose(file.times[-1], 0.39, atol=1e-9)


@pytest.mark.parametrize("value", [str, lambda stamp: stamp])
def test_calendar_stamps_of_a_worksheet(tmp_path, value):
    book = openpyxl.Workbook()
    book.active.append(["date", "x"])
    for k, sample in enumerate(X):
        book.active.append([value(datetime(2026, 5, 4, 10, 0, 0, 20000 * k)), sample])
    book.save(tmp_path / "a.xlsx")
    assert read_signal(tmp_path / "a.xlsx", unit="g").rate == pytest.approx(50, rel=1e-3)


CLOCKS = {
    "milliseconds": lambda s: f"{s // 3600:02.0f}:{s // 60 % 60:02.0f}:{s % 60:06.3f}",
    "one digit of the hour": lambda s: f"{s // 3600:.0f}:{s // 60 % 60:02.0f}:{s % 60:06.3f}",
    "decimal comma": lambda s: f"{s // 3600:02.0f}:{s // 60 % 60:02.0f}:{s % 60:06.3f}".replace(".", ","),
}


@pytest.mark.parametrize("name", CLOCKS)
@pytest.mark.parametrize("heading", ["Time;x [g]", "clock;x [g]", None])
def test_times_of_day_are_times_also_past_midnight(tmp_path, name, heading):
    stamps = [CLOCKS[name]((86_399.9 + 0.01 * k) % 86_400) for k in range(40)]
    rows = [f"{stamp};{k % 7}" for k, stamp in enumerate(stamps)]
    file = read_file(written(tmp_path, "\n".join([heading, *rows] if heading else rows)), unit=None)
    assert (file.signal.rate, file.columns[0].role) == (pytest.approx(100), "time")
    assert file.columns[0].unit == "time of day"
    np.testing.assert_allclose(file.times, 0.01 * np.arange(40), atol=1e-9)


def test_a_worksheet_may_have_times_of_day(tmp_path):
    book = openpyxl.Workbook()
    book.active.append(["when", "x [g]"])
    for k in range(40):
        book.active.append([time(12, 3, 4 + k // 20, 50_000 * (k % 20)), k])
    book.save(tmp_path / "a.xlsx")
    assert read_signal(tmp_path / "a.xlsx").rate == pytest.approx(20)


@pytest.mark.parametrize(
    ("stamps", "says"),
    [
        (["12:00:00.0", "12:00:00.1", "12:00:00.05"], "time goes back by 0.05 s"),
        (["12:00:00.0", "12:00:00.1", "noon"], "row 64, column 't': expected a time stamp, got 'noon'"),
        (["12:00:00.0", "12:00:00.1", "2026-05-04 12:00"], "expected a time stamp like the first"),
    ],
)
def test_a_wrong_time_of_day_is_refused(tmp_path, stamps, says):
    first = [f"11:59:{k:02},{k}" for k in range(60)]
    rows = [*first, *(f"{stamp},1" for stamp in stamps)]
    with pytest.raises(DataError, match=says):
        read_signal(written(tmp_path, "t,x\n" + "\n".join(rows)), unit="g")
