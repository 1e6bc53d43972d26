from datetime import datetime, time

import numpy as np
import openpyxl
import pytest
import soundfile

from tactogram.errors import DataError, ParameterError, UnitError
from tactogram.signal.io import read_file, read_metadata, read_signal
from tactogram.signal.io.content import TableLayout
from tactogram.signal.units import parse_unit

X = np.sin(np.arange(40))


def written(tmp_path, text, name="a.csv"):
    path = tmp_path / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


@pytest.mark.parametrize("subtype", ["PCM_U8", "PCM_16", "PCM_24", "PCM_32", "FLOAT", "DOUBLE"])
@pytest.mark.parametrize("channels", [1, 2, 3, 7])
def test_wav_of_others(tmp_path, subtype, channels):
    x = 0.9 * np.stack([np.sin(np.arange(50) + c) for c in range(channels)])
    form = "WAVEX" if channels > 2 else "WAV"
    soundfile.write(tmp_path / "a.WAV", x.T, 22050, subtype, format=form)
    signal = read_signal(tmp_path / "a.WAV")
    bits = {"PCM_U8": 8, "PCM_16": 16}.get(subtype, 24)
    np.testing.assert_allclose(signal.samples, x, atol=1.01 / 2 ** (bits - 1))
    assert (signal.rate, signal.unit, len(signal.axes)) == (22050, "1", channels)


def test_a_wav_is_given_what_it_does_not_say(tmp_path):
    soundfile.write(tmp_path / "a.wav", np.stack([X, -X], axis=1), 333, "DOUBLE")
    signal = read_signal(tmp_path / "a.wav", unit="g", axes=("x", "z"), rate=333.3, full_scale=2)
    assert (signal.rate, signal.unit, signal.axes) == (333.3, "m/s^2", ("x", "z"))
    np.testing.assert_allclose(signal.samples[0], 2 * 9.80665 * X, rtol=1e-6)


def test_the_comment_of_others_is_metadata(tmp_path):
    for name in ("a.wav", "a.flac"):
        with soundfile.SoundFile(tmp_path / name, "w", 1000, 1, "PCM_16") as file:
            file.comment = "third take"
            file.write(X)
        assert read_metadata(tmp_path / name) == {"comment": "third take"}
        assert read_file(tmp_path / name).metadata == {"comment": "third take"}


@pytest.mark.parametrize("separator", [",", ";", "\t", " ", "  ", ", "])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_any_separator(tmp_path, separator, end):
    lines = ["time_ms" + separator + "x" + separator + "y"]
    lines += [f"{i}{separator}{v:.6f}{separator}{-v:.6e}" for i, v in enumerate(X)]
    signal = read_signal(written(tmp_path, "\ufeff" + end.join(lines)), unit="m/s^2")
    assert signal.rate == pytest.approx(1000)
    assert signal.axes == ("x", "y")
    np.testing.assert_allclose(signal.samples, [X, -X], atol=1e-6)


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


def test_jittered_stamps_are_resampled_and_reported(tmp_path):
    rng = np.random.default_rng(0)
    t = (np.arange(2000) + 0.1 * rng.normal(size=2000)) / 1000
    text = "t [s],a [mm]\n" + "\n".join(f"{v:.9f},{np.sin(2 * np.pi * 100 * v):.9f}" for v in t)
    file = read_file(written(tmp_path, text))
    expected = np.sin(2 * np.pi * 100 * (t[0] + np.arange(len(file.signal)) / file.signal.rate))
    np.testing.assert_allclose(1000 * file.signal.samples[0, 30:-30], expected[30:-30], atol=1e-3)
    assert file.signal.unit == "m"
    assert file.timing.jitter_rms == pytest.approx(1e-4, rel=0.1)
    assert read_signal(written(tmp_path, text), rate=500).rate == 500


