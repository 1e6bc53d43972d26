"""Programs: spreadsheets, Python, R, MATLAB, Octave, ROS, Unity, and JSON lines."""

import gzip
import io
import json
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import openpyxl

# fmt: off
# isort: off
from tests.signal.io.foreign.case import (
    EPOCH, PEAKS, SLOW, Ask, Case, G, K, Refused, T, X, Y, Z, acceleration, case, fixed, measured, one, plain,
    rows, stamps, table,
)
# isort: on

PANDAS = "pandas.pydata.org, DataFrame.to_csv"
EXCEL = "support.microsoft.com, save a workbook as text or CSV"
NS = [EPOCH * 10**9 + int(k) * 10**7 for k in K]
VECTORS = [np.column_stack(c) for c in ((X, Y, Z), (T, X, Y, Z))]


def workbook(path: Path) -> None:
    """Write two worksheets: the measured data with a title above, and settings."""
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "Raw Data"
    sheet.append(["Time (s)", "Acceleration x (m/s^2)", "Acceleration y (m/s^2)", "Acceleration z (m/s^2)"])
    for row in VECTORS[1]:
        sheet.append([float(v) for v in row])
    settings = book.create_sheet("Metadata Device")
    settings.append(["property", "value"])
    settings.append(["deviceModel", "phone"])
    book.save(path)


def dated_workbook(path: Path) -> None:
    """Write a worksheet with dates as Excel has them, a title and an empty row above, an index before."""
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["Slide over cork, take 3"])
    sheet.append([])
    sheet.append([None, "Datum/Uhrzeit", "ax [g]", "ay [g]", "az [g]", "Bemerkung"])
    for k, (x, y, z) in enumerate(VECTORS[0]):
        time = datetime(2026, 1, 2, 10, 23, 45) + timedelta(milliseconds=10 * k)
        sheet.append([k, time, float(x), float(y), float(z), "Kontakt" if k == 7 else None])
    book.save(path)


def savetxt(values: np.ndarray, **options: str) -> bytes:
    text = io.BytesIO()
    np.savetxt(text, values, **options)
    return text.getvalue()


def lines(**columns: object) -> str:
    """Return JSON lines, an object for each row."""
    return "".join(json.dumps({name: values[k] for name, values in columns.items()}) + "\n" for k in K)


def ros2(k: int) -> str:
    return (
        f"header:\n  stamp:\n    sec: {EPOCH + k // 100}\n    nanosec: {k % 100 * 10**7}\n  frame_id: imu\n"
        f"linear_acceleration:\n  x: {X[k]:.6f}\n  y: {Y[k]:.6f}\n  z: {Z[k]:.6f}\n---\n"
    )


