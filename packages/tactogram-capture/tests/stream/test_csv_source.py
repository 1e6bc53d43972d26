"""Boards that print numbers: with and without heading, time, comments; damaged anywhere."""

import re

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram_capture import SourceEnded
from tactogram_capture.stream.byte_source import Replay
from tactogram_capture.stream.csv_lines import CsvFormat
from tactogram_capture.stream.csv_source import CsvSource

WAVE = np.round(200 * np.sin(np.arange(1000) / 3) ** 3).astype(int).tolist()
"""Counts of no regular step."""


def read(text, step=10**6, rate=None, every_s=1e-3, name="serial:board", **form):
    """Return samples and source of what a board printed, a few bytes at a time."""
    data = text if isinstance(text, bytes) else text.encode()
    pieces = ((data[i : i + step], i * every_s) for i in range(0, len(data), step))
    source = CsvSource(Replay("board", pieces), CsvFormat(rate=rate, **form), name=name)
    blocks = []
    with source:
        try:
            while True:
                if (block := source.read(0.0)) is not None:
                    blocks.append(block)
        except SourceEnded:
            pass
    if not blocks:
        return np.zeros((0, 0), np.float32), source
    index = 0
    for block in blocks:
        assert block.first_index == index
        index += len(block)
    return np.concatenate([b.samples for b in blocks], axis=1), source


@pytest.mark.parametrize("separator", [",", ";", "\t", " ", ", "])
@pytest.mark.parametrize("step", [1, 7, 1000])
def test_heading_time_and_units_are_read_from_the_lines(separator, step):
    rows = [separator.join(["micros", "ax[g]", "ay[g]", "az[g]"])]
    rows += [separator.join([str(1000 * n), f"{n / 100}", "0", "1"]) for n in range(100)]
    samples, source = read("\r\n".join([*rows, ""]), step)

    assert source.axes == ("x", "y", "z")
    assert source.unit == "m/s^2"
    assert source.notes == ("time from micros", "x, y, z from ax[g], ay[g], az[g], unit m/s^2")
    assert samples[0] == pytest.approx(np.arange(100) / 100 * 9.80665, rel=1e-6)
    assert source.rate == pytest.approx(1000)
    assert source.estimate().hz == pytest.approx(1000)
    assert source.facts()["losses_seen"] is True


def test_lines_without_a_heading_are_x_y_z_in_counts():
    samples, source = read("".join(f"{n},{-n},257\n" for n in WAVE[:50]))

    assert source.axes == ("x", "y", "z")
    assert source.unit == "1"
    # The first line may be the half of one, so it is counted and not used.
    assert samples[0].tolist() == WAVE[1:50]
    assert source.facts()["before"] == 1
    assert source.notes[0].startswith("no column of time")
    # The remedy is the address, ready to be typed.
    assert "read as counts" in source.notes[-1]
    assert "`'serial:board?unit=g/16384'`" in source.notes[-1]


def test_reading_that_begins_within_a_line_ignores_the_rest_of_it():
    samples, source = read("34,5\n" + "".join(f"{n},{n},{n}\n" for n in WAVE[:20]))

    assert samples[0].tolist() == WAVE[1:20]
    assert source.facts()["before"] == 2


@pytest.mark.parametrize("between", [",", " ", "\t", ", "])
def test_labels_of_a_plotter_are_names(between):
    samples, source = read("".join(f"left:{n}{between}right:1\n" for n in WAVE[:5]))

    assert source.axes == ("left", "right")
    assert samples.tolist() == [WAVE[1:5], [1] * 4]


def test_comments_greetings_and_empty_lines_are_no_samples_and_no_losses():
    text = "ADXL355 ready\n# gain 4\n\n1,2\n8,9\n// still here\n% and here\n5,6\n"
    samples, source = read(text)

    # The greeting has as many words as the rows have columns, and is no heading of theirs.
    assert source.axes == ("1", "2")
    assert samples.tolist() == [[8, 5], [9, 6]]
    assert source.facts()["comments"] == 3
    assert source.facts()["lost"] == 0


def test_rows_missing_by_the_boards_time_are_nan_in_their_place():
    text = "time_ms,z\n".replace("time_ms", "ms") + "".join(
        f"{n},{n}\n" for n in range(100) if not 40 <= n < 45
    )
    samples, source = read(text)

    assert samples.shape == (1, 100)
    assert np.isnan(samples[0, 40:45]).all()
    assert (samples[0, 45:] == np.arange(45, 100)).all()
    assert source.facts()["lost"] == 5


