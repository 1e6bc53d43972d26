"""Phones: apps that log the sensors of a telephone."""

import json

import numpy as np

# fmt: off
# isort: off
from tests.signal.io.foreign.case import (
    EPOCH, SLOW, Ask, G, K, N, Refused, Right, T, X, Y, Z, acceleration, case, fixed, measured, one, plain, rows,
    stamps, table,
)
# isort: on

PHYPHOX = "phyphox.org wiki, export; headings as its experiments name them in each language"
SENSOR_LOGGER = "github.com/tszheichoi/awesome-sensor-logger"
LANGUAGES = {"de": ("Zeit (s)", "Beschleunigung {} (m/s^2)", "Absolute Beschleunigung (m/s^2)"),
    "fr": ("Temps (s)", "Accélération {} (m/s^2)", "Accélération absolue (m/s^2)"),
    "es": ("Tiempo (s)", "Aceleración {} (m/s^2)", "Aceleración absoluta (m/s^2)"),
    "it": ("Tempo (s)", "Accelerazione {} (m/s^2)", "Accelerazione assoluta (m/s^2)"),
    "nl": ("Tijd (s)", "Versnelling {} (m/s^2)", "Absolute versnelling (m/s^2)"),
    "pl": ("Czas (s)", "Przyspieszenie {} (m/s^2)", "Przyspieszenie całkowite (m/s^2)"),
    "zh": ("时间 (s)", "加速度 {} (m/s^2)", "绝对加速度 (m/s^2)"),
    "ko": ("시간 (s)", "가속도 {} (m/s^2)", "절대 가속도 (m/s^2)")}
NORM = np.sqrt(X**2 + Y**2 + Z**2)
SCIENTIFIC = [[f"{value:.9E}" for value in values] for values in (T, X, Y, Z, NORM)]
SPLIT = ["2026-01-02 10:23:45:" + f"{10 * k:03d}" for k in K]


def phyphox(language: str, sep: str, decimal: str) -> str:
    time, axis, norm = LANGUAGES[language]
    heading = sep.join(f'"{text}"' for text in (time, *map(axis.format, "xyz"), norm))
    return table(heading, T, X, Y, Z, NORM, sep=sep, decimal=decimal)


def sensorlog_heading() -> str:
    places = "XYZ"
    names = [
        "loggingTime(txt)",
        "loggingSample(N)",
        "deviceID(txt)",
        "locationLatitude(WGS84)",
        "locationSpeed(m/s)",
    ]
    names += ["accelerometerTimestamp_sinceReboot(s)", *(f"accelerometerAcceleration{a}(G)" for a in places)]
    names += [
        "motionTimestamp_sinceReboot(s)",
        "motionYaw(rad)",
        *(f"motionRotationRate{a}(rad/s)" for a in places),
    ]
    names += [f"motionUserAcceleration{a}(G)" for a in places]
    names += [
        "motionQuaternionW(R)",
        *(f"motionGravity{a}(G)" for a in places),
        "activity(txt)",
        "batteryLevel(R)",
    ]
    return ",".join(names)


def apart(*sensors: tuple[str, int]) -> str:
    """Return JSON of the entries of sensors, one after another, each at its own times."""
    entries = []
    for name, shift in sensors:
        for k in K:
            entry = {
                "sensor": name,
                "time": str(EPOCH * 10**9 + int(k) * 10**7 + shift),
                "seconds_elapsed": str(T[k]),
            }
            entries.append(entry | {axis: str(float(v[k])) for axis, v in zip("zyx", (Z, Y, X), strict=True)})
    return json.dumps(entries)


