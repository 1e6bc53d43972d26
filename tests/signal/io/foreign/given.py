"""Files written for this project, a kind each; layouts are public, contents are not anybody's."""

from pathlib import Path
from typing import Any

# fmt: off
from tests.signal.io.foreign.case import PEAKS, Ask, Case, G, Refused, Right, acceleration, case, one, plain

FILES = Path(__file__).parent / "files"
X = (PEAKS["x"],)
COUNTS = {"x": 698.0, "y": 468.0, "z": 618.0}
BLE = Right("acceleration", "m/s^2", (G * PEAKS["x"],))


def lvm(**peaks: float) -> Right:
    return Right("acceleration", "m/s^2", peaks, rate=4000)


def given(path: str, *answers: Right | Ask | Refused, **options: Any) -> Case:
    name = "_".join([path.replace("/", "_").rsplit(".", 1)[0], *options])
    return case(f"given_{name}", path, (FILES / path).read_bytes(), *answers, file=Path(path).name, **options)


GIVEN = (
    given("csv_arduino_monitor/monitor.txt", plain()),
    given("csv_block_stamps/ble.csv", Ask("rate", {"rate": 100}, BLE)),
    given("csv_block_stamps/ble.csv", BLE, rate=100),
    given("csv_cut_off/log.csv", plain(note="last|cut")),
    given("csv_encodings/excel_de.csv", one("acceleration", "m/s^2")),
    given("csv_encodings/excel_ja.csv", one("acceleration", "m/s^2")),
    given("csv_encodings/excel_unicode.txt", one("acceleration", "m/s^2")),
    given("csv_epoch/ms.csv", plain("acceleration")),
    given("csv_epoch/ns.csv", plain("acceleration")),
    given("csv_gap/gap_2s.csv", Ask(
        "2 s|missing|gap|hole", {"part": 1}, Right("acceleration", "m/s^2", (G * PEAKS["x"],), samples=50))),
    given("csv_index_column/pandas.csv", plain()),
    given("csv_index_column/seq.csv", plain("acceleration", left_out=["seq"])),
    given("csv_mixed_imu/imu.csv", plain("acceleration", left_out=["gx", "temp"])),
    given("csv_ros_echo/imu.csv", Right("acceleration|linear_acceleration", "1", acceleration(G).peaks, note="unit")),
    given("csv_second_clock/sensorlog.csv", acceleration(G)),
    given("csv_time_by_unit/fr.csv", acceleration()),
    given("csv_time_by_unit/phyphox_ja.csv",
        Right("acceleration|linear_acceleration", "m/s^2", PEAKS, left_out=["絶対"])),
    given("csv_trailing_separator/counts.csv", Right("vibration", "1", COUNTS, note="unit|count"), rate=100),
    given("csv_unit_spellings/G.csv", acceleration(G)),
    given("csv_unit_spellings/gees.csv", one("acceleration", "m/s^2", G * PEAKS["x"])),
    given("csv_unit_spellings/mg.csv", acceleration(G)),
    given("csv_unit_spellings/msec.csv", one("acceleration", "m/s^2")),
    given("csv_unit_spellings/volts.csv", one("voltage", "V")),
    given("csv_units_row/scope.csv", one("voltage", "V")),
    given("csv_units_row/shimmer.csv", one("acceleration", "m/s^2", G * PEAKS["x"])),
    given("csv_units_row/units.csv", acceleration(G)),
    given("lvm_multi_x_units/one_axis.lvm", lvm(base=G, arm=1, tool=1)),
    given("lvm_multi_x_units/three.lvm", lvm(base=1, arm=1, tool=G)),
    given("npz_rate_array/rec.npz", plain()),
    given("npz_rate_array/acc.npy", plain(), rate=100),
)