def test_micros_that_wrap_after_71_minutes_are_no_gap():
    text = "micros,z\n" + "".join(f"{(2**32 - 50_000 + 1000 * n) % 2**32},{n}\n" for n in range(100))
    samples, source = read(text)

    assert samples[0].tolist() == list(range(100))
    assert source.facts()["time_went_back"] == 0


@pytest.mark.parametrize("digit", ["9", "-"])
def test_one_damaged_digit_of_the_time_is_one_lost_sample(digit):
    """Such a digit once gave a gap of nine seconds and a restart."""
    rows = [f"{1000 * i},{i}" for i in range(300)]
    rows[100] = digit + rows[100]
    samples, source = read("micros,x\n" + "\n".join(rows) + "\n")
    assert samples.shape == (1, 300)
    assert np.flatnonzero(np.isnan(samples[0])).tolist() == [100]
    assert samples[0, 101:].tolist() == list(range(101, 300))
    assert source.parser.rejected["stray time"] == 1
    assert source.clock_restarts == 0


def test_a_restarted_board_leaves_a_gap():
    times = [*range(5000, 5050), *range(50)]
    samples, source = read("ms,z\n" + "".join(f"{t},{n}\n" for n, t in enumerate(times)), rate=1000)

    assert source.facts()["time_went_back"] == 1
    assert samples.shape == (1, 101)
    assert np.isnan(samples[0, 50])


@pytest.mark.parametrize("line", ["3,x,5", "3,4", "3,4,5,6", "3,,5", "3 4 5", "\xff\x00,4,5"])
def test_damaged_line_without_time_is_one_lost_sample(line):
    samples, source = read(f"x,y,z\n0,0,0\n4,1,4\n{line}\n2,0,2\n")

    assert samples[0, [0, 1, 3]].tolist() == [0, 4, 2]
    assert np.isnan(samples[:, 2]).all()
    assert sum(source.facts()["rejected"].values()) == 1


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "ovf", "1e39", "1e400"])
def test_a_value_beyond_float32_or_not_finite_is_a_lost_sample(value):
    samples, _ = read(f"x,y,z\n0,0,0\n4,{value},4\n2,2,2\n")

    assert np.isnan(samples[:, 1]).all()
    assert np.isfinite(samples[:, [0, 2]]).all()


def test_a_jump_of_the_time_does_not_fill_the_memory():
    samples, _ = read("s,z\n0,1\n0.001,2\n1e30,3\n", rate=1000)

    assert samples.shape[1] <= 2_000_003


def test_given_options_override_the_heading():
    samples, source = read(
        "a,b,c\n" + "".join(f"{n},{n},{2 * n}\n" for n in range(40)),
        time="a [ms]",
        unit="mN",
        scale=2.0,
        axes="left,right",
    )

    assert source.axes == ("left", "right")
    assert source.unit == "N"
    assert source.rate == pytest.approx(1000)
    assert samples[1] == pytest.approx(np.arange(40) * 4e-3)


@pytest.mark.parametrize(
    ("form", "told"),
    [
        ({"time": "d"}, "no column 'd', there are a, b, c"),
        ({"axes": "left,right"}, "axes must be 3 different names, got 'left,right'"),
    ],
)
def test_options_that_do_not_match_the_lines_are_refused(form, told):
    with pytest.raises((DataError, ParameterError), match=told):
        read("a,b,c\n1,2,3\n4,9,6\n2,3,3\n", **form)


def test_last_line_without_an_end_may_lack_digits_and_is_left_out():
    samples, source = read("x,y,z\n1,1,1\n5,2,2\n3,3,3")

    assert samples.shape == (3, 2)
    assert source.facts()["rejected"] == {"unfinished": 1}


LINES = (
    "t_us,x,y",
    "4000,5,9",
    "1,2",
    "8000,1,2",
    "x:1,y:2",
    "ready",
    "# on",
    "12000,9,-3",
    "16000,4,4",
    "0,7",
    "",
)


@given(st.lists(st.sampled_from(LINES), max_size=60), st.integers(1, 40))
def test_pieces_of_any_size_give_the_same_samples(lines, step):
    found = []
    for size in (10**6, step):
        try:
            samples, source = read("\n".join(lines), size, every_s=0.0)
            found.append((np.nan_to_num(samples, nan=-1e9).tolist(), source.facts()))
        except TactogramError as error:
            found.append(str(error))
    assert found[0] == found[1]


