"""Instruments: oscilloscopes, logic analysers and their programs. `X` in V, 10 kHz unless a rate is said."""

# fmt: off
from tests.signal.io.foreign.case import Ask, K, N, Right, T, X, Y, case, fixed, measured, one, rows, table

RATE = 10_000
S = K / RATE
BEFORE = S - 0.002  # s, from before the trigger
VOLTS = one("voltage", "V", rate=RATE)
TWO_VOLTS = measured("voltage", "V", X, Y, axes=None, rate=RATE)
E_X, E_Y, E_S = ([f"{v:+.5E}" for v in values] for values in (X, Y, BEFORE))
TDS = ["Record Length,1.000000e+02", "Sample Interval,1.000000e-04", "Trigger Point,2.000000000000e+01", ",", ",",
    ","]
TDS += ["Source,CH1", "Vertical Units,V", "Vertical Scale,2.000000e-01", "Vertical Offset,0.000000e+00"]
TDS += ["Horizontal Units,s", "Horizontal Scale,1.000000e-03", "Pt Fmt,Y", "Yzero,0.000000e+00",
    "Probe Atten,1.000000e+00"]
TDS += ["Model Number,TDS2014", "Serial Number,C000000", "Firmware Version,FV:v22.01"]
WAVEFORMS = (
    "#Digilent WaveForms Oscilloscope Acquisition\n#Device Name: Discovery2\n#Serial Number: SN:210321A00000\n"
    "#Date Time: 2026-01-02 10:23:45.123.456.789\n#Sample rate: 10000Hz\n#Samples: 100\n"
    "#Trigger: Source: Channel 1 Type: Edge Condition: Rise Level: 0 V Hyst.: Auto HoldOff: 0 s\n"
    "#Channel 1: Range: 500 mV/div Offset: 0 V Attenuation: 1 X\n\n")
INFINIIUM = (
    "Revision:,0\nType:,raw\nStart:,0\nPoints:,100\nCount:,1\nXDispRange:,1.0E-02\nXDispOrg:,0.0\nXInc:,1.00000E-04\n"
    "XOrg:,-2.0E-03\nYData range:,2.0\nDate:,02 JAN 2026\nTime:,10:23:45:12\nFrame:,DSO9104A:MY00000000\nX Units:,"
    "second\n" "Y Units:,Volt\nData:\n")

