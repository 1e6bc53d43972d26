"""Serial ports: what terminals and monitors save of what a board prints."""

# fmt: off
# isort: off
from tests.signal.io.foreign.case import (
    SLOW, Ask, G, K, T, X, Y, Z, acceleration, case, fixed, measured, plain, rows, stamps, table,
)
# isort: on

ARDUINO = "docs.arduino.cc, serial monitor"
CLOCK = stamps("%H:%M:%S.%L")
NUMBERS = [",".join(f"{v:.4f}" for v in row) for row in zip(X, Y, Z, strict=True)]
COUNTS = [[round(16384 * v) for v in c] for c in (X, Y, Z)]
HEX = [f"0x{k % 256:02X}" for k in K]

SERIAL = (
    case("arduino_plotter_labels", "docs.arduino.cc, serial plotter: label:value pairs, comma or tab between",
        rows(*([f"{name}:{v:.4f}" for v in c] for name, c in (("ax", X), ("ay", Y), ("az", Z))), sep=","),
        Ask("rate", {"rate": 100}, plain("acceleration")), file="plotter.txt"),
    case("arduino_greetings_first",
        ARDUINO + ": boot messages, a heading of the sketch, and lines cut off at the start",
        "0.43,0.2\nMPU6050 connected!\nCalibrating, do not move...\nt_ms,ax,ay,az\n" + rows(10 * K, X, Y, Z),
        plain("acceleration"), file="monitor.txt"),
    case("arduino_stamps_and_labels", ARDUINO + " with time stamps, labels of the sketch and units behind the values",
        rows([f"{c} -> X: {x:.3f} g  Y: {y:.3f} g  Z: {z:.3f} g" for c, x, y, z in zip(CLOCK, X, Y, Z, strict=True)],
        end="\r\n"), acceleration(G), plain(), file="monitor.txt"),
    case("quotes_below_the_heading", "Python loggers of a serial port: empty lines, quoted, below the heading",
        'Time,AccX,AccY,AccZ\n""\n""\n' + rows(K, *COUNTS), Ask(
        "'Time'.*--|time column 'Time' without unit", {"rate": 100}, measured("acceleration", "1", *COUNTS))),
    case("klipper_accelerometer", "klipper3d.org, ACCELEROMETER_MEASURE: mm/s^2, not stated, heading in a comment",
        table("#time,accel_x,accel_y,accel_z", fixed(657.33 + T, 6), *(1e3 * G * v for v in (X, Y, Z))),
        measured("acceleration", "1", *(1e3 * G * v for v in (X, Y, Z)), note="gravity in mm/s")),
    case("mpu6050_raw_counts", "electronics tutorials of the MPU-6050: a/g: and seven integers between tabs",
        rows([f"a/g:\t{a}\t{b}\t{c}\t-120\t33\t{k % 5}" for k, a, b, c in zip(K, *COUNTS, strict=True)]), Ask(
        "rate|columns|which", {"axes": ("2", "3", "4"), "rate": 100}, measured(".*", "1", *COUNTS, axes=None)),
        file="mpu.txt"),
    case("micros_first_without_heading",
        "Arduino sketches: micros() and three values, no heading; 10 ms steps can only be µs",
        rows(4_213_776 + 10_000 * K, X, Y, Z), plain(), file="capture.txt"),
    case("millis_jitter", "Arduino sketches: millis() that is now and then one off",
        table("millis,ax,ay,az", 5231 + 10 * K + (K % 7 == 3), X, Y, Z),
        measured("acceleration", "1", X, Y, Z, note="unit")),
    case("putty_log", "chiark.greenend.org.uk, PuTTY session log: a line of =~ first",
        "=~=~=~=~=~=~=~=~=~=~=~= PuTTY log 2026.01.02 10:23:45 =~=~=~=~=~=~=~=~=~=~=~=\n" + rows(NUMBERS, end="\r\n"),
        Ask("rate", {"rate": 100}, plain()), file="putty.log"),
    case("teraterm_log",
        "teratermproject.github.io, log with time stamps: [Fri Jan 02 10:23:45.000 2026] before each line", rows(
        [f"[{c}] {n}" for c, n in zip(stamps("%a %b %d %H:%M:%S.%L %Y"), NUMBERS, strict=True)], end="\r\n"), plain(),
        file="teraterm.log"),
    case("coolterm_stamps", "freeware.the-meiers.org, CoolTerm: date and time with milliseconds before each line",
        rows([f"{c} {n}" for c, n in zip(stamps("%Y-%m-%d %H:%M:%S.%L"), NUMBERS, strict=True)]), plain(),
        file="CoolTerm Capture 2026-01-02 10-23-45-000.txt"),
    case("realterm_stamps", "realterm.sourceforge.io, capture with Unix or MATLAB time stamps: number, comma, line",
        rows([f"{1767350000 + t:.3f},{n}" for t, n in zip(T, NUMBERS, strict=True)]), plain(), file="capture.txt"),
    case("screen_ts_prefix", "moreutils ts and pio device monitor -f time: HH:MM:SS.mmm > before each line",
        rows([f"{c} > {n}" for c, n in zip(CLOCK, NUMBERS, strict=True)]), plain(), file="device-monitor.log"),
    case("esp32_idf_log", "docs.espressif.com, logging library: I (ms since boot) tag: and the values",
        "I (312) cpu_start: Starting scheduler.\n"
        + rows([f"I ({1312 + 10 * k}) imu: {n}" for k, n in zip(K, NUMBERS, strict=True)]), plain(), file="idf.log"),
    case("micropython_tuples", "docs.micropython.org, Thonny and Mu REPL: printed tuples",
        ">>> %Run -c $EDITOR_CONTENT\n" + rows([f"({n.replace(',', ', ')})" for n in NUMBERS]),
        Ask("rate", {"rate": 100}, plain()), file="thonny.txt"),
    case("hex_counter", "boards that print a packet number in hexadecimal and status bits", table(
        "pkt,t_ms,ax_mg,ay_mg,az_mg,flags", HEX, 10 * K, *([round(1000 * v) for v in c] for c in (X, Y, Z)), "0x00"),
        acceleration(G, left_out=["pkt", "flags"])),
    case("counter_that_wraps", "boards that count packets in one byte",
        table("cnt,ax,ay,az,crc", (200 + K) % 256, X, Y, Z, [(37 * int(k)) % 251 for k in K]),
        Ask("rate", {"rate": 100}, plain("acceleration", left_out=["cnt", "crc"]))),
    case("temperature_last_no_heading", "sketches that print ax ay az gx gy gz temp without a heading",
        rows(X, Y, Z, 10 * SLOW, 8 * SLOW, 5 * SLOW, fixed(25.1 + 0.01 * (K % 3), 2), sep="\t"),
        Ask("rate|columns|which", {"axes": ("1", "2", "3"), "rate": 100}, plain()), file="imu.txt"),
    case("nmea_like_sentences", "boards that print $IMU sentences with a checksum",
        rows([f"$IMU,{k},{n}*{k % 256:02X}" for k, n in zip(10 * K, NUMBERS, strict=True)]), plain(),
        Ask("rate|number|column", {"axes": ("3", "4", "5"), "time": "2 [ms]"}, plain()), file="nmea.log"),
)