def test_units_in_headings_are_brought_to_one(tmp_path):
    text = "t (ms);x (g);y [mg];z [m/s²]\n" + "\n".join(f"{i};1;1000;9.80665" for i in range(5))
    signal = read_signal(written(tmp_path, text))
    assert (signal.unit, signal.axes) == ("m/s^2", ("x", "y", "z"))
    np.testing.assert_allclose(signal.samples, 9.80665, rtol=1e-6)


def test_columns_are_chosen_by_name(tmp_path):
    text = "t [s],label,force [N],speed [mm/s]\n" + "\n".join(f"{i / 100},wood,{i},{2 * i}" for i in range(9))
    path = written(tmp_path, text)
    for name in ("force", "force [N]"):
        assert read_signal(path, axes=[name]).unit == "N"
    speed = read_signal(path, axes=["speed"])
    assert (speed.unit, speed.axes) == ("m/s", ("speed",))
    np.testing.assert_allclose(speed.samples[0], 2e-3 * np.arange(9))


def test_comments_blank_lines_quotes_and_last_separators(tmp_path):
    text = '# made by a logger\n% rate 100\n\n"t [s]","x, left"\n' + "\n".join(
        f'{i / 100},"{i}"' for i in range(9)
    )
    assert read_signal(written(tmp_path, text)).axes == ("x",)
    text = "t,a\n" + "".join(f"{i / 100},{i},\n" for i in range(9))
    np.testing.assert_array_equal(read_signal(written(tmp_path, text)).samples[0], np.arange(9))


LOGGERS = {
    "phyphox": (
        "Time (s),Linear Acceleration x (m/s^2),Linear Acceleration y (m/s^2),Linear Acceleration z (m/s^2),"
        "Absolute acceleration (m/s^2)"
    ),
    "phyphox in German": "Zeit (s);Beschleunigung x (m/s²);Beschleunigung y (m/s²);Beschleunigung z (m/s²)",
    "Physics Toolbox": "time,ax (m/s^2),ay (m/s^2),az (m/s^2),aT (m/s^2)",
    "Physics Toolbox, in g": "time,gFx,gFy,gFz,TgF",
    "MetaMotion": "elapsed (s),x-axis (g),y-axis (g),z-axis (g)",
    "a logger": "Elapsed Time,X-Axis (g),Y-Axis (g),Z-Axis (g)",
    "milliseconds": "timestamp_ms,acc_x,acc_y,acc_z",
    "Sensor Logger": "time,seconds_elapsed,z,y,x",
    "Arduino": "millis,ax,ay,az",
}


@pytest.mark.parametrize("logger", LOGGERS)
def test_loggers_are_understood(logger, tmp_path):
    heading = LOGGERS[logger]
    separator = ";" if ";" in heading else ","
    ms = "_ms" in heading or "millis" in heading
    rows = []
    for k, value in enumerate(X):
        sides = [value, 2 * value, 3 * value, np.sqrt(14) * abs(value)]
        time = [1.7e18 + 1e7 * k, 0.01 * k] if "seconds_elapsed" in heading else [(10 if ms else 0.01) * k]
        count = heading.count(separator) + 1 - len(time)
        row = separator.join(f"{number:.9g}" for number in [*time, *sides[:count]])
        rows.append(row.replace(".", ",") if separator == ";" else row)
    text = "Logger X200\nSerial: 1234\n\n" * (logger == "a logger") + "\n".join([heading, *rows])
    signal = read_signal(written(tmp_path, text), unit=None if "(m/s" in heading or "(g)" in heading else "g")
    assert (signal.rate, signal.unit, signal.axes) == (pytest.approx(100), "m/s^2", ("x", "y", "z"))
    gravity = 1.0 if "(m/s" in heading else 9.80665
    sides = [3, 2, 1] if logger == "Sensor Logger" else [1, 2, 3]
    np.testing.assert_allclose(signal.samples, gravity * np.outer(sides, X), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("missing", "suffix"), [("", ".csv"), ("nan", ".csv"), ("NaN", ".csv"), ("", ".xlsx")]
)
def test_short_gaps_are_interpolated_and_reported(missing, suffix, tmp_path):
    wave = np.sin(2 * np.pi * np.arange(400) / 25)
    rows = [[k / 100, value, -value] for k, value in enumerate(wave)]
    for k in (100, 200, 201, 202):
        rows[k][2 if k < 200 else 1] = missing
    if suffix == ".csv":
        path = written(tmp_path, "t [s],x [g],y [g]\n" + "\n".join(",".join(map(str, row)) for row in rows))
    else:
        path, book = tmp_path / "a.xlsx", openpyxl.Workbook()
        for row in (["t [s]", "x [g]", "y [g]"], *rows):
            book.active.append(row)
        book.save(path)
    file = read_file(path)
    assert file.timing.dropped == 4
    np.testing.assert_allclose(file.signal.samples[0], 9.80665 * wave, atol=0.05)