INSTRUMENTS = (
    case("tektronix_tds_beside_preamble",
        "tek.com, TDS1000/2000 user manual: the preamble is in the first columns of the rows of data",
        "".join(f"{(TDS + [','] * N)[k]},,{BEFORE[k]:018.12f},{X[k]:.5f},\n" for k in K), VOLTS,
        Ask("columns|which|axes", {"time": "4 [s]", "axes": ("5",)}, VOLTS), file="F0000CH1.CSV"),
    case("tektronix_mso", "tek.com, MSO/DPO2000B: preamble of names and values, TIME,CH1,CH2",
        "Model,MSO2024B\nFirmware Version,1.52\n\nPoint Format,Y,\nHorizontal Units,S,\nHorizontal Scale,0.001,\n"
        "Sample Interval,0.0001,\nRecord Length,100,\nGating,0.0% to 100.0%,\nProbe Attenuation,1,1\n"
        "Vertical Units,V,V\nVertical Offset,0,0\nVertical Scale,0.2,0.2\nLabel,,\n"
        + table("TIME,CH1,CH2", E_S, E_X, E_Y), TWO_VOLTS, file="T0000ALL.CSV"),
    case("rigol_increment", "rigol.eu, DS1000Z manual: points numbered, unit and increment in the second row",
        "X,CH1,Start,Increment,\nSequence,Volt,-2.000000e-03,1.000000e-04\n" + rows(K, E_X, tail=","), VOLTS),
    case("rigol_inline_increment",
        "rigol.eu, MSO5000 and DHO manuals: unit behind the channel, start and increment among the headings",
        "CH1V,CH2V,t0 =-2.000000e-03, tInc = 1.000000e-04,\n" + rows(E_X, E_Y, tail=",,"), TWO_VOLTS,
        measured("voltage|vibration", "1", X, Y, axes=None, rate=RATE, note="unit"),
        Ask("rate", {"rate": RATE, "unit": "V"}, TWO_VOLTS)),
    case("rigol_screen", "rigol.eu, the same with the time: CH1V is CH1 in V",
        table("Time(s),CH1V,CH2V", E_S, E_X, E_Y), TWO_VOLTS,
        measured("voltage|vibration", "1", X, Y, axes=None, rate=RATE, note="unit")),
    case("siglent_two_channels", "siglenteu.com, older SDS and ADS: a blank line, Second,Volt,Volt",
        "Record Length,100,,\nSample Interval,CH1:0.0001 CH2:0.0001,,\nVertical Units,CH1:V CH2:V,,\nHorizontal "
        "Units,s,,\n" "Model Number,ADS1202CL+,,\n\nSource,CH1,CH2\nSecond,Volt,Volt\n" + rows(E_S, E_X, E_Y),
        TWO_VOLTS),
    case("keysight_infiniivision", "keysight.com, InfiniiVision X series: x-axis,1 above second,Volt",
        "x-axis,1,2\nsecond,Volt,Volt\n" + rows(E_S, E_X, E_Y), TWO_VOLTS),
    case("keysight_infiniium_values_only", "keysight.com, Infiniium: values below a preamble with XInc, no time",
        INFINIIUM + rows(E_X), VOLTS, Ask("rate", {"rate": RATE, "unit": "V"}, VOLTS)),
    case("siglent", "siglenteu.com, SDS1000X-E: preamble of names and values, Second,Value",
        "Record Length,Analog:100,\nSample Interval,1.000000E-04,\nVertical Units,V,\nVertical Scale,2.00E-01,\n"
        "Vertical Offset,0.00E+00,\nHorizontal Units,s,\nHorizontal Scale,1.00E-03,\nModel Number,SDS1104X-E,\n"
        "Serial Number,SDS0000000000,\nSoftware Version,8.1.6,\nSource,CH1,\n" + table("Second,Value", E_S, E_X),
        VOLTS, one("vibration|voltage", "1", rate=RATE, note="unit")),
    case("lecroy", "teledynelecroy.com, WaveRunner ASCII: three rows of semicolon or comma cells, then Time,Ampl",
        "LECROYWR625Zi,61392,Waveform\nSegments,1,SegmentSize,100\nSegment,TrigTime,TimeSinceSegment1\n"
        "#1,02-Jan-2026 10:23:45,0                 \n" + table("Time,Ampl", E_S, E_X),
        one("vibration|voltage", "1", rate=RATE, note="unit"), VOLTS, file="C1Trace00000.txt"),
    case("picoscope_two_units",
        "picotech.com, PicoScope 6/7 CSV: units in a row of brackets, one channel in V, one in mV, blank line",
        "Time,Channel A,Channel B\n(ms),(V),(mV)\n\n" + rows(1000 * S, X, 1000 * Y), TWO_VOLTS),
    case("picoscope_overrange", "picotech.com, PicoScope: infinity signs for samples out of range",
        "Time,Channel A\n(s),(V)\n\n"
        + rows(fixed(T, 8), ["∞" if k == 50 else "-∞" if k == 51 else f"{X[k]:.8f}" for k in K]),
        Right("voltage", "V", one("", "").peaks),
        Ask("row 5[0-9]|∞|range", {"part": 1}, Right("voltage", "V", one("", "").peaks, samples=50))),
    case("saleae_analog", "support.saleae.com, Logic 2 raw data export: Time [s],Channel 0",
        table("Time [s],Channel 0,Channel 1", fixed(S, 9), X, Y),
        measured("voltage|vibration", "1", X, Y, axes=None, rate=RATE, note="unit"), TWO_VOLTS, file="analog.csv"),
    case("digilent_waveforms", "digilent.com, WaveForms: # comments with the rate, Time (s),Channel 1 (V)",
        WAVEFORMS + table("Time (s),Channel 1 (V),Channel 2 (V)", fixed(BEFORE, 6), X, Y), TWO_VOLTS),
    case("hantek_six_columns",
        "github.com/phmarek/hantek-dso2000: number, time, volts, and raw counts of the same channels", table(
        "nr,time,ch1,ch2,ch1s,ch2s", K, S, fixed(X, 3), fixed(Y, 3), [round(48 * v) for v in X],
        [round(48 * v) for v in Y]), Ask("ch1|which|axes", {"axes": ("ch1", "ch2")},
        measured("voltage|vibration", "1", X, Y, axes=None, rate=RATE)),
        measured("voltage|vibration", "1", X, Y, axes=None, rate=RATE, left_out=["ch1s", "nr"]), Right(
        "voltage|vibration", "1", (*measured("", "", X, Y, axes=None).peaks, 23, 12), rate=RATE, note="unit")),
    case("yokogawa_headers_quoted", 'yokogawa.com, DL series ASCII: "Name " and value, "HResolution" is the interval',
        '"Model Name ","DL850E"\n"BlockNumber ",1\n"TraceName ","CH1"\n"BlockSize ",100\n"VUnit ","V"\n'
        '"SampleRate ",10000\n"HResolution ",1.0E-04\n"HUnit ","s"\n"Date ","2026/01/02"\n"Time ",'
        '"10:23:45.12345678"\n' + rows(E_X, tail=","), VOLTS, one("vibration|voltage", "1", rate=RATE, note="unit")),
    case("lab_amplifier_percent",
        "lionprecision.com and other capacitive or laser probes: position in µm beside the output in V",
        table("Time (s);Output (V);Displacement (µm)", S, 0.1 * X, 100 * X, sep=";", decimal=","),
        Right("position", "m", (1e-4 * one("", "").peaks[0],), rate=RATE, others={"voltage": "V"}),
        Right("voltage", "V", (0.1 * one("", "").peaks[0],), rate=RATE, others={"position": "m"})),
)
