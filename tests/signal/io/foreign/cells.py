"""Cells and rows: spellings of units, missing values, separators, comments, broken lines."""

# fmt: off
# isort: off
from tests.signal.io.foreign.case import (
    PEAKS,
    SLOW,
    Ask,
    G,
    K,
    Refused,
    Right,
    T,
    X,
    Y,
    Z,
    acceleration,
    case,
    fixed,
    measured,
    one,
    plain,
    rows,
    table,
)
# isort: on

RIGHT = acceleration(G)
MANY = "loggers, instruments and spreadsheets of many makers"
UNITS = {
    "acceleration m/s^2": ("[m/s²] (m/s^2) m/sec2 m/s/s [m·s⁻²] (ms-2) [m/s**2] [m/s2] [meters/second^2]", 1.0),
    "acceleration mm/s^2": ("[mm/s²] (mm/s^2)", 1e-3),
    "acceleration g": ("[g] (G) (g's) (gees) [Gs] [gn] [g_n] [g-force]", G),
    "acceleration mg": ("[mg] (mG) (milli-g) (milliG)", 1e-3 * G),
    "force": ("[N] (Newton) (newtons)", 1.0),
    "force mN": ("[mN] (millinewton)", 1e-3),
    "force gf": ("[gf] (gram-force)", 1e-3 * G),
    "force lbf": ("[lbf] (lb-force)", 4.4482216),
    "force kgf": ("[kgf] (kgf) [kp]", G),
    "voltage": ("[V] (Volts) (volt) Volts", 1.0),
    "voltage mV": ("[mV] (mVolts)", 1e-3),
    "position um": ("[um] [µm] [μm] (microns)", 1e-6),
    "position mm": ("[mm] (millimeters)", 1e-3),
    "angular_rate deg": ("[deg/s] (°/s) (dps) [degrees/sec]", 3.14159265 / 180),
    "angular_rate": ("[rad/s] (rad/sec) (radians/s)", 1.0),
    "pressure kPa": ("[kPa] (kilopascal)", 1e3),
    "velocity mm/s": ("[mm/s] (mm/sec)", 1e-3),
}
SI = {"acceleration": "m/s^2", "force": "N", "voltage": "V", "position": "m", "angular_rate": "rad/s",
    "pressure": "Pa"}
SI["velocity"] = "m/s"


AXES = [
    "a{x}", "a_{x}", "A{x}", "acc_{x}", "Acc{X}", "acc{X}", "ACC{X}", "Acc.{X}", "accel.{x}", "{X}_Accel",
    "{x}-acc", "{X}ACC", "acc{x}", "Accel{X}", "Acc-{X}", "accelerometer{X}", "accelerometerAcceleration{X}",
    "Acceleration{X}", "acceleration_{x}", "linear_acceleration.{x}", "imu/acc/{x}", "IMU.Acc_{X}", "acc_{x}_value",
    "Beschl_{x}", "Accélération{X}", "加速度{X}", "acc[{x}]", "imu_a{x}", "sensor1_acc_{x}", "Accelerometer_{x}_raw",
    "A{x}Raw", "userAcceleration.{x}", "a({x})", "acc:{x}", "A-{X}",
]


def spelled() -> list[tuple[str, str, str, float]]:
    """Return a name, stream, heading and factor of each spelling."""
    found = []
    for key, (spellings, factor) in UNITS.items():
        stream = key.split()[0]
        for number, unit in enumerate(spellings.split()):
            found.append(
                (
                    f"unit_{key.replace(' ', '_').replace('/', '_')}_{number}",
                    stream,
                    f"Channel 1 {unit}",
                    factor,
                )
            )
    return found


def axes(name: str) -> str:
    """Return headings of the time and of three axes, which stand in the name as {x} or {X}."""
    return ";".join(["t", *(name.format(x=axis, X=axis.upper()) for axis in "xyz")])


def with_cells(cell: str, *places: int) -> list[str]:
    return [cell if k in places else f"{X[k]:.4f}" for k in K]


BODY = rows(T, X, Y, Z).splitlines(keepends=True)
HEADING = "t [s],x [g],y [g],z [g]\n"