@given(st.text("0123456789,.-e \nxm#:", max_size=300))
def test_text_like_that_of_a_board_never_crashes_a_source(text):
    for form in ({}, {"time": "1", "rate": 100.0}):
        try:
            samples, source = read(text, **form)
        except TactogramError:
            continue
        assert samples.shape[1] == source.received + source.lost


@pytest.mark.parametrize("quiet", [[5] * 20 + [6] * 80, [5] * 100])
def test_a_quiet_column_is_an_axis(quiet):
    """Of few rows, one that rises once looked like a clock, and one that stands still like a constant."""
    samples, source = read("".join(f"{quiet[n]},{WAVE[n]},{-WAVE[n]}\n" for n in range(100)))

    assert samples.tolist() == [quiet[1:], WAVE[1:100], [-n for n in WAVE[1:100]]]
    assert source.facts()["losses_seen"] is False


def test_a_first_column_that_rises_is_the_time():
    rows = [f"{(2**32 - 20_000 + 1000 * n) % 2**32},{WAVE[n]},{-WAVE[n]},257" for n in range(300) if n != 200]
    samples, source = read("\n".join(rows) + "\n")

    assert source.axes == ("x", "y", "z")
    assert samples[:, 0].tolist() == [WAVE[1], -WAVE[1], 257]
    assert np.flatnonzero(np.isnan(samples[0])).tolist() == [199]
    assert source.estimate().hz == pytest.approx(1000)
    assert source.notes[0] == "column 1 rises: taken for the time, in us: 1000 Hz"
    assert "x, y, z from column 2, 3, 4, unit 1" in source.notes


def test_a_column_taken_for_the_time_that_falls_later_is_asked_about():
    rows = [f"{1000 + 700 * n if n < 40 else 500 + WAVE[n]},{WAVE[n]},7" for n in range(300)]
    with pytest.raises(DataError, match="also falls.*'serial:board\\?time=none'"):
        read("\n".join(rows) + "\n", step=500)


def test_a_counter_before_the_time_is_left_out():
    rows = [f"{n}\t{5000 + 4000 * n}\t{WAVE[n]}" for n in range(50)]
    samples, source = read("\n".join(rows) + "\n")

    assert source.axes == ("z",)
    assert samples[0].tolist() == WAVE[1:50]
    assert source.rate == pytest.approx(250)
    assert "left out: 1 (counter)" in source.notes


def test_another_quantity_is_left_out_and_its_remedy_reads_it():
    heading = "t_us,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c"
    text = heading + "\n" + "".join(f"{4000 * n},0,0.5,1,{WAVE[n]},0,1,{21 + n % 2}\n" for n in range(50))
    samples, source = read(text)
    assert samples[:, 3] == pytest.approx([0, 4.903325, 9.80665])
    assert "left out: temp_c (temperature)" in source.notes
    [remedy] = [note for note in source.notes if "angular rate" in note]
    assert "'serial:board?axes=gx_dps,gy_dps,gz_dps'" in remedy

    samples, source = read(text, axes="gx_dps,gy_dps,gz_dps")
    assert (source.unit, source.axes) == ("rad/s", ("x", "y", "z"))
    assert samples[0] == pytest.approx(np.radians(WAVE[:50]))


def test_six_columns_without_a_heading_are_asked_about_and_the_remedy_works():
    text = "".join(f"{4000 * n},{WAVE[n]},{-WAVE[n]},9,{WAVE[n + 9]},5,5\n" for n in range(50))
    with pytest.raises(
        DataError, match="which are axes of one signal\\? choose, e.g. `'?serial:board\\?axes=2,3,4'?`"
    ):
        read(text)

    samples, source = read(text, axes="2,3,4")
    assert source.axes == ("x", "y", "z")
    assert samples[:, 0].tolist() == [WAVE[1], -WAVE[1], 9]


def test_a_unit_of_counts_is_that_of_the_data_sheet():
    samples, source = read("".join(f"{1000 * n},0,0,{8192 + n % 2}\n" for n in range(50)), unit="g/16384")

    assert source.unit == "m/s^2"
    assert samples[2, 1] == pytest.approx(0.5 * 9.80665)
    assert not any("no unit" in note for note in source.notes)


