"""Laboratories: data acquisition, force sensors, physiology, teaching, and the files of texture recordings."""

import numpy as np

# fmt: off
# isort: off
from tests.signal.io.foreign.case import (
    EPOCH,
    PEAKS,
    SLOW,
    Ask,
    G,
    K,
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
    stamps,
    table,
)
# isort: on

RATE = 1000
S = K / RATE
FORCE = measured("force", "N", X, Y, Z)
RIGHT_G = acceleration(G)
LABCHART = ("Interval=\t0.001 s\nExcelDateTime=\t4.6024433159722222e+04\t02/01/2026 "
    "10:23:45.000000\nTimeFormat=\tStartOfBlock\n"
    "DateFormat=\t\nChannelTitle=\tForce\tAcceleration\nRange=\t10.000 V\t5.000 V\nUnitName=\tN\tg\n")
CATMAN = ("catmanEasy AP\t\r\nDATEI\ttake1.asc\r\nStart: 02.01.2026 10:23:45\t\r\nMessfrequenz: 1000 Hz\t\r\n"
    "Zeit  1 - Standardmessrate [s]\tKraft x [N]\tKraft y [N]\tKraft z [N]\r\n")
LVM = "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t,\n"
LVM += "Multi_Headings\tNo\nX_Columns\tOne\nTime_Pref\tRelative\nOperator\tlab\nDate\t2026/01/02\nTime\t10:23:45,0\n"
LVM += "***End_of_Header***\t\n\t\nChannels\t3\t\t\t\t\nSamples\t100\t100\t100\t\n"
LVM += "Date\t2026/01/02\t2026/01/02\t2026/01/02\t\nTime\t10:23:45\t10:23:45\t10:23:45\t\n"
LVM += "Y_Unit_Label\tg\tg\tg\t\nX_Dimension\tTime\tTime\tTime\t\n"
LVM += "X0\t0,0E+0\t0,0E+0\t0,0E+0\t\nDelta_X\t0,001000\t0,001000\t0,001000\t\n***End_of_Header***\t\t\t\t\n"