def test_columns_that_name_no_axis_keep_their_names(tmp_path):
    for heading in ("t [s],left,right,back", "t [s],xx,yy,zz"):
        text = "\n".join([heading, *(f"{k / 100},{k % 3},{k % 5},{k % 7}" for k in range(9))])
        assert read_signal(written(tmp_path, text), unit="1").axes == tuple(heading.split(",")[1:])


def test_chosen_columns_are_axes_by_their_names(tmp_path):
    text = "\n".join(["t [s],acc_x,acc_y", *(f"{k / 100},1,{k}" for k in range(9))])
    for choice in ({"axes": ("acc_y",)}, {"axes": ("y",)}):
        assert read_signal(written(tmp_path, text), unit="g", **choice).axes == ("y",)


def test_a_table_without_heading(tmp_path):
    text = "\n".join(f"{i % 4} {i % 5} {i % 7}" for i in range(9))
    signal = read_signal(written(tmp_path, text, "a.txt"), rate=100, unit="N")
    assert (signal.rate, signal.axes) == (100, ("x", "y", "z"))
    assert read_signal(written(tmp_path, text, "a.txt"), rate=100, axes=["2"]).samples[0, 5] == 0
    one = read_signal(written(tmp_path, "1\n2\n3\n", "b.txt"), rate=10000)
    np.testing.assert_array_equal(one.samples, [[1, 2, 3]])
    assert one.axes == ("z",)


def test_a_heading_in_a_comment_as_numpy_writes_it(tmp_path):
    np.savetxt(tmp_path / "a.txt", np.stack([np.arange(9) / 50, X[:9]], axis=1), header="t [s] force")
    signal = read_signal(tmp_path / "a.txt")
    assert (signal.axes, signal.rate) == (("force",), 50)


def test_npz_of_others(tmp_path):
    np.savez(tmp_path / "a.npz", pac=np.stack([X, X]), other=np.zeros(3), rate=2200.0)
    signal = read_signal(tmp_path / "a.npz", axes=["pac"])
    assert (signal.rate, len(signal.axes)) == (2200, 2)
    np.savez(tmp_path / "b.npz", t=np.arange(40) / 100, x=X, y=-X)
    signal = read_signal(tmp_path / "b.npz", axes=["x", "y"], unit="V")
    assert (signal.rate, signal.axes, signal.unit) == (100, ("x", "y"), "V")
    np.savez(tmp_path / "c.npz", X)
    assert len(read_signal(tmp_path / "c.npz", rate=10)) == 40


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


