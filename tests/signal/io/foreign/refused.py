"""Tables that must not be read as they are: gaps, restarts, notes, and no rate."""

# fmt: off
# isort: off
from tests.signal.io.foreign.case import (
    Ask, G, K, Refused, Right, T, X, Y, Z, acceleration, case, fixed, plain, rows, table,
)
# isort: on

HEADING = "time [s],x [g],y [g],z [g]\n"
ROWS = rows(fixed(T, 2), X, Y, Z).splitlines(keepends=True)
LATER = rows(fixed(T + 2.0, 2), X, Y, Z).splitlines(keepends=True)
PART = acceleration(G)
NOTES = "participant,material,rating,remark\nP01,cork,5,rough\nP01,denim,3,\nP02,cork,4,a bit warm\n"

REFUSED = (
    case("gap_of_two_seconds", "wireless loggers: out of reach for 2 s",
        HEADING + "".join(ROWS) + "".join(rows(fixed(T + 3.0, 2), X, Y, Z)),
        Ask("without samples|gap|hole|missing", {"part": 1}, PART)),
    case("restarted_in_the_middle", "loggers that append to a file: time begins again",
        HEADING + "".join(ROWS) + HEADING + "".join(ROWS), Ask("back|again|restart", {"part": 2}, PART)),
    case("two_tables_in_one_file", "exports of several takes one below the other, with a title each",
        "Take 1\n" + HEADING + "".join(ROWS) + "\nTake 2\n" + HEADING + "".join(LATER),
        Ask("back|again|without samples|part|row|table", {"part": 1}, PART)),
    case("no_time_no_rate", "three columns of numbers and nothing else", table("ax,ay,az", X, Y, Z),
        Ask("rate", {"rate": 100}, plain("acceleration"))),
    case("notes", "a table of notes or ratings", NOTES, Refused("no |number|sample|column|rate")),
    case("prose", "a text file beside the data",
        "Recorded on 2 January 2026 in room 12.\nThe tool slid over cork, 40 mm/s.\n",
        Refused("no |number|table|column|row"), file="readme.txt"),
    case("empty", "a logger that was switched off at once", b"", Refused("empty|no ")),
    case("heading_only", "a logger that was switched off at once", HEADING, Refused("no |empty|row")),
    case("spectrum", "analysers: frequency and amplitude are no recording",
        table("Frequency (Hz),Amplitude (g)", 10 * K, [abs(v) for v in X]), Refused("Frequency|time|rate|Hz")),
    case("spectrum_with_rate", "analysers: frequency is no axis, whatever is given",
        table("Frequency (Hz),Amplitude (g)", 10 * K, [abs(v) for v in X]), Refused("Frequency|Hz"),
        Right("acceleration", "m/s^2", (G * max(abs(X)),), left_out=["Frequency"]), rate=100),
    case("one_row", "a single sample has no rate", HEADING + ROWS[0], Refused("row|sample|rate|one|two")),
    case("binary_with_csv_suffix", "a workbook that was renamed", b"PK\x03\x04" + bytes(range(256)) * 8,
        Refused("xlsx|binary|text|zip|table|encod|number|NUL")),
)