PROGRAMS: tuple[Case, ...] = (
    case("pandas_datetime_index", PANDAS + ", index of dates without a name",
        table(",ax,ay,az", stamps("%Y-%m-%d %H:%M:%S.%f"), X, Y, Z), plain("acceleration")),
    case("pandas_dates_whole_seconds_without_fraction",
        PANDAS + ": stamps of whole seconds are written without the fraction", table(
        ",ax,ay,az", [text.removesuffix(".000000") for text in stamps("%Y-%m-%d %H:%M:%S.%f")], X, Y, Z),
        plain("acceleration")),
    case("pandas_index_twice", PANDAS + ", written, read and written again: Unnamed: 0 and another counter",
        table(",Unnamed: 0,time [s],x [g],y [g],z [g]", K, K, T, X, Y, Z), acceleration(G)),
    case("pandas_two_heading_rows", PANDAS + ", columns of two levels, the name of the index in a row of its own",
        "sensor,acc,acc,acc,gyro,gyro,gyro\naxis,x,y,z,x,y,z\ntime,,,,,,\n"
        + rows(fixed(T, 2), X, Y, Z, SLOW, SLOW, SLOW), plain("acceleration", left_out=["gyro"])),
    case("group_row_above_names", "spreadsheets: sensor written once above its three axes, units below",
        "Time,Accelerometer,,,Gyroscope,,\n,X,Y,Z,X,Y,Z\ns,g,g,g,deg/s,deg/s,deg/s\n"
        + rows(T, X, Y, Z, SLOW, SLOW, SLOW), acceleration(G, others={"angular_rate": "rad/s"})),
    case("numpy_savetxt_header", "numpy.org, savetxt: heading behind #, %.18e, blanks",
        savetxt(VECTORS[1], header="t [s] ax [m/s^2] ay [m/s^2] az [m/s^2]"), acceleration(), file="take.txt"),
    case("numpy_savetxt_bare", "numpy.org, savetxt with delimiter and no header: first column is the time",
        savetxt(VECTORS[1], delimiter=","), plain()),
    case("r_write_csv", "r-project.org, write.csv: quoted headings and row names from 1",
        table('"","time_s","ax","ay","az"', [f'"{k + 1}"' for k in K], T, X, Y, Z), plain("acceleration")),
    case("r_write_table", "r-project.org, write.table: one heading less than columns, row names, NA", table(
        '"time_s" "ax" "ay" "az"', [f'"{k + 1}"' for k in K], T, ["NA" if k == 50 else X[k] for k in K], Y, Z,
        sep=" "), plain("acceleration"), file="take.txt"),
    case("matlab_writetable", "mathworks.com, writetable: names made valid, units lost",
        table("Time_s_,Acc_X_g_,Acc_Y_g_,Acc_Z_g_", T, X, Y, Z), acceleration(G), plain("acceleration")),
    case("matlab_timetable_sec", "mathworks.com, writetimetable: durations with the unit in the cell",
        table("Time,X,Y,Z", [f"{v:g} sec" for v in T], X, Y, Z), plain()),
    case("matlab_dlmwrite", "mathworks.com, dlmwrite with tab: five significant digits",
        rows(*([f"{v:.5g}" for v in c] for c in (T, X, Y, Z)), sep="\t"), plain(), file="take.dat"),
    case("matlab_ascii", "mathworks.com, save -ascii: columns aligned with blanks, 1.0000000e-01",
        rows(*([f"  {v: .7e}" for v in c] for c in (T, X, Y, Z)), sep=" "), plain(), file="take.asc"),
    case("octave_text", "docs.octave.org, save -text: comments with name, type, rows and columns of one matrix",
        "# Created by Octave 8.4.0, Fri Jan 02 10:23:45 2026 CET <lab@pc>\n# name: data\n# type: matrix\n# rows: "
        "100\n" "# columns: 4\n" + rows(*([f" {v:.10g}" for v in c] for c in (T, X, Y, Z)), sep="") + "\n\n", plain(),
        file="data.txt"),
    case("excel_french", EXCEL + ": semicolon, decimal comma, cp1252, no-break blank as thousands separator", table(
        "Temps (ms);Force x (mN);Force y (mN);Force z (mN)", 10 * K,
        *([f"{v:,.1f}".replace(",", "\xa0").replace(".", ",") for v in 10_000 * c] for c in (X, Y, Z)), sep=";",
        end="\r\n"), measured("force", "N", 10 * X, 10 * Y, 10 * Z), encoding="cp1252"),
    case("excel_english_thousands", EXCEL + ": numbers of a thousand and more in quotes with a comma", table(
        "Time (s),Load X (mN),Load Y (mN),Load Z (mN)", T, *([f'"{v:,.2f}"' for v in 10_000 * c] for c in (X, Y, Z)),
        end="\r\n"), measured("force", "N", 10 * X, 10 * Y, 10 * Z)),
    case("excel_japanese_headings", EXCEL + ": Japanese headings in cp932, full-width brackets",
        table("時間（ｓ）,加速度Ｘ（m/s2）,加速度Ｙ（m/s2）,加速度Ｚ（m/s2）", T, X, Y, Z, end="\r\n"), acceleration(),
        encoding="cp932"),
    case("excel_unicode_text", EXCEL + ": Unicode text, that is UTF-16 with tabs, decimal comma of a German system",
        "\ufeff" + table("Zeit [s]\tKraft [N]", T, X, sep="\t", decimal=",", end="\r\n"), one("force", "N"),
        encoding="utf-16-le", file="Messung.txt"),
    case("excel_two_sheets", "phyphox.org: Excel export, a sheet of data and sheets of settings", workbook,
        acceleration(), Ask("sheet", {"sheet": "Raw Data"}, acceleration()), file="Acceleration.xlsx"),
    case("excel_dates_and_remarks",
        "support.microsoft.com: dates as cells, title and empty row above, counter before, remarks behind",
        dated_workbook, acceleration(G, left_out=["Bemerkung"]), file="take3.xlsx"),
    case("google_sheets",
        "support.google.com, download as CSV: formatted cells, empty columns at the end, minus sign of typography",
        table("Time (s),X (g),Y (g),Z (g),,", fixed(T, 2),
        *([f"{v:.4f}".replace("-", "−") for v in c] for c in (X, Y, Z)), "", ""), acceleration(G)),
    case("libreoffice_quoted", "help.libreoffice.org, text export: all cells in quotes, Russian headings and units",
        table('"Время, с";"Ускорение X, м/с²";"Ускорение Y, м/с²";"Ускорение Z, м/с²"',
        *([f'"{v:.4f}"'.replace(".", ",") for v in c] for c in (T, X, Y, Z)), sep=";"), acceleration(),
        plain("acceleration")),
    case("ros_bag_to_csv",
        "github.com/AtsushiSakai/rosbag_to_csv and MATLAB readers: rosbagTimestamp, secs, nsecs, covariances as "
        "lists", table("rosbagTimestamp,header,seq,stamp,secs,nsecs,frame_id,linear_acceleration,x,y,z,"
        "linear_acceleration_covariance",
        *(NS, "", K, "", EPOCH, 10**7 * K, "'imu'", "", X, Y, Z, '"[0.0, 0.0, 0.0]"')),
        plain("acceleration|vibration", left_out=["seq", "frame_id"])),
    case("ros2_topic_csv",
        "docs.ros.org, ros2 topic echo --csv: no headings; sec, nanosec, frame, quaternion, covariances, rates, "
        "accelerations", rows(EPOCH, 10**7 * K, "imu", 0.0, 0.0, 0.0, 1.0, *[0.0] * 9, *[SLOW] * 3, *[0.0] * 9, X, Y,
        Z, *[0.0] * 9), Ask("columns|which|axes|rate", {"axes": ("29", "30", "31"), "rate": 100}, plain(note=""))),
    case("ros2_topic_echo", "docs.ros.org, ros2 topic echo: YAML documents", "".join(ros2(int(k)) for k in K),
        Refused("csv|column|table|number"), file="imu.txt"),
    case("plotjuggler",
        "github.com/facontidavide/PlotJuggler, CSV export: topic paths as headings, rows of each topic's own times",
        table("__time,/imu/linear_acceleration/x,/imu/linear_acceleration/y,/imu/linear_acceleration/z,/tool/force/z",
        *(fixed(EPOCH + T, 6), X, Y, Z, ["" if k % 2 else f"{SLOW[k]:.4f}" for k in K])),
        measured("acceleration|linear_acceleration", "1", X, Y, Z, note="unit", left_out=["force"])),
    case("unity_debug",
        "docs.unity3d.com: Time.time and transforms written with the culture's decimal comma between commas in "
        "quotes", table('Time,"Position (X)","Position (Y)","Position (Z)",Frame',
        *([f'"{v:.4f}"'.replace(".", ",") for v in c] for c in (T, X, Y, Z)), 1200 + K),
        measured("position", "1", X, Y, Z, note="unit", left_out=["Frame"])),
    case("json_lines", "jsonlines.org: an object for each row, time in ms since 1970",
        lines(ts=[n // 10**6 for n in NS], ax=X.tolist(), ay=Y.tolist(), az=Z.tolist(), battery=[97] * 100),
        plain("acceleration", left_out=["battery"]), file="imu.jsonl"),
    case("gzip_csv", "Sensor loggers on Linux: a compressed CSV",
        gzip.compress(table("t_s,x_g", T, X).encode(), mtime=0), one("acceleration", "m/s^2", G * PEAKS["x"]),
        file="take.csv.gz"),
)
