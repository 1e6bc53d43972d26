"""Loggers: inertial sensors and data loggers that are worn or glued on."""

# fmt: off
# isort: off
from tests.signal.io.foreign.case import (
    EPOCH, SLOW, Ask, G, K, Refused, T, X, Y, Z, acceleration, case, fixed, measured, plain, rows, stamps, table,
)
# isort: on

RIGHT_G = acceleration(G)
ACTIGRAPH = (
    "------------ Data File Created By ActiGraph GT3X+ ActiLife v6.13.4 Firmware v3.2.1 date format M/d/yyyy at "
    "100 Hz  " "Filter Normal -----------\nSerial Number: XXX0A00000000\nStart Time 10:23:45\nStart Date 1/2/2026\n"
    "Epoch Period (hh:mm:ss) 00:00:00\nDownload Time 11:02:03\nDownload Date 1/2/2026\nCurrent Memory Address: 0\n"
    "Current Battery Voltage: 4.07     Mode = 12\n--------------------------------------------------\n")
GENEACTIV = (
    "Device Type,GENEActiv\nDevice Model,1.1\nDevice Unique Serial Code,000000\nMeasurement Frequency,100 Hz\n"
    "Sensor type,MEMS accelerometer x-axis\nRange,-8 to 8\nResolution,0.0039\nUnits,g\n"
    "Sensor type,MEMS accelerometer y-axis\nRange,-8 to 8\nResolution,0.0039\nUnits,g\n\n")
X16 = (";Title, http://www.gcdataconcepts.com, X16-1D, ADXL345\n;Version, 1113, Build date, Jan  6 2026,  "
    "SN:CCDC0000000000\n"
    ";Start_time, 2026-01-02, 10:23:45.000\n;Temperature, -999.00, deg C,  Vbat, 4138, mv\n;SampleRate, 100,Hz\n"
    ";Deadband, 0, counts\n;DeadbandTimeout, 0,sec\n;Headers, time,Ax,Ay,Az\n")
LN, WR = ([f"Shimmer_AB01_Accel_{kind}_{a}_CAL" for a in "XYZ"] for kind in ("LN", "WR"))
SHIMMER = "shimmersensing.com, Consensys export: tab, a row of units, a tab at the end of each line"
ANALOG = [[512 + round(200 * v) for v in values] for values in (X, Y, Z)]
SIXTY_FOURTHS = [[round(64 * v) for v in values] for values in (X, Y, Z)]
COUNTS = [[round(2048 * v) for v in values] for values in (X, Y, Z)]

