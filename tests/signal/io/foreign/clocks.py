"""Clocks: the ways in which tables write time. The samples are `X`, `Y` and `Z` in g."""

# fmt: off
# isort: off
from tests.signal.io.foreign.case import (
    EPOCH,
    Ask,
    G,
    K,
    N,
    Right,
    T,
    X,
    Y,
    Z,
    acceleration,
    case,
    fixed,
    stamps,
    table,
)
# isort: on

XYZ = "x [g],y [g],z [g]"
ALL = (X, Y, Z)
RIGHT = acceleration(G)
SPREADSHEETS = "spreadsheets and loggers of many makers"
FORMS = {"dotted_date_comma": ("%Y.%m.%d %H:%M:%S,%L", ";", "Datum"),
    "day_first": ("%d/%m/%Y %H:%M:%S.%L", ",", "Date"),
    "month_first_am_pm": ("%m/%d/%Y %I:%M:%S.%L %p", ",", "Date Time"),
    "german": ("%d.%m.%Y %H:%M:%S,%L", ";", "Datum Uhrzeit"), "colon_milliseconds": ("%H:%M:%S:%L", ",", "Time"),
    "compact": ("%Y%m%d%H%M%S%L", ",", "timestamp"), "compact_t": ("%Y%m%dT%H%M%S.%f", ",", "timestamp"),
    "iso_zone": ("%Y-%m-%dT%H:%M:%S.%f+09:00", ",", "time"), "iso_z": ("%Y-%m-%dT%H:%M:%S.%LZ", ",", "ts"),
    "underscores": ("%Y-%m-%d_%H-%M-%S_%L", ",", "timestamp"), "month_name": ("%d %b %Y %H:%M:%S.%L", ",", "When"),
    "iso_comma": ("%Y-%m-%dT%H:%M:%S,%L", ";", "Zeitpunkt"), "slashes": ("%Y/%m/%d %H:%M:%S.%L", ",", "日時"),
    "japanese": ("%Y年%m月%d日 %H時%M分%S.%L秒", ",", "日時"), "ctime": ("%a %b %d %H:%M:%S.%L %Y", ",", "time"),
    "month_first_quoted": ('"%b %d, %Y, %I:%M:%S.%L %p"', ",", "Time"),
    "net": ("%Y-%m-%dT%H:%M:%S.%f0+01:00", ",", "Time"), "nanoseconds": ("%Y-%m-%d %H:%M:%S.%f789", ",", "time"),
    "utc_name": ("%Y-%m-%d %H:%M:%S.%L UTC", ",", "time")}