PHONES = (
    *(case(f"phyphox_{language}", PHYPHOX, phyphox(language, sep, decimal),
        acceleration(left_out=[LANGUAGES[language][2].removesuffix(" (m/s^2)")]), file="Raw Data.csv")
        for language, sep, decimal in [
        *(("de", ";", ","), ("fr", ";", ","), ("es", "\t", ","), ("it", ";", "."), ("nl", "\t", ".")),
        *(("pl", ";", ","), ("zh", ",", "."), ("ko", ",", "."))]),
    case("phyphox_en_linear", PHYPHOX, table(
        '"Time (s)","Linear Acceleration x (m/s^2)","Linear Acceleration y (m/s^2)",'
        '"Linear Acceleration z (m/s^2)","Absolute acceleration (m/s^2)"', *SCIENTIFIC), Right(
        "acceleration|linear_acceleration", "m/s^2", acceleration().peaks, left_out=["Absolute acceleration"])),
    case("phyphox_gyroscope", PHYPHOX, table(
        '"Time (s)","Gyroscope x (rad/s)","Gyroscope y (rad/s)","Gyroscope z (rad/s)","Absolute (rad/s)"', T, X, Y, Z,
        NORM),
        measured("angular_rate", "rad/s", X, Y, Z, left_out=["Absolute"])),
    case("phyphox_audio", PHYPHOX + ": audio scope", table('"Time (ms)","Recording (a.u.)"', fixed(K / 48, 6), X),
        one("sound|vibration", "1", rate=48_000)),
    *(case(f"unit_{name}", "IO-VNBD data set and its readers: AndroSensor's unit after a wrong encoding",
        table("TIME SINCE START (ms)," + ",".join(f" ACCELEROMETER {a} ({unit})" for a in "XYZ"), 10 * K, X, Y, Z),
        acceleration(), plain("acceleration"))
        for name, unit in (("mojibake", "m/sÂ²"), ("lost_exponent", "m/s\ufffd"))),
    case("phyphox_excel_97", PHYPHOX + ": its Excel export is the binary .xls of 1997",
        bytes.fromhex("D0CF11E0A1B11AE1") + bytes(4096), Refused(r"\.xlsx|CSV"), file="Acceleration.xls"),
    case("physics_toolbox_g_force", "vieyrasoftware.net, Physics Toolbox Sensor Suite: g-force recorder",
        table("time,gFx,gFy,gFz,TgF", fixed(T, 4), X, Y, Z, NORM), plain(left_out=["TgF"]),
        acceleration(G, left_out=["TgF"])),
    case("physics_toolbox_clock",
        "vieyrasoftware.net, Physics Toolbox with clock time; decimal comma of the phone's language", table(
        "time;ax (m/s^2);ay (m/s^2);az (m/s^2);aT (m/s^2)", ["10:23:45:" + f"{10 * k:03d}" for k in K], X, Y, Z, NORM,
        sep=";", decimal=","), acceleration(left_out=["aT"])),
    case("physics_toolbox_multi_record", "vieyrasoftware.net, Physics Toolbox multi record", table(
        "time,gFx,gFy,gFz,ax,ay,az,wx,wy,wz,p,Bx,By,Bz,Azimuth,Pitch,Roll,Latitude,Longitude,I,dB,", *(T, X, Y, Z,
        0.1 * X, 0.1 * Y, 0.1 * SLOW, SLOW, SLOW, SLOW, 1013.2, 20 + SLOW, SLOW, SLOW, 90 + SLOW),
        *(SLOW, SLOW, 52.5, 13.4, 120.0, 40 + SLOW), tail=","), Ask("gFx.* or .*ax|which",
        {"axes": ("gFx", "gFy", "gFz")}, plain("acceleration", note="", left_out=["Azimuth"])),
        acceleration(G, left_out=["Azimuth", "Latitude"]),
        plain("acceleration", others={"linear_acceleration": "m/s^2"}, left_out=["Azimuth", "Latitude"])),
    case("sensor_log_orientation", "SensorLog for iOS, semicolons: how the device is held is no sensor", table(
        "Date;Timestamp;DeviceOrientation;AccelerationX;AccelerationY;AccelerationZ;Label", "2026-01-02 10:23:45",
        [f"{EPOCH + k / 100:.4f}" for k in range(N)], ["faceUp" if k < 30 else "portrait" for k in range(N)],
        X, Y, Z, "", sep=";"), plain(left_out=["DeviceOrientation"])),
    case("sensor_logger_file",
        SENSOR_LOGGER + ": a file for each sensor, axes from z to x, no unit but in its documentation",
        table("time,seconds_elapsed,z,y,x", [EPOCH * 10**9 + k * 10**7 for k in range(N)], T, Z, Y, X),
        plain("acceleration"), file="Accelerometer.csv"),
    case("sensor_logger_json", SENSOR_LOGGER + ": JSON export, entries of all sensors in one list",
        apart(("Accelerometer", 0), ("Gyroscope", 3)), plain("acceleration"), Refused("csv|lines|table"),
        file="recording.json"),
    case("sensorlog_ios",
        "sensorlog.berndthomas.net: headings with type or unit in brackets, (N), (R) and (txt) are none", table(
        sensorlog_heading(), *(stamps("%Y-%m-%dT%H:%M:%S.%L+01:00"), K, "my_iPhone", 52.5, 0.0, 5000 + T, X, Y, Z,
        5000 + T, SLOW), *(SLOW, SLOW, SLOW, 0.1 * X, 0.1 * Y, 0.1 * SLOW, 1.0, 0.0, 0.0, -1.0, "stationary", 0.97)),
        acceleration(G, others={"linear_acceleration": "m/s^2", "angular_rate": "rad/s"},
        left_out=["loggingSample", "batteryLevel"])),
    case("matlab_mobile", "mathworks.com, MATLAB Mobile: timetable of Acceleration, by writetimetable",
        table("Timestamp,X,Y,Z", stamps("%d-%b-%Y %H:%M:%S.%L"), X, Y, Z), plain("acceleration"),
        file="Acceleration.csv"),
    case("androsensor", "fivasim.com, AndroSensor: sep= line, cells of text such as 18 / 19, blanks beside headings",
        "sep=;\n" + table(
        "ACCELEROMETER X (m/s²);ACCELEROMETER Y (m/s²);ACCELEROMETER Z (m/s²);GRAVITY X (m/s²);GRAVITY Y (m/s²);"
        "GRAVITY Z (m/s²);LINEAR ACCELERATION X (m/s²);LINEAR ACCELERATION Y (m/s²);LINEAR ACCELERATION Z (m/s²);"
        "GYROSCOPE X (rad/s);GYROSCOPE Y (rad/s);GYROSCOPE Z (rad/s);LIGHT (lux);MAGNETIC FIELD X (μT);"
        "MAGNETIC FIELD Y (μT);MAGNETIC FIELD Z (μT);ORIENTATION Z (azimuth °);SOUND LEVEL (dB);"
        "GPS SATELLITES IN RANGE;Time since start in ms ;YYYY-MO-DD HH-MI-SS_SSS", *(X, Y, Z, 0.0, 0.0, 9.80665,
        0.1 * X, 0.1 * Y, 0.1 * SLOW, SLOW, SLOW, SLOW, 12.0, SLOW, SLOW, SLOW),
        *(90 + SLOW, 40 + SLOW, "18 / 19", 10 * K, SPLIT), sep=";"), acceleration(
        others={"gravity": "m/s^2", "linear_acceleration": "m/s^2", "angular_rate": "rad/s"},
        left_out=["LIGHT", "SOUND LEVEL", "SATELLITES"]), encoding="cp1253"),
    case("sensor_kinetics", "innoventions.com, Sensor Kinetics export: heading time,X_value,Y_value,Z_value",
        table("time,X_value,Y_value,Z_value", fixed(T, 3), X, Y, Z), plain()),
    case("activity_label_above",
        "github.com/AhmedHamedTN/SensorLogger: a comment with the label, units without a blank", "#walk\n"
        + table("time[ms]; x-axis[m/s^2]; y-axis[m/s^2]; z-axis[m/s^2]", 728 + 10 * K, X, Y, Z, sep=";"),
        acceleration()),
    case("magnitude_first", "exelerus.com support, recording files: magnitude before the axes",
        table("DateTime;Magnitude;X;Y;Z", stamps("%Y-%m-%d %H:%M:%S.%L"), NORM, X, Y, Z, sep=";"),
        plain(left_out=["Magnitude"])),
    case("watch_of_several_sensors",
        "heartsome.de, Gear S logger: a letter, a time and axes for each sensor side by side", table(
        "s_A;time_A;x_A;y_A;z_A;s_B;time_B;x_B;s_R;time_R;x_R;y_R;z_R",
        *("A", 10 * K, X, Y, Z, "B", 10 * K, "", "R", 10 * K, SLOW, SLOW, SLOW), sep=";"), plain(),
        Right("acceleration|vibration", "1", acceleration().peaks)),
    case("android_export_z_first_ms",
        "public Android loggers: milliseconds since start, headings in capitals, semicolons",
        table("TIMESTAMP;ACC_Z [m/s2];ACC_Y [m/s2];ACC_X [m/s2];", 10 * K, Z, Y, X, sep=";", tail=";"),
        acceleration()),
    case("values_named_in_rows", "public BLE loggers: name and value in each cell, as a serial plotter has them",
        rows([f"{k / 100:.2f}" for k in K], [f"X:{v:.4f}" for v in X], [f"Y:{v:.4f}" for v in Y],
        [f"Z:{v:.4f}" for v in Z], sep=" "), plain(), file="log.txt"),
)
