"""Rows of several sensors by turns, clocks of other systems, weights in grams, summaries below the rows."""

import numpy as np

# fmt: off
# isort: off
from tests.signal.io.foreign.case import (
    G, K, N, PEAKS, Ask, Right, T, X, Y, Z, acceleration, case, fixed, one, plain, rows, table,
)
# isort: on

TWO = [values for k in K for values in (k, k)]
SIDES = ["L" if i % 2 == 0 else "R" for i in range(2 * N)]
BOTH = [np.repeat(values, 2) + np.tile((0, 2), N) * (values is X) for values in (X, Y, Z)]
KINDS = ["accelerometer" if i % 2 == 0 else "gyroscope" for i in range(2 * N)]
TICKS = [639_029_174_250_000_000 + 100_000 * int(k) for k in K]  # of 100 ns since the year 1
FILETIMES = [134_118_662_250_000_000 + 100_000 * int(k) for k in K]
HOURS = [f"{k // 600:02d}:{k // 10 % 60:02d}.{k % 10}" for k in K]
ROUNDED = np.floor(np.arange(600) / 833 * 1000)  # ms
WAVE = 0.5 * np.sin(2 * np.pi * 30 * np.arange(600) / 833)

INTERLEAVED = (
    case("hands_by_turns", "loggers of two gloves: a row of each hand by turns",
        table("hand,t_ms,ax_g,ay_g,az_g", SIDES, [10 * k for k in TWO], *BOTH),
        Ask("which acceleration.*L ax_g.*R ax_g", {"axes": ("L ax_g", "L ay_g", "L az_g")}, acceleration(G, "m/s^2"))),
    case("kinds_by_turns", "Android apps that write all sensors to one file (SensorManager, event.sensor.getName())",
        table("sensor,timestamp_ms,x,y,z", KINDS, [10 * k for k in TWO], *BOTH),
        plain("acceleration", note="rows apart by 'sensor'")),
    case("tags_without_heading", "sketches that print a tag before the values of each chip",
        rows([f"{tag},{10 * k},{x:.4f},{y:.4f},{z:.4f}" for k, x, y, z in zip(K, X, Y, Z, strict=True)
              for tag in ("ACC", "GYR")]), plain("acceleration", note="rows apart by")),
    case("axes_by_turns", "pandas.melt and R's tidyr: a row for each axis",
        table("time,axis,value", np.repeat(T, 3), ["x", "y", "z"] * N, np.stack([X, Y, Z], 1).ravel()), plain(".*")),
    case("statements", "WISDM (Kwapisz 2011), actitracker: each row ends with a semicolon",
        table("user,activity,timestamp,x,y,z", 33, "Jogging", 49105962326000 + 10_000_000 * K, X, Y, Z, tail=";"),
        plain("acceleration|vibration|", left_out=["user", "activity"])),
    case("statements_with_blanks", "boards that print a,b,c; without a heading",
        rows(10 * K, X, Y, Z, tail=";"), plain(".*")),
    case("weight_in_grams", "HX711 libraries: Weight (g) is a mass on a load cell",
        table("Time (s),Weight (g)", T, 50 * X), one("force", "N", 0.05 * G * PEAKS["x"])),
    case("weight_in_german", "kitchen scales and Spider8: Gewicht in g",
        table("Zeit (s);Gewicht (g)", T, 50 * X, sep=";", decimal=","), one("force", "N", 0.05 * G * PEAKS["x"])),
    case("friction_and_normal_force", "tribometers with load cells in grams",
        table("Time (s),Friction force (g),Normal force (g)", T, 50 * X, 100 * Z), Right("force", "N",
        [0.05 * G * PEAKS["x"], 0.1 * G * PEAKS["z"]])),
    case("net_ticks", "learn.microsoft.com, DateTime.Ticks: 100 ns since 0001-01-01",
        table("ticks,x [g],y [g],z [g]", TICKS, X, Y, Z), acceleration(G, note="100 ns")),
    case("filetime", "learn.microsoft.com, FILETIME: 100 ns since 1601-01-01",
        table("Timestamp,x [g],y [g],z [g]", FILETIMES, X, Y, Z), acceleration(G, note="100 ns")),
    case("excel_days", "support.microsoft.com, dates as numbers of days since 1900",
        table("Time,x [g],y [g],z [g]", [f"{46024.4331 + t / 86400:.10f}" for t in T], X, Y, Z),
        acceleration(G, note="since 1900")),
    case("matlab_days", "mathworks.com, datenum: days since the year 0",
        table("datenum,x [g],y [g],z [g]", [f"{739984.4331 + t / 86400:.10f}" for t in T], X, Y, Z),
        acceleration(G, note="since the year 0")),
    case("minutes_and_tenths", "Excel's format mm:ss.0",
        table("Time,Force [N]", HOURS, X), one("force", "N", PEAKS["x"], rate=10)),
    case("tens_of_milliseconds", "loggers that state a factor beside the unit",
        table("Time (10 ms),x [g],y [g],z [g]", K, X, Y, Z), acceleration(G)),
    case("unit_of_time_unknown", "a unit of time that nobody knows",
        table("Zeit [hs];x [g]", K, X, sep=";"), Ask("hs", {"time": "Zeit [10 ms]"}, one("acceleration", "m/s^2",
        G * PEAKS["x"]))),
    case("rounded_to_milliseconds", "ADXL355 and LSM6DS at 833 Hz with millis()",
        table("millis,x [g]", ROUNDED, WAVE), one("acceleration", "m/s^2", 0.5 * G, rate=833, samples=600,
        note="rounded")),
    case("rate_changes", "loggers whose rate is changed while they run",
        table("t [s],x [g]", fixed(np.concatenate([T[:50], 0.49 + 0.005 * np.arange(1, 51)]), 3), X),
        Ask("become 0.005 s", {"rate": 200}, one("acceleration", "m/s^2", G * 0.5, rate=200, samples=149))),
    case("newest_first", "exports in descending order of time",
        table("Time [s],x [g],y [g],z [g]", T[::-1], X[::-1], Y[::-1], Z[::-1]), acceleration(G, note="reversed")),
    case("millis_that_wrap", "millis() and micros() of Arduino start again at 2^32",
        table("millis,x [g],y [g],z [g]", (2**32 - 500 + 10 * K) % 2**32, X, Y, Z), acceleration(G)),
    case("summary_below", "spreadsheets with the mean below the columns",
        table("t [s],x [g],y [g],z [g]", T, X, Y, Z) + "Mean,0,0,1\nStd,0.35,0.17,0.07\n",
        acceleration(G, note="the last 2 rows")),
    case("clock_in_parts", "loggers with a column for each part of the time",
        table("Hour,Minute,Second,Millisecond,x [g],y [g],z [g]", 10, 23, 45 + K // 100, 10 * (K % 100), X, Y, Z),
        acceleration(G)),
    case("thousands_with_dots", "German programs: 1.234 is more than a thousand where decimals have commas",
        table("Zeit [s];Kraft [mN]", [f"{t:.3f}".replace(".", ",") for t in T],
        [f"{round(v):,}".replace(",", ".") for v in 5000 * X], sep=";"), one("force", "N", 5 * PEAKS["x"])),
    case("keysight_one_channel", "Keysight InfiniiVision: x-axis,1 above second,Volt",
        "x-axis,1\nsecond,Volt\n" + rows([f"{t:.5E}" for t in T], [f"{v:+.5E}" for v in X]), one(".*", "V")),
    case("optitrack_rigid_body", "docs.optitrack.com, Motive: rotation beside position, with its unit above",
        "Format Version,1.23,Take Name,t,Length Units,Millimeters,Coordinate Space,Global\n\n"
        ",,Rotation,Rotation,Rotation,Position,Position,Position\nFrame,Time (Seconds),X,Y,Z,X,Y,Z\n"
        + rows(K, T, 0.1, 0.2 * X, 0.3 * Y, 1000 * X, 1000 * Y, 1000 * Z), Right("position", "m", PEAKS)),
    case("instek_fast", "GW Instek GDS: counts in its fast mode",
        "Vertical Units,V,\nVertical Scale,2.000e-01,\nHorizontal Units,S,\nSampling Period,1.0e-02,\nMode,Fast,\n"
        "Waveform Data,\n" + rows([f"{round(125 * v)}," for v in X]),
        one(".*", "1", np.abs(np.round(125 * X)).max(), note="25 to a division")),
    case("feet_per_second_squared", "a unit that is stated is used or said to be unknown",
        table("t [s],Accel (ft/s²)", T, X), one("acceleration", "m/s^2", 0.3048 * PEAKS["x"])),
    case("unit_nobody_knows", "a stated unit that no signal has",
        table("t [s],Stiffness (N/mm)", T, X), one(".*", "1", PEAKS["x"], note="N/mm is not known")),
    case("python_durations", "pandas.Timedelta as text",
        table("time,x [g],y [g],z [g]", [f"0 days 00:00:{t:09.6f}" for t in T], X, Y, Z), acceleration(G)),
    case("ros_stamps", "rostopic echo -p: the time of arrival beside that of the header",
        table("%time,field.header.stamp,x [g],y [g],z [g]",
        [1767350000000000000 + 10_000_000 * k + 1_500_000 * (k % 3) for k in map(int, K)],
        [1767350000000000000 + 10_000_000 * k for k in map(int, K)], X, Y, Z), acceleration(G)),
)
"""See `tests.signal.io.foreign.case`."""