NAMES = {
    1: ["t", "time", "Time (s)", "Timestamp", "t/s", "t in s", "Zeit / s", "time_s", "Time, s", "elapsed_s",
        "seconds", "Temps écoulé (s)", "経過時間[s]", "时间(s)", "X_Value", "Relative Time", "Elapsed Time(s)",
        "TIME_STAMP", "x [s]"],
    1e3: ["millis", "ms", "t_ms", "Zeit_ms", "Time since start in ms ", "time (msec)", "Time(mS)", "timestamp [ms]"],
    1e6: ["micros", "time_us", "t [µs]", "usec", "Time (microseconds)"],
    1e9: ["ts_ns", "timestamp (ns)"],
}
SIZES = {"s": 1.0, "ms": 1e3, "us": 1e6}
BLOCKS = fixed(0.2 * (K // 20) + 0.19, 2)

CLOCKS = (
    *(case(f"stamp_{name}", SPREADSHEETS,
        table(f"{heading}{sep}{XYZ}".replace(",", sep), stamps(form), *ALL, sep=sep), RIGHT)
        for name, (form, sep, heading) in FORMS.items()),
    *(case(f"clock_{scale:g}_{number}", SPREADSHEETS + ": " + name, table(
        f"{name};{XYZ}".replace(",x", ";x").replace(",y", ";y").replace(",z", ";z"), fixed(scale * T, 2), *ALL,
        sep=";"), RIGHT) for scale, names in NAMES.items() for number, name in enumerate(names)),
    *(case(f"epoch_{unit}_by_size", "loggers that say timestamp and mean since 1970",
        table(f"timestamp,{XYZ}", fixed((EPOCH + T) * factor, 3 if unit == "s" else 0), *ALL), RIGHT)
        for unit, factor in SIZES.items()),
    case("interval_column", "sketches that print the time since the last row",
        table(f"dt_ms,{XYZ}", 10 + (K % 5 == 0), *ALL), Ask("time|dt", {"time": "none", "rate": 100}, RIGHT),
        acceleration(G, rate=100 / 1.02)),
    case("not_padded", "sketches that print hours, minutes and seconds without zeros",
        table(f"time,{XYZ}", [f"9:5:{3 + k // 100}.{10 * (k % 100):03d}" for k in K], *ALL), RIGHT),
    case("epoch_rounded_by_excel", "support.microsoft.com: CSV opened and saved again, 13 digits become 1.76735E+12",
        table(f"timestamp,{XYZ}", "1.76735E+12", *ALL), Ask("rate", {"rate": 100}, RIGHT),
        Ask("rate|time", {"time": "none", "rate": 100}, RIGHT)),
    case("clock_rounded_by_excel", "support.microsoft.com: the same with clock times, which become 23:45.1",
        table(f"time,{XYZ}", [f"{23}:{45 + k // 100}.{k // 10 % 10}" for k in K], *ALL),
        Ask("rate", {"rate": 100}, RIGHT)),
    case("date_and_time_apart", SPREADSHEETS,
        table("Date;Time;x [g];y [g];z [g]", stamps("%d.%m.%Y"), stamps("%H:%M:%S,%L"), *ALL, sep=";"), RIGHT),
    case("time_and_milliseconds_apart", "loggers with a real-time clock: HH:MM:SS and a column of milliseconds",
        table(f"Date,Time,ms,{XYZ}", stamps("%Y-%m-%d"), stamps("%H:%M:%S"), 10 * K % 1000, *ALL), RIGHT,
        Ask("repeat|coarse|rate", {"rate": 100}, RIGHT)),
    case("sec_nanosec", "ROS 2 messages as tables: header.stamp.sec and header.stamp.nanosec",
        table(f"header.stamp.sec,header.stamp.nanosec,{XYZ}", EPOCH + K // 100, 10**7 * (K % 100), *ALL), RIGHT),
    case("seconds_and_microseconds", "gettimeofday in two columns",
        table(f"tv_sec,tv_usec,{XYZ}", EPOCH + (K + 50) // 100, 10**4 * ((K + 50) % 100), *ALL), RIGHT),
    case("minutes_and_seconds", "stopwatches: mm:ss.mmm", table(f"Elapsed,{XYZ}", stamps("%M:%S.%L"), *ALL), RIGHT),
    case("stamps_coarser_than_rate", "calendar stamps of whole seconds, a hundred rows each",
        table(f"Time,{XYZ}", stamps("%H:%M:%S", step=0.04), *ALL),
        Ask("rate", {"rate": 25}, acceleration(G, rate=25))),
    case("bluetooth_blocks", "BLE notifications: all samples of a packet have its time of arrival",
        table(f"time [s],{XYZ}", BLOCKS, *ALL), Ask("rate", {"rate": 100}, RIGHT)),
    case("first_stamp_of_block_only", "loggers that stamp the first row of a packet and leave the others empty",
        table(f"time [s],{XYZ}", ["" if k % 10 else f"{T[k]:.2f}" for k in K], *ALL),
        Ask("rate|time", {"time": "none", "rate": 100}, RIGHT), RIGHT),
    case("unit_of_time_by_size_ms", "a first column time without unit that goes in steps of 10: only ms is plausible",
        table(f"time,{XYZ}", 10 * K, *ALL), RIGHT),
    case("unit_of_time_unclear", "a column time that counts 0, 1, 2: s, ms or a number of the row",
        table(f"time,{XYZ}", K, *ALL), Ask("time|unit|rate", {"time": "time [ms]"}, acceleration(G, rate=1000)),
        Ask("time|unit|rate", {"rate": 100, "time": "none"}, RIGHT)),
    *(case(f"since_{name}", source, table(f"timestamp,{XYZ}", column, *ALL), RIGHT) for name, source, column in [(
        "boot_ns", "developer.android.com, SensorEvent.timestamp", [88_123 * 10**9 + int(k) * 10**7 for k in K]),
        ("2001_s", "developer.apple.com, CFAbsoluteTime", fixed(789_042_225 + T, 3)),
        ("1904_s", "ni.com, LabVIEW time stamp as a number", fixed(3_850_194_225 + T, 3))]),
    *(case(f"days_since_{name}", source, table(f"Time,{XYZ}", fixed(days + (37425 + T) / 86400, 10), *ALL), RIGHT,
        Ask("time|day", {"time": "none", "rate": 100}, RIGHT)) for name, source, days in [
        ("1900", "support.microsoft.com, date in a cell of the number format", 46024),
        ("0000", "mathworks.com, datenum", 739984)]),
    case("minutes", "loggers of slow quantities", table(f"Time [min],{XYZ}", fixed(T / 60, 7), *ALL), RIGHT),
    case("row_written_twice", "phones and databases: the same row is there twice",
        table(f"time_ms,{XYZ}", 10 * K, *ALL).replace("\n500,", f"\n490,{X[49]:.9g},{Y[49]:.9g},{Z[49]:.9g}\n500,"),
        RIGHT),
    case("rate_as_key_and_value", "exports of many programs: settings as rows of two cells above the table",
        "File,take1\nSample Rate (Hz),1000\nChannels,3\nRange (g),16\n\n" + table(XYZ, *ALL),
        acceleration(G, rate=1000)),
    case("ticks", "boards that print timer ticks", table(f"ticks,{XYZ}", 320_000 * K, *ALL),
        Ask("time|unit|ticks", {"rate": 100, "time": "none"}, RIGHT)),
    case("time_last", "the time in the last column", table(f"{XYZ},Time (ms)", *ALL, 10 * K), RIGHT),
    case("two_clocks_one_coarse", "local time in whole seconds beside the sensor's milliseconds",
        table(f"localtime,sensor_ms,{XYZ}", stamps("%Y-%m-%d %H:%M:%S"), 88_000 + 10 * K, *ALL), RIGHT),
    case("rate_in_a_column", "loggers that repeat the rate in each row", table(f"sample,fs_hz,{XYZ}", K, 100, *ALL),
        RIGHT, Ask("rate", {"rate": 100}, RIGHT)),
    case("rate_in_a_comment", "files of laboratories: # fs = 2 kHz above the headings",
        "# operator: lab\n# fs = 2 kHz\n# range: +/- 16 g\n" + table(XYZ, *ALL), acceleration(G, rate=2000)),
    case("interval_in_a_comment", "files of laboratories: sampling interval in ms above the headings, without #",
        "Subject: P01\nSampling interval: 0.5 ms\nMaterial: cork\n\n" + table(XYZ, *ALL), acceleration(G, rate=2000)),
    case("time_of_midnight", "clock times without a date over midnight", table(f"Time,{XYZ}", [
        f"{(86399.5 + t) % 86400 // 3600:02.0f}:{(86399.5 + t) % 3600 // 60:02.0f}:{(59.5 + t) % 60:06.3f}" for t in T
        ], *ALL), RIGHT),
    case("shuffled_rows", "databases: rows in another order than their time",
        table(f"time_ms,{XYZ}", *([c[37 * k % N] for k in K] for c in ([10 * int(k) for k in K], X, Y, Z))),
        Ask("back|order|sort|forward|time", {"time": "none", "rate": 100}, RIGHT),
        Right(RIGHT.stream, RIGHT.unit, RIGHT.peaks, note="sort|order")),
    case("clock_beside_slow_quantity", "a rising temperature is no clock, and no axis",
        table("elapsed,x [g],y [g],z [g],temp", fixed(T, 3), *ALL, fixed(20 + 0.01 * K, 2)),
        acceleration(G, left_out=["temp"])),
    case("rising_position_is_no_clock", "a stage that moves steadily: its position rises as evenly as a clock",
        table("pos_mm,x [g],y [g],z [g]", fixed(0.4 * K, 1), *ALL),
        Ask("rate", {"rate": 100}, acceleration(G, others={"position": "m"}))),
)
