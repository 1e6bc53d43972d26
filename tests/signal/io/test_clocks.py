"""Columns of time."""

import pytest
from tests.signal.io.sample_files import written

from tactogram.signal.io import read_file, read_signal


@pytest.mark.parametrize(
    ("heading", "step", "rate"),
    [
        ("time [s]", 0.01, 100),
        ("Time (ms)", 2, 500),
        ("t_us", 250, 4000),
        ("timestamp", 0.005, 200),
        ("t", 0.001, 1000),
        ("Seconds", 0.5, 2),
    ],
)
def test_time_columns(tmp_path, heading, step, rate):
    text = f"{heading},a\n" + "\n".join(f"{i * step:.6f},{i}" for i in range(50))
    assert read_signal(written(tmp_path, text)).rate == pytest.approx(rate)


def test_a_time_column_may_stand_anywhere_and_have_any_name(tmp_path):
    text = "a,clock [ms]\n" + "\n".join(f"{i},{i * 4}" for i in range(50))
    signal = read_signal(written(tmp_path, text), time="clock")
    assert (signal.rate, signal.axes) == (250, ("a",))


def test_seconds_go_before_calendar_stamps(tmp_path):
    rows = "".join(f"2026-05-04T10:00:{k:02d},{k / 1000},{k}\n" for k in range(40))
    assert read_signal(written(tmp_path, "date,elapsed (s),x\n" + rows)).rate == pytest.approx(1000)


def test_a_metamotion_table_has_three_axes_and_three_times(tmp_path):
    heading = "epoc (ms),timestamp (+0200),elapsed (s),x-axis (g),y-axis (g),z-axis (g)"
    rows = "".join(
        f"{1777881600000 + 10 * k},2026-05-04T10.00.{k:02d}.000,{k / 100},1,2,{k}\n" for k in range(40)
    )
    file = read_file(written(tmp_path, heading + "\n" + rows))
    assert (file.signal.rate, file.signal.axes) == (pytest.approx(100), ("x", "y", "z"))
    assert [column.role for column in file.columns] == ["time", "ignored", "ignored", "x", "y", "z"]