LOGGERS = (
    case("metawear", "mbientlab.com, MetaBase export: epoch in ms, local time, elapsed seconds", table(
        "epoch (ms),time (01:00),elapsed (s),x-axis (g),y-axis (g),z-axis (g)",
        *([EPOCH * 1000 + 10 * int(k) for k in K], stamps("%Y-%m-%dT%H:%M:%S.%L"), fixed(T, 3), X, Y, Z)), RIGHT_G,
        file="MetaWear_2026-01-02T10.23.45.000_Accelerometer.csv"),
    case("shimmer_two_accelerometers", SHIMMER + "; low-noise and wide-range accelerometer", '"sep=\t"\n' + table(
        "\t".join(["Shimmer_AB01_Timestamp_Unix_CAL", *LN, *WR, "Shimmer_AB01_Battery_CAL", ""]), sep="\t"
        ).split("\n")[0] + "\n" + "\t".join(["ms", *["m/(s^2)"] * 6, "mV", ""]) + "\n" + rows(
        fixed(EPOCH * 1000.0 + 10 * K, 3), X, Y, Z, 1.1 * X, 1.1 * Y, 1.1 * Z, 3700.0, sep="\t", tail="\t"),
        Ask("Accel_LN|Accel_WR|which", {"axes": LN}, acceleration())),
    case("shimmer_formatted_time", SHIMMER + "; date and time as text, an analogue input beside the gyroscope", table(
        "Shimmer_AB01_TimestampSync_FormattedUnix_CAL\tShimmer_AB01_Gyro_X_CAL\tShimmer_AB01_Gyro_Y_CAL\t"
        "Shimmer_AB01_Gyro_Z_CAL\tShimmer_AB01_Accel_LN_X_CAL\tShimmer_AB01_Accel_LN_Y_CAL\t"
        "Shimmer_AB01_Accel_LN_Z_CAL\t\nyyyy/mm/dd hh:mm:ss.000\tdeg/s\tdeg/s\tdeg/s\tm/(s^2)\tm/(s^2)\tm/(s^2)\t",
        *(stamps("%Y/%m/%d %H:%M:%S.%L"), SLOW, SLOW, SLOW, X, Y, Z), sep="\t", tail="\t"),
        acceleration(others={"angular_rate": "rad/s"})),
    case("xsens_dot", "base.movella.com, DOT data export: preamble, counter, SampleTimeFine in µs (wraps at 2^32)",
        "sep=,\nDeviceTag:,DOT 1\nFirmwareVersion:,2.3.2\nAppVersion:,2022.7.0\nSyncStatus:,Unsynced\n"
        "OutputRate:,100 Hz\nFilterProfile:,General\nMeasurementMode:,Custom mode 5\nStartTime:,"
        "2026-01-02_10-23-45\n\n" + table(
        "PacketCounter,SampleTimeFine,Euler_X,Euler_Y,Euler_Z,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z",
        *(1 + K, 192856375 + 10000 * K, SLOW, SLOW, SLOW, X, Y, Z, SLOW, SLOW, SLOW)),
        plain("acceleration", left_out=["PacketCounter"])),
    case("xsens_mtw_text", "base.movella.com, MT Manager ASCII export: // comments, empty columns, rotation matrix",
        "// Start Time: Unknown\n// Update Rate: 100.0Hz\n// Filter Profile: human\n// Firmware Version: 4.0.2\n"
        + table(
        "PacketCounter\tSampleTimeFine\tYear\tMonth\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\tMat[1][1]\tMat[2][1]",
        *([f"{3583 + int(k):05d}" for k in K], "", "", "", X, Y, Z, SLOW, SLOW, SLOW, 1 + SLOW, SLOW), sep="\t"),
        plain("acceleration", left_out=["PacketCounter"]), file="MT_00B421AF-000.txt"),
    case("movesense", "movesense.com, showcase app: CSV of the accelerometer",
        table("Timestamp (ms),X: (m/s^2),Y: (m/s^2),Z: (m/s^2)", 48211 + 10 * K, X, Y, Z), acceleration()),
    case("empatica_e4",
        "support.empatica.com, ACC.csv: first row the start in s since 1970, second row the rate, then 1/64 g",
        f"{EPOCH}.000000, {EPOCH}.000000, {EPOCH}.000000\n32.000000, 32.000000, 32.000000\n" + rows(*SIXTY_FOURTHS),
        Refused("row 1|first row|since 1970|rate"),
        measured("acceleration|vibration", "1", *SIXTY_FOURTHS, rate=32, note="unit"), file="ACC.csv"),
    case("axivity_omgui", "github.com/digitalinteraction/openmovement, omconvert: date and time, no heading",
        rows(stamps("%Y-%m-%d %H:%M:%S.%L"), X, Y, Z), plain()),
    case("actigraph_raw", "actigraphcorp.my.site.com, ActiLife raw export: rate in the first line of ten",
        ACTIGRAPH + table("Accelerometer X,Accelerometer Y,Accelerometer Z", X, Y, Z), plain("acceleration"),
        file="XXX0A00000000RAW.csv"),
    case("actigraph_imu",
        "actigraphcorp.my.site.com, ActiLife IMU export: several quantities, calendar stamps month first", ACTIGRAPH
        + table(
        "Timestamp,Accelerometer X,Accelerometer Y,Accelerometer Z,Temperature,Gyroscope X,Gyroscope Y,Gyroscope Z,"
        "Magnetometer X,Magnetometer Y,Magnetometer Z",
        *(stamps("%m/%d/%Y %H:%M:%S.%L"), X, Y, Z, 25 + SLOW, SLOW, SLOW, SLOW, SLOW, SLOW, SLOW)),
        plain("acceleration", left_out=["Temperature", "Gyroscope X"])),
    case("geneactiv",
        "activinsights.com, GENEActiv CSV: preamble of keys and values, no heading, :mmm stamps, lux, button, "
        "temperature", GENEACTIV + rows(stamps("%Y-%m-%d %H:%M:%S:%L"), X, Y, Z, 12 + K % 7, 0, 24.6 + 0.1 * (K % 3)),
        Ask("columns|which|axes|heading", {"axes": ("2", "3", "4")}, plain())),
    case("gcdc_x16_counts",
        "gcdataconcepts.com, X16: semicolon comments, one of which holds the headings; counts of 1/2048 g",
        X16 + rows(fixed(T, 3), *COUNTS), acceleration(2048, "1", note="unit|count"), file="DATA-001.CSV"),
    case("endaq_ide_export", "endaq.com, enDAQ Lab CSV export: quoted headings with unit in brackets",
        table('"Time (s)","X (40g) (g)","Y (40g) (g)","Z (40g) (g)"', fixed(T, 6), X, Y, Z), RIGHT_G),
    case("slamstick_quoted_units", "endaq.com, Slam Stick X (ide2csv): µs before the headings X, Y, Z with unit",
        table('"Timestamp (µs)","X (100g) [g]","Y (100g) [g]","Z (100g) [g]"', 10000 * K, X, Y, Z), RIGHT_G),
    case("msr145", "msr.ch, MSR software CSV: preamble with stars, a row of channels and one of units",
        "*CREATOR\nMSR;5.12.04\n\n*STARTTIME\n2026-01-02;10:23:45;\n\n*MODUL\nMSR317025;\n\n*NAME\nMSR145;\n\n"
        "*CHANNEL\nTIME;ACC x;ACC y;ACC z;\n\n*UNIT\n;G;G;G;\n\n*DATA\n"
        + rows(stamps("%Y-%m-%d %H:%M:%S.%L"), X, Y, Z, sep=";", tail=";"), RIGHT_G, plain()),
    case("hobo", "onsetcomp.com, HOBOware: title line, #, date with zone, unit after a comma, columns of events",
        '"Plot Title: tool on slate"\n' + table(
        '"#","Date Time, GMT+01:00","X Accel, g (LGR S/N: 1000, SEN S/N: 1000)","Y Accel, g (LGR S/N: 1000, SEN '
        'S/N: 1000)","Z Accel, g (LGR S/N: 1000, SEN S/N: 1000)","Started (LGR S/N: 1000)","End Of File (LGR S/N: '
        '1000)"', *(1 + K, stamps("%m/%d/%y %I:%M:%S.%L %p"), X, Y, Z, "", "")), RIGHT_G),
    case("polar_sensor_logger",
        "Polar Sensor Logger: phone's stamps come in blocks, the sensor's in ns since 2000 do not", table(
        "Phone timestamp;sensor timestamp [ns];X [mg];Y [mg];Z [mg] ",
        [stamps("%Y-%m-%dT%H:%M:%S.%L")[k - k % 20] for k in K],
        *([599628000000000000 + int(k) * 10**7 for k in K], 1000 * X, 1000 * Y, 1000 * Z), sep=";"), RIGHT_G,
        file="Polar_H10_ACC.txt"),
    case("witmotion",
        "wit-motion.gitbook.io, recorded file: start time above, address column, unit in brackets without blank",
        "StartTime： 2026-01-02 10:23:45.000\n" + table("Address\tT"
        "ime(s)\tax(g)\tay(g)\taz(g)\twx(deg/s)\twy(deg/s)\twz(deg/s)\tAngleX(deg)\tAngleY(deg)\tAngleZ(deg)\tT(°)",
        *("0x50", stamps(" %H:%M:%S.%L"), X, Y, Z, SLOW, SLOW, SLOW, SLOW, SLOW, SLOW, 25.1), sep="\t"),
        acceleration(G, others={"angular_rate": "rad/s"}, left_out=["Address"]), file="20260102102345.txt"),
    case("opensignals",
        "support.pluxbiosignals.com, OpenSignals text: JSON in comments, nSeq wraps at 16, I1 of zeros",
        '# OpenSignals Text File Format\n# {"00:07:80:00:00:00": {"sensor": ["XYZ", "XYZ", "XYZ"], "column": '
        '["nSeq", "I1", '
        '"A1", "A2", "A3"], "sampling rate": 100, "resolution": [4, 1, 10, 10, 10]}}\n# EndOfHeader\n'
        + rows(K % 16, 0, *ANALOG, sep="\t", tail="\t"), measured(".*", "1", *ANALOG), Ask("columns|which|axes|rate",
        {"axes": ("3", "4", "5"), "rate": 100}, measured(".*", "1", *ANALOG, axes=None)), file="opensignals.txt"),
    case("openbci",
        "docs.openbci.com, recorded file: % comments with the rate, counter of 0 to 255, two clocks at the end",
        "%OpenBCI Raw EXG Data\n%Number of channels = 1\n%Sample Rate = 100 Hz\n%Board = "
        "OpenBCI_GUI$BoardCytonSerial\n" + table(
        "Sample Index, EXG Channel 0, Accel Channel 0, Accel Channel 1, Accel Channel 2, Timestamp, Timestamp "
        "(Formatted)", *((200 + K) % 256, 1000 * SLOW, X, Y, Z, fixed(EPOCH + T, 6), stamps("%Y-%m-%d %H:%M:%S.%L")),
        sep=", "), measured(
        "acceleration", "1", X, Y, Z, axes=None, note="unit", left_out=["Sample Index", "EXG Channel 0"]),
        file="OpenBCI-RAW.txt"),
)