@pytest.mark.parametrize("noise", [b"", b"\xf0\x00\x9d"])
@pytest.mark.parametrize("stale", ["", "9004,1\n9005000,3,3,3\n9006000,3,3,4\n"])
def test_a_board_reset_by_opening_its_port_begins_with_its_heading(stale, noise):
    rows = [f"{4000 * n},{WAVE[n]},0,981" for n in range(60)]
    text = "Starting the sensor\n", "t_us,ax_mg,ay_mg,az_mg\n" + "\n".join(rows) + "\n"
    samples, source = read(stale.encode() + text[0].encode() + noise + text[1].encode(), step=5)

    assert source.unit == "m/s^2"
    assert samples.shape == (3, 60)
    assert samples[2, 0] == pytest.approx(0.981 * 9.80665)
    assert source.facts()["lost"] == 0


@pytest.mark.parametrize("step", [7, 10**6])
def test_a_heading_repeated_by_a_reset_is_no_sample(step):
    rows = [f"{4000 * n},{WAVE[n]}" for n in range(60)]
    text = "t_us,force_mN\n" + "\n".join(rows) + "\n"
    samples, source = read(text + text, step, every_s=0.0)

    assert samples.shape == (1, 121)
    assert np.flatnonzero(np.isnan(samples[0])).tolist() == [60]
    assert source.facts()["time_went_back"] == 1
    assert source.facts()["rejected"] == {}


@pytest.mark.parametrize("prefix", ["10:23:45.123 -> ", "[10:23:45.123] ", "I (1234) imu: "])
def test_times_of_a_monitor_before_the_lines_are_no_columns(prefix):
    text = "".join(f"{prefix}{line}\n" for line in ["t_ms,ax_g", *(f"{4 * n},{WAVE[n]}" for n in range(40))])
    samples, source = read(text)

    assert source.axes == ("x",)
    assert samples.shape == (1, 40)
    assert source.rate == pytest.approx(250)


def test_a_time_in_another_unit_than_stated_is_refused_with_the_right_one():
    text = "t_ms,z\n" + "".join(f"{4000 * n},{WAVE[n]}\n" for n in range(900))  # micros()
    with pytest.raises(DataError, match="times as fast.*`'serial:board\\?time=t_ms \\[us\\]'`"):
        read(text, step=9, every_s=0.0004)

    assert read(text, step=9, every_s=0.0004, time="t_ms [us]")[1].rate == pytest.approx(250)


@pytest.mark.parametrize(
    ("step", "hz"), [(1, None), (4, 250), (100, None), (500, 2000), (4000, 250), (100_003, 10)]
)
def test_time_of_a_slow_or_quick_board_is_taken_for_ms_or_us_or_asked_about(step, hz):
    text = "".join(f"{step * n} {WAVE[n]}\n" for n in range(9, 60))
    if step == 1:  # a counter, or ms of a board at 1 kHz
        assert "left out: 1 (counter)" in read(text)[1].notes
    elif hz is None:
        with pytest.raises(DataError, match="10000 Hz in us.*`'serial:board\\?time=1"):
            read(text)
        assert read(text, time="1 [ms]")[1].rate == pytest.approx(10)
    else:
        assert read(text)[1].rate == pytest.approx(hz, rel=1e-4)


@pytest.mark.parametrize(
    "form",
    [
        "({}, {}, {})",
        "[{},{},{}]",
        '{{"x":{},"y":{},"z":{}}}',
        "X: {}  Y: {}  Z: {}",
        "AcX = {} | AcY = {} | AcZ = {}",
    ],
)
def test_lines_of_other_boards_have_three_axes(form):
    samples, source = read("".join(form.format(n, -n, 9) + " \r\n" for n in WAVE[:40]))

    assert source.axes == ("x", "y", "z")
    assert samples.tolist() == [WAVE[1:40], [-n for n in WAVE[1:40]], [9] * 39]


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"", "nothing arrives"),
        (bytes(range(128, 256)) * 50, "what arrives is not lines of numbers.*baud=9600"),
        (b"1,2\n3,4\n5,6\n", "2 lines of numbers do not suffice"),
    ],
)
def test_a_source_without_samples_says_what_to_do(data, told):
    source = CsvSource(Replay("board", iter([])), CsvFormat(), name="serial:board?unit=g")
    assert source._parse(data, 0.0) is None
    assert re.search(told, source.silence())