def test_options_that_mean_nothing_are_refused(tmp_path):
    soundfile.write(tmp_path / "a.wav", X, 1000)
    with pytest.raises(ParameterError, match="time does not apply to .wav"):
        read_signal(tmp_path / "a.wav", time="t")
    with pytest.raises(ParameterError, match="full_scale"):
        read_signal(written(tmp_path, "1\n2\n"), full_scale=2, rate=1)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("m/s²", ("m/s^2", 1)),
        ("µm", ("m", 1e-6)),
        ("mV", ("V", 1e-3)),
        ("G", ("m/s^2", 9.80665)),
        ("m/(sec^2)", ("m/s^2", 1)),
        (" N ", ("N", 1)),
        ("g/16384", ("m/s^2", 9.80665 / 16384)),
        ("g/0", None),
        ("kg", None),
    ],
)
def test_units_are_spelled_in_many_ways(text, expected):
    if expected is None:
        with pytest.raises(UnitError, match="unit must be one of"):
            parse_unit(text)
    else:
        assert parse_unit(text) == expected


def test_stamps_of_an_npz_may_be_called_time_stamp(tmp_path):
    np.savez(tmp_path / "a.npz", time_stamp=np.arange(40) / 100, x=X)
    assert read_signal(tmp_path / "a.npz", unit="g").rate == pytest.approx(100)


@pytest.mark.parametrize("cell", ["ok", ""])
def test_a_column_without_numbers_is_left_out_and_said(tmp_path, cell):
    text = "t [s],x [g],note\n" + "".join(f"{k / 100},{k},{cell}\n" for k in range(9))
    file = read_file(written(tmp_path, text))
    assert file.signal.axes == ("x",)
    assert [column.role for column in file.columns] == ["time", "x", "ignored"]


def test_columns_are_reported_as_they_were_selected_and_renamed(tmp_path):
    path = written(tmp_path, "t [s],a [g],b [g]\n" + "".join(f"{k / 100},1,{k}\n" for k in range(9)))
    assert [column.role for column in read_file(path, axes=("b",)).columns] == ["time", "ignored", "b"]
    assert [column.role for column in read_file(path, axes=("x", "y")).columns] == ["time", "x", "y"]


def test_a_layout_swaps_axes_and_sets_units(tmp_path):
    path = written(tmp_path, "clock,x,y\n" + "".join(f"{2 * k},1,{k}\n" for k in range(9)))
    values = {"columns": ("clock", "x", "y"), "time": "clock", "time_unit": "ms", "unit": "mV"}
    layout = TableLayout(**values, axes={"x": "y", "y": "x"})
    file = read_file(path, layouts=[TableLayout(columns=("other",)), layout])
    assert (file.signal.rate, file.signal.unit, file.signal.axes) == (pytest.approx(500), "V", ("x", "y"))
    np.testing.assert_allclose(file.signal.samples[0], 1e-3 * np.arange(9), rtol=1e-6)
    assert file.layout == layout


def test_arrays_are_axes_by_their_names(tmp_path):
    np.savez(tmp_path / "a.npz", time_ms=np.arange(40.0), acc_x=X, acc_y=-X)
    file = read_file(tmp_path / "a.npz", unit="g")
    assert (file.signal.rate, file.signal.axes) == (pytest.approx(1000), ("x", "y"))
    assert [column.role for column in file.columns] == ["time", "x", "y"]
    np.savez(tmp_path / "b.npz", data=np.stack([X, 2 * X, 3 * X]), Fs=np.float64(500))
    file = read_file(tmp_path / "b.npz")
    assert (file.signal.rate, [column.role for column in file.columns]) == (
        500,
        ["x", "y", "z", "rate"],
    )


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


def test_the_workbook_of_phyphox_has_one_sheet_of_data(tmp_path):
    book = openpyxl.Workbook()
    book.active.title = "Raw Data"
    for row in (["Time (s)", "Acceleration x (m/s^2)"], *([k / 100, k] for k in range(20))):
        book.active.append(row)
    for name in ("Metadata Device", "Metadata Time"):
        book.create_sheet(name).append(["property", "value"])
    book.save(tmp_path / "a.xlsx")
    assert read_signal(tmp_path / "a.xlsx").axes == ("x",)


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