LABORATORY = (
    case("labview_lvm_no_x", "ni.com, the same: X_Columns No, the time is X0 and Delta_X, the first column empty",
        LVM.replace("X_Columns\tOne", "X_Columns\tNo") + "X_Value\tAccX\tAccY\tAccZ\tComment\n"
        + rows("", fixed(X, 6), fixed(Y, 6), fixed(Z, 6), sep="\t", decimal=",", tail="\t"),
        acceleration(G, rate=RATE), file="take.lvm"),
    case("labview_lvm_one_x",
        "ni.com, specification of the LabVIEW measurement file: X_Columns One, decimal comma, a Comment column", LVM
        + "X_Value\tAccX\tAccY\tAccZ\tComment\n"
        + rows(fixed(S, 6), fixed(X, 6), fixed(Y, 6), fixed(Z, 6), sep="\t", decimal=",", tail="\t"),
        acceleration(G, rate=RATE), file="take.lvm"),
    case("labview_spreadsheet", "ni.com, Write Delimited Spreadsheet: three decimals, tabs, no heading",
        rows(fixed(X, 3), fixed(Y, 3), fixed(Z, 3), sep="\t", end="\r\n"),
        Ask("rate", {"rate": RATE}, plain(rate=RATE)), file="data.txt"),
    case("signalexpress",
        "ni.com, SignalExpress and DAQExpress text export: channel names of devices, seconds in a row of stamps",
        "channel names: \nDev1_ai0\tDev1_ai1\tDev1_ai2\nstart times:\n02/01/2026 10:23:45,000000\t02/01/2026 "
        "10:23:45,000000\t" "02/01/2026 10:23:45,000000\ndt:\n0,001000\t0,001000\t0,001000\ndata:\n"
        + rows(X, Y, Z, sep="\t", decimal=","), measured(".*", "1", X, Y, Z, axes=None, rate=RATE, note="unit"),
        Ask("rate", {"rate": RATE}, measured(".*", "1", X, Y, Z, axes=None, rate=RATE)), file="export.txt"),
    case("diadem_csv", "ni.com, DIAdem CSV export: a row of names, one of units, one of lengths or types",
        "Time;Acc_X;Acc_Y;Acc_Z\ns;m/s²;m/s²;m/s²\n" + rows(fixed(S, 4), X, Y, Z, sep=";", decimal=","),
        acceleration(rate=RATE), encoding="cp1252"),
    case("catman_ascii",
        "hbm.com, catman ASCII export: German preamble, rate in Hz, channel and unit in brackets, cp1252",
        CATMAN + rows(fixed(S, 4), X, Y, Z, sep="\t", decimal=",", end="\r\n"),
        measured("force", "N", X, Y, Z, rate=RATE), encoding="cp1252", file="take1.asc"),
    case("imc_famos_ascii",
        "imc-tm.com, FAMOS and imc STUDIO ASCII export: time in the first column, names above, units below in quotes",
        table('"Zeit"\t"Beschl_x"\t"Beschl_y"\t"Beschl_z"\n"s"\t"m/s²"\t"m/s²"\t"m/s²"', fixed(S, 4), X, Y, Z,
        sep="\t", decimal=","), acceleration(rate=RATE), encoding="cp1252", file="imc.txt"),
    case("bruel_kjaer_pulse", "bksv.com, PULSE LabShop ASCII: index, time and values, preamble with delta",
        'Header Size:\t8\nVersion:\t15\n"Title1:\tTime"\nX-Axis unit:\ts\nY-Axis unit:\tm/s²\nX-Axis first '
        "value:\t0\n" "X-Axis delta:\t0.001\nZ-Axis size:\t1\n" + rows(1 + K, S, X, sep="\t"),
        one("acceleration", "m/s^2", rate=RATE), one("vibration|acceleration", "1", rate=RATE, note="unit"),
        encoding="cp1252", file="pulse.txt"),
    case("kistler_bioware",
        "kistler.com, BioWare text export: Ax and Ay are the centre of pressure in m, |Ft| is the magnitude",
        "\t\nforce plate\t\nacquisition rate\t1000\n\n" + table(
        "abs time (s)\tFx\tFy\tFz\t|Ft|\tAx\tAy\n\tN\tN\tN\tN\tm\tm", S, X, Y, Z, 1 + X * X, 0.1 * SLOW, 0.1 * SLOW,
        sep="\t"), measured("force", "N", X, Y, Z, rate=RATE, left_out=["|Ft|"]), file="bioware.txt"),
    case("charge_amplifier", "kistler.com and pcb.com, charge output: pC is no unit of a signal",
        table("Time (s),Charge (pC)", T, X), Ask("pC|unit", {"axes": ("Charge",), "unit": "1"}, one(".*", "1")),
        one(".*", "1", note="pC")),
    case("ati_force_torque",
        "ati-ia.com, Net F/T demo data collection: units in the preamble, status, two sequences, time with AM",
        "Start Time:, 01/02/2026 10:23:45 AM\nRDT Sample Rate:, 100\nForce Units:, N\nCounts per Unit Force:, "
        "1\nTorque Units:, " "Nm\nCounts per Unit Torque:, 1\n" + table(
        "Status (hex), RDT Sequence, F/T Sequence, Fx, Fy, Fz, Tx, Ty, Tz, Time", "0x0", 1 + K, 800 + K, X, Y, Z,
        SLOW, SLOW, SLOW, stamps("%I:%M:%S.%f %p"), sep=", "), measured(
        "force", "1", X, Y, Z, note="unit", absent=["position"], left_out=["Status", "RDT Sequence", "Tx"]),
        measured("force", "N", X, Y, Z, absent=["position"], left_out=["Status", "RDT Sequence"])),
    case("optoforce", "onrobot.com, OptoForce data visualisation: sensor number and ms, counts", table(
        "Time [ms];S1 Fx;S1 Fy;S1 Fz;S1 Status", 10 * K, *([round(1000 * v) for v in c] for c in (X, Y, Z)), 0,
        sep=";"), measured("force", "1", 1000 * X, 1000 * Y, 1000 * Z, note="unit", left_out=["Status"])),
    case("load_cell_grams", "public HX711 sketches: milliseconds and grams of a scale",
        table("ms,weight_g", 10 * K, 100 * X), one("force", "N", 0.1 * G * PEAKS["x"]),
        one("force|vibration", "1", 100 * PEAKS["x"], note="unit|gram"),
        Ask("gram|weight|unit", {"unit": "gf"}, one("force", "N", 0.1 * G * PEAKS["x"]))),
    case("force_and_acceleration_with_speed",
        "haptic texture recordings at 1 kHz: position, force and acceleration of a tool in one table", table(
        "t,x_mm,y_mm,z_mm,Fx_N,Fy_N,Fz_N,acc_x_g,acc_y_g,acc_z_g,speed_mm_s", *(fixed(S, 4), 10 * SLOW, 5 * SLOW,
        0.1 * SLOW, 0.1 * SLOW, 0.2 * SLOW, 1 + SLOW, X, Y, Z, 40 + SLOW)),
        acceleration(G, rate=RATE, others={"force": "N", "position": "m", "velocity": "m/s"})),
    case("texture_without_units", "haptic texture recordings: x,y,z,Fx,Fy,Fz,acc without units or time",
        table("x,y,z,Fx,Fy,Fz,acc", 10 * SLOW, 5 * SLOW, SLOW, 0.1 * SLOW, 0.2 * SLOW, 1 + SLOW, X),
        Ask("rate", {"rate": 10_000}, one("acceleration", "1", rate=10_000, note="unit", left_out=["Fx"])),
        file="ABSPlastic.csv"),
    case("vernier_latest", "vernier.com, Logger Pro and Graphical Analysis CSV: Latest: before each name", table(
        '"Latest: Time (s)","Latest: X Acceleration (m/s²)","Latest: Y Acceleration (m/s²)","Latest: Z '
        'Acceleration (m/s²)"', T, X, Y, Z), acceleration()),
    case("pasco_run",
        "pasco.com, Capstone CSV: Run #1 behind the unit, force and position side by side, comma decimals", table(
        "Time (s) Run #1;Force (N) Run #1;Position (m) Run #1;Velocity (m/s) Run #1", fixed(T, 4), X, 0.1 * SLOW,
        SLOW, sep=";", decimal=","), one("force", "N", others={"position": "m", "velocity": "m/s"}),
        encoding="utf-8-sig"),
    case("labchart",
        "adinstruments.com, LabChart text export: Interval=, ChannelTitle=, UnitName=, comments at the end of lines",
        LABCHART + "".join(f"{S[k]:g}\t{X[k]:.6f}\t{Y[k]:.6f}{chr(9) + '#* touch' if k == 40 else ''}\n" for k in K),
        Right("force", "N", (PEAKS["x"],), rate=RATE, others={"acceleration": "m/s^2"}),
        Right("acceleration", "m/s^2", (G * PEAKS["y"],), rate=RATE, others={"force": "N"}),
        Ask("columns|which|unit|axes", {"axes": ("2",), "rate": RATE}, one(".*", "1", rate=RATE)),
        encoding="cp1252", file="labchart.txt"),
    case("biopac_acqknowledge",
        "biopac.com, AcqKnowledge text export: interval, names and units in turns, a row of CH1, a row of counts",
        "tool.acq\n1 msec/sample\n2 channels\nAcceleration, AMI100D\nm/s²\nForce\nN\nmilliSec,CH1,CH2,\n,100,100,\n"
        + rows(K, X, Y, tail=","), Right("acceleration", "m/s^2", (PEAKS["x"],), rate=RATE, others={"force": "N"}),
        measured("vibration|voltage", "1", X, Y, axes=None, rate=RATE, note="unit"), encoding="cp1252",
        file="biopac.txt"),
    case("delsys_trigno",
        "delsys.com, EMGworks file utility: X[s] before each channel, two rates, the slower channels padded",
        "X[s],Trigno IM sensor 1: EMG 1 [Volts],X[s],Trigno IM sensor 1: Acc 1.X (IM) [g],X[s],"
        "Trigno IM sensor 1: Acc 1.Y (IM) [g],X[s],Trigno IM sensor 1: Acc 1.Z (IM) [g]\n" + "".join(
        f"{k / 200:.4f},{1e-4 * np.sin(k):.8f},"
        + (",".join(f"{T[k]:.4f},{c[k]:.6f}" for c in (X, Y, Z)) if k < 100 else ",,,,,") + "\n" for k in range(200)),
        Right("acceleration", "m/s^2", RIGHT_G.peaks, others={"voltage": "V"}),
        Right("voltage", "V", (1e-4,), rate=200, samples=200, others={"acceleration": "m/s^2"})),
    case("noraxon", "noraxon.com, MR3 CSV export: seconds, then names with the unit after a comma, milli-g",
        "Name,take 1\nType,MR3\nFrequency,100\nStart,2026-01-02 10:23:45\n\n" + table(
        '"Time,s","Activity","Accel Sensor 1 Ax,mG","Accel Sensor 1 Ay,mG","Accel Sensor 1 Az,mG"', fixed(T, 4),
        "rubbing", 1000 * X, 1000 * Y, 1000 * Z), acceleration(G, left_out=["Activity"])),
    case("vicon_nexus_devices",
        "docs.vicon.com, Nexus ASCII: section, rate, groups, names, units, Frame and Sub Frame, CoP",
        "Devices\n1000\n,,Kistler - Force,,,Kistler - Moment,,,Kistler - CoP,,,\nFrame,Sub Frame,Fx,Fy,Fz,Mx,My,Mz,"
        "Cx,Cy,Cz\n" ",,N,N,N,mm.N,mm.N,mm.N,mm,mm,mm\n"
        + rows(1 + K // 10, K % 10, X, Y, Z, SLOW, SLOW, SLOW, SLOW, SLOW, 0.0),
        measured("force", "N", X, Y, Z, rate=RATE, left_out=["Frame", "Mx"]),
        Ask("rate", {"rate": RATE}, measured("force", "N", X, Y, Z, rate=RATE, left_out=["Frame", "Mx"]))),
    case("optitrack_group_rows",
        "docs.optitrack.com, Motive CSV: preamble in one row, rows of type, name, id and quantity above the axes",
        "Format Version,1.23,Take Name,slide 1,Capture Frame Rate,100.000000,Export Frame Rate,100.000000,Rotation "
        "Type," "Quaternion,Length Units,Meters,Coordinate Space,Global\n\n,,Marker,Marker,Marker\n,,tool:1,tool:1,"
        "tool:1\n,,a1,a1,a1\n"
        ",,Position,Position,Position\n" + table("Frame,Time (Seconds),X,Y,Z", K, fixed(T, 6), X, Y, Z),
        measured("position", "1", X, Y, Z, note="unit"), measured("position", "m", X, Y, Z)),
    case("mobile_tribometer", "anton-paar.com, tribometer text: time, distance, friction coefficient, forces", table(
        "Time [s]\tDistance [m]\tCOF [-]\tFn [N]\tFt [N]", fixed(T, 3), 0.01 * K, 0.5 + 0.2 * SLOW, 1 + 0.1 * Y, X,
        sep="\t"), Right("force", "N", (1 + 0.1 * PEAKS["y"], PEAKS["x"]), others={"friction": "1"}),
        Right("friction", "1", (0.7,), others={"force": "N"}), file="track1.txt"),
    case("motion_tracker_stylus",
        "3D Systems Touch and Geomagic samples: position in mm, velocity, button, servo time", table(
        "time_s posX[mm] posY[mm] posZ[mm] velX[mm/s] velY[mm/s] velZ[mm/s] button",
        *(fixed(S, 3), 1000 * X, 1000 * Y, 1000 * Z, SLOW, SLOW, SLOW, 0), sep=" "),
        measured("position", "m", X, Y, Z, rate=RATE, others={"velocity": "m/s"}, left_out=["button"]), measured(
        "velocity", "m/s", *[1e-3 * SLOW] * 3, rate=RATE, others={"position": "m"}, left_out=["button"]),
        file="stylus.dat"),
    case("lsl_to_csv",
        "labstreaminglayer.org, scripts on pyxdf: LSL time stamps, channel labels with the unit, marker column of "
        "text", table("lsl_timestamp,AccX (g),AccY (g),AccZ (g),marker",
        *(fixed(302342.123 + T, 6), X, Y, Z, ["start" if k == 3 else "" for k in K])),
        acceleration(G, left_out=["marker"])),
    case("two_epochs", "wearable study exports: server time and device time beside each other, both since 1970",
        table("server_time,device_time_ms,user_id,accX,accY,accZ,label", *(fixed(EPOCH + T + 0.003 * (K % 3), 3),
        [EPOCH * 1000 + 10 * int(k) for k in K], 17, X, Y, Z, "cork")),
        plain("acceleration", left_out=["user_id", "label"])),
)