CELLS = (
    *(case(f"axis_{number}", MANY + ": " + name,
        table(axes(name), T, X, Y, Z, sep=";"),
        plain("acceleration|linear_acceleration")) for number, name in enumerate(AXES)),
    *(case(f"axis_plain_{number}", MANY + ": " + name,
        table(axes(name), T, X, Y, Z, sep=";"), plain())
        for number, name in
        enumerate(("{x}", "{X}", "{X}-Axis", "axis_{x}", "Achse {X}", "{x}_value", "Ch_{X}", " {x} "))),
    *(case(f"lines_{name}", source, (HEADING + "".join(BODY)).replace("\n", end), RIGHT) for name, source, end in [
        ("cr", "old Macintosh programs", "\r"), ("cr_cr_lf", "text written twice as text on Windows", "\r\r\n"),
        ("empty_between", "terminals that get both ends", "\n\n"), ("lf_cr", "boards that print \\n\\r", "\n\r")]),
    case("decimal_comma_alone", "numbers only with a decimal comma, which might be two columns",
        rows(fixed(X, 4), decimal=","), one("vibration", "1"),
        Ask("comma|column", {"axes": ("1",)}, one(".*", "1")), rate=100),
    case("decimal_comma_tabs_bare", "German LabVIEW: tabs, decimal comma, no heading",
        rows(fixed(T, 3), fixed(X, 4), fixed(Y, 4), fixed(Z, 4), sep="\t", decimal=","), plain(), file="messung.txt"),
    case("message_in_the_middle", "boards that print warnings between the rows",
        HEADING + "".join(BODY[:30]) + "WARN: FIFO overflow\n" + "".join(BODY[30:]), RIGHT, Refused("row 32")),
    case("garbled_row", "serial ports that lose bytes: a row is too short",
        HEADING + "".join(BODY[:30]) + "0.30,0.1\n" + "".join(BODY[31:]), RIGHT, Refused("row 32")),
    case("merged_row", "serial ports that lose an end of line: two rows in one",
        HEADING + "".join(BODY).replace("\n0.4,", "0.4,"), RIGHT, Refused("row 41")),
    case("long_preamble", "instruments with a hundred settings",
        "".join(f"Setting {k}: {k * k}\n" for k in K) + "\n" + HEADING + "".join(BODY), RIGHT),
    case("shimmer_three_rows", "shimmersensing.com, older exports: name, CAL, unit",
        "Shimmer_Timestamp\tShimmer_Accelerometer X\t" "Shimmer_Accelerometer Y\tShimmer_Accelerometer "
        "Z\nCAL\tCAL\tCAL\tCAL\nms\tm/(sec^2)*\tm/(sec^2)*\tm/(sec^2)*\n" + rows(10.0 * K, X, Y, Z, sep="\t"),
        acceleration()),
    case("column_of_nan", "a channel that was not connected", table("t [s],x [g],y [g],z [g]", T, X, "NaN", Z),
        Right("acceleration", "m/s^2", {"x": G * PEAKS["x"], "z": G * PEAKS["z"]}, left_out=["y [g]"])),
    case("contact_flag", "contact and material of each row", table("t [s],x [g],y [g],z [g],contact,class", T, X, Y,
        Z, ["TRUE" if k > 40 else "FALSE" for k in K], K // 40), acceleration(G, left_out=["contact", "class"])),
    case("number_of_the_sensor_first", "gateways: number of the sensor, milliseconds, values, no heading",
        rows(3, 10 * K, X, Y, Z), plain()),
    case("rising_force", "a force that rises evenly is neither clock nor counter",
        table("time [s],force [N]", T, 0.1 * K), one("force", "N", 9.9)),
    case("rising_position_alone", "a stage at constant speed, the only column", table("position [mm]", K),
        one("position", "m", 0.099), rate=100),
    case("sensors_as_groups", "spreadsheets: sensors written once above their axes",
        "Time [s],Sensor 1,,,Sensor 2,,\n,x [g],y [g],z [g],"
        "x [g],y [g],z [g]\n" + rows(T, X, Y, Z, 2 * X, 2 * Y, 2 * Z),
        Ask("which|Sensor|choose", {"axes": ("2", "3", "4")}, RIGHT)),
    case("torque_is_no_length", "six-axis sensors: Nm is newton metre, not nanometre",
        table("t [s],Tx [Nm],Ty [Nm],Tz [Nm],Fz [N]", T, X, Y, Z, X), one("force", "N", absent=["position"])),
    case("gravity_apart", "phones: acceleration without gravity beside gravity", table(
        "t,userAcceleration.x,userAcceleration.y,userAcceleration.z,gravity.x,gravity.y,gravity.z", T, X, Y, Z, SLOW,
        SLOW, SLOW), plain("acceleration|linear_acceleration", left_out=["gravity"])),
    *(case(name, MANY + ": " + heading, table(f"Time (s);{heading}", T, X, sep=";"),
        one(stream, SI[stream], factor * PEAKS["x"])) for name, stream, heading, factor in spelled()),
    *(case(f"missing_{name}", MANY, table("t [s],x [g],y [g],z [g]", T, with_cells(cell, 40, 41, 70), Y, Z), RIGHT,
        *([Refused("row 42.*inf")] if cell == "Inf" else [])) for name, cell in {"nan": "NaN", "na": "N/A",
        "dashes": "--", "excel": "#N/A", "empty": "", "null": "null", "ind": "-1.#IND", "ovf": "OVF", "inf": "Inf",
        "quoted": '""', "blank": " ", "div": "#DIV/0!"}.items()),
    case("missing_rows_three", "wireless sensors: three samples lost, which may be interpolated",
        HEADING + "".join(BODY[:50] + BODY[53:]), RIGHT),
    case("missing_marker_9999", "loggers that write -9999 for no value",
        table("t [s],x [g],y [g],z [g]", T, with_cells("-9999", 40, 41), Y, Z), RIGHT,
        Ask("-9999|row", {"part": 1}, RIGHT)),
    case("counts_lsb", "boards: LSB and counts are no unit of the signal, and are said",
        table("t_ms,ax_LSB,ay_LSB,az_LSB", 10 * K, *([round(16384 * v) for v in c] for c in (X, Y, Z))),
        measured("acceleration", "1", 16384 * X, 16384 * Y, 16384 * Z, note="unit|count|LSB")),
    case("heading_again_in_the_middle", "loggers that were restarted into the same file, time goes on",
        HEADING + "".join(BODY[:60]) + HEADING + "".join(BODY[60:]), RIGHT),
    case("comment_in_the_middle", "loggers that note events in the file",
        HEADING + "".join(BODY[:30]) + "# touched cork\n" + "".join(BODY[30:]) + "# end\n", RIGHT),
    case("cut_off_in_a_number", "loggers without power: the last line ends in a number that looks whole",
        HEADING + "".join(BODY) + "1.00,0.1,0.2", acceleration(G, note="last|cut|row")),
    case("cut_off_whole_line_without_end", "loggers without power: all cells are there, the end of the line is not",
        HEADING + "".join(BODY).rstrip("\n"), RIGHT),
    case("nul_bytes_at_the_end", "SD cards of loggers: the rest of the last block is NUL",
        (HEADING + "".join(BODY)).encode() + bytes(300), RIGHT),
    case("trailing_separators_in_rows_only", "Arduino sketches: comma behind each value, none behind the heading",
        HEADING + rows(T, X, Y, Z, tail=","), RIGHT),
    case("spaces_after_separators", "printf of many programs: comma and blanks, plus signs, aligned", table(
        "  t [s],   x [g],   y [g],   z [g]", *([f"{v:+10.4f}" for v in c] for c in (T, X, Y, Z)), sep=", "), RIGHT),
    case("fixed_width", "FORTRAN and C programs: columns aligned by blanks, heading with blanks in the names",
        "    Time    Acc X    Acc Y    Acc Z\n     (s)      (g)      (g)      (g)\n"
        + rows(*([f"{v:8.4f}" for v in c] for c in (T, X, Y, Z)), sep=" "), RIGHT, file="run.dat"),
    case("bare_decimal_point", "FORTRAN and MATLAB: .5 and 1. and D exponents",
        table("t x y z", *([f"{v:.8E}".replace("E", "D") for v in c] for c in (T, X, Y, Z)), sep=" "), plain(),
        Refused("1.0+D|row 2|exponent"), file="run.asc"),
    case("pipes", "PostgreSQL and markdown tables: | between, a line of dashes",
        " t [s] | x [g] | y [g] | z [g] \n-------+-------+-------+-------\n"
        + rows(*([f" {v:.4f} " for v in c] for c in (T, X, Y, Z)), sep="|"), RIGHT, file="query.txt"),
    case("tabs_in_csv", "programs that call any text .csv", table("t [s]\tx [g]\ty [g]\tz [g]", T, X, Y, Z, sep="\t"),
        RIGHT),
    case("comma_decimal_and_separator",
        "German programs: decimal comma and comma between, so that each number is two cells",
        table("t [s],x [g]", fixed(T, 2), fixed(X, 4), decimal=","), one("acceleration", "m/s^2", G * PEAKS["x"]),
        Refused("decimal (point|comma)")),
    case("apostrophe_thousands", "Swiss Excel: 10'000.5",
        table("t [ms];F [mN]", 10 * K, [f"{v:,.1f}".replace(",", "'") for v in 10_000 * X], sep=";"),
        one("force", "N", 10 * PEAKS["x"])),
    case("one_column_with_rate", "numbers only: one axis, rate given", rows(fixed(X, 5)),
        one("vibration", "1", note="unit"), rate=100, file="vibration.txt"),
    case("one_column_heading", "numbers only below a name", table("acceleration", X),
        one("acceleration", "1", note="unit"), rate=100),
    case("index_without_heading", "numbers only: a counter from 1 and an axis", rows(1 + K, X), one("vibration", "1"),
        rate=100),
    case("trials_side_by_side", "spreadsheets: each column is another trial, none is an axis of another",
        table("Time (s),Trial 1 (N),Trial 2 (N),Trial 3 (N)", T, X, Y, Z),
        Ask("which|columns|axes|Trial", {"axes": ("Trial 1",)}, one("force", "N")),
        measured("force", "N", X, Y, Z, axes=None)),
    case("wide_table", "research loggers: clock, counter, several quantities, battery, status and label in one row",
        table(
        "idx,timestamp_ms,acc_x_g,acc_y_g,acc_z_g,gyr_x_dps,gyr_y_dps,gyr_z_dps,mag_x_uT,mag_y_uT,mag_z_uT,force_N,"
        "pos_x_mm,pos_y_mm,temp_C,vbat_mV,rssi,status,material", *(K, 10 * K, X, Y, Z, 57 * SLOW, SLOW, SLOW,
        30 + SLOW, SLOW, SLOW, 1 + 0.2 * SLOW, 10 * SLOW, 5 * SLOW), *(25.1, 3700 + K % 3, -60 - K % 5, "OK", "cork"),
        ), acceleration(G, others={"angular_rate": "rad/s", "force": "N", "position": "m"},
        left_out=["idx", "temp_C", "vbat_mV", "rssi", "status", "material"])),
    case("constant_column", "exports with a column of zeros for an axis that was not connected",
        table("t [s],x [g],y [g],z [g],aux", T, X, Y, Z, 0.0), acceleration(G, left_out=["aux"])),
    case("axis_that_is_zero", "an axis that did not move is still an axis",
        table("t [s],x [g],y [g],z [g]", T, X, 0.0, Z),
        Right("acceleration", "m/s^2", {"x": G * PEAKS["x"], "y": 0.0, "z": G * PEAKS["z"]})),
    case("two_sensors", "two accelerometers on one board", table(
        "t [s],acc1_x [g],acc1_y [g],acc1_z [g],acc2_x [g],acc2_y [g],acc2_z [g]", T, X, Y, Z, 2 * X, 2 * Y, 2 * Z),
        Ask("acc1|acc2|which", {"axes": ("acc1_x", "acc1_y", "acc1_z")}, RIGHT)),
    case("left_and_right_hand", "two hands in one table",
        table("t [s],left_ax,left_ay,left_az,right_ax,right_ay,right_az", T, X, Y, Z, 2 * X, 2 * Y, 2 * Z),
        Ask("left|right|which", {"axes": ("left_ax", "left_ay", "left_az")}, plain("acceleration"))),
    case("same_heading_three_times", "exports whose columns have one name",
        table("Time,Acceleration,Acceleration,Acceleration", T, X, Y, Z),
        measured("acceleration", "1", X, Y, Z, axes=None, note="unit"), Refused("different name")),
    case("units_differ", "x in g, y in mg: one quantity in two units",
        table("t [s],x [g],y [mg],z [g]", T, X, 1000 * Y, Z), RIGHT),
    case("numbered_axes", "axes that are numbers: acc1, acc2, acc3",
        table("t [s],acc1 [g],acc2 [g],acc3 [g]", T, X, Y, Z),
        measured("acceleration", "m/s^2", G * X, G * Y, G * Z, axes=None), Ask("acc1|which",
        {"axes": ("acc1", "acc2", "acc3")}, measured("acceleration", "m/s^2", G * X, G * Y, G * Z, axes=None))),
    case("directions_in_words", "axes that are words: lateral, along, normal",
        table("t [s],F tangential [N],F normal [N]", T, X, Z), measured("force", "N", X, Z, axes=None)),
)
