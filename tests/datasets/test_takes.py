"""Files of one take become streams of one recording, and holes divide it."""

import numpy as np
import pytest
import soundfile

from tactogram.cli import main
from tactogram.datasets import open_store
from tactogram.datasets.mapping import read_mapping
from tactogram.datasets.takes import takes
from tactogram.errors import DataError
from tactogram.workflows.data.stores import import_store

SENSORS = {"Accelerometer": "acceleration", "Gravity": "gravity", "Gyroscope": "angular_rate"}


@pytest.mark.parametrize(
    ("files", "found"),
    [
        (
            [f"cork/d/{name}.csv" for name in SENSORS],
            [("cork/d", list(SENSORS.values()))],
        ),
        (
            ["c/t1_acc.csv", "c/t1_force.csv", "c/t1_speed.csv", "c/t2_acc.csv", "c/t2_force.csv"],
            [("c/t1", ["acceleration", "force", "speed"]), ("c/t2", ["acceleration", "force"])],
        ),
        (["c/force_t1.csv", "c/acc_t1.csv"], [("c/t1", ["acceleration", "force"])]),
        (["c/01-acc.txt", "c/01-gyro.txt"], [("c/01", ["acceleration", "angular_rate"])]),
        (["c/acc1.csv", "c/force1.csv"], [("c/1", ["acceleration", "force"])]),
        (["c/1_linear_acc.csv", "c/1_gravity.csv"], [("c/1", ["linear_acceleration", "gravity"])]),
        (["accel/a/1.csv", "force/a/1.csv"], [("a/1", ["acceleration", "force"])]),
        (["c/1.csv", "c/1.wav"], [("c/1", [None, "sound"])]),
        (["c/1_acc.csv", "c/1.wav"], [("c/1", ["acceleration", "sound"])]),
        (["c/1.csv", "c/2.csv"], [("c/1", [None]), ("c/2", [None])]),
        (["c/acc.csv", "c/acc.mat"], [("c/acc", ["acceleration"]), ("c/acc", ["acceleration"])]),
        (["c/force_1.csv", "d/force_1.csv"], [("c/force_1", [None]), ("d/force_1", [None])]),
    ],
)
def test_the_files_of_a_take_are_found_by_their_names(files, found):
    assert [(take.name, [stream for _, stream in take.files]) for take in takes(files)] == found


def write_table(path, heading, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([heading, *(",".join(map(str, row)) for row in rows)]) + "\n")


def ramp(count, *, missing=(0, 0), step=0.01):
    return [[f"{step * k:.3f}", k] for k in range(count) if not missing[0] <= k < missing[1]]


def test_a_phones_files_are_one_recording_per_take(tmp_path, capsys):
    for place, (name, material) in enumerate((n, m) for n in SENSORS for m in ("cork", "tin")):
        rows = [[k * 10_000_000, f"{k / 100:.2f}", k % (7 + place), k % 5, k % 3] for k in range(100)]
        take = tmp_path / "f" / material / "2026-01-02_10-23-45"
        write_table(take / f"{name}.csv", "time,seconds_elapsed,z,y,x", rows)
        write_table(take / "Annotation.csv", "time,text", [[0, "begin"]])
    words = ["data", "import", "folder", str(tmp_path / "f"), "--set", "unit=m/s^2"]
    assert main([*words, "--out", str(tmp_path / "s")]) == 0
    store = open_store(tmp_path / "s")
    assert [info.material for info in store.index] == ["cork", "tin"]
    assert {name: stream.unit for name, stream in store.streams.items()} == {
        "acceleration": "m/s^2",
        "gravity": "m/s^2",
        "angular_rate": "1",
    }
    said = capsys.readouterr().out
    assert "note: no signals, not read: Annotation.csv (2 files)\n" in said
    assert "note: 2 files: no unit stated for angular_rate" in said


def test_a_stated_unit_of_1_is_a_unit(tmp_path, capsys):
    write_table(tmp_path / "f" / "cork" / "1.csv", "t [s],ch1,ch2", ramp(100))
    for stated, says in (([], True), (["--set", "unit=1"], False)):
        main(["data", "import", "folder", str(tmp_path / "f"), "--preview", *stated])
        assert ("no unit stated" in capsys.readouterr().out) is says


def test_folders_of_quantities_are_no_materials(tmp_path, capsys):
    for name in ("cork_1", "tin_1"):
        write_table(tmp_path / "f" / "acc" / f"{name}.csv", "t [s],x [g]", ramp(100 + len(name)))
        write_table(tmp_path / "f" / "force" / f"{name}.csv", "t [s],f [N]", ramp(100 + len(name)))
    words = ["data", "import", "folder", str(tmp_path / "f"), "--out", str(tmp_path / "s")]
    assert main(words) == 1
    assert "no folder names the material; state it with `" in capsys.readouterr().err
    assert main([*words, "--set", "path={material}_{take}"]) == 0
    store = open_store(tmp_path / "s")
    assert [info.material for info in store.index] == ["cork", "tin"]
    assert set(store.streams) == {"acceleration", "force"}


def test_a_sound_beside_a_table_is_a_stream_of_it(tmp_path):
    write_table(tmp_path / "f" / "cork" / "1.csv", "t [s],x [g]", ramp(100))
    soundfile.write(tmp_path / "f" / "cork" / "1.wav", np.sin(np.arange(800)) / 2, 8000)
    import_store("folder", tmp_path / "f", tmp_path / "s")
    [info] = open_store(tmp_path / "s").index
    assert set(open_store(tmp_path / "s").streams_of(info.id)) == {"acceleration", "sound"}


def test_a_name_that_contradicts_the_unit_gives_way_and_is_noted(tmp_path):
    write_table(tmp_path / "f" / "cork" / "1_acc.csv", "t [s],x [g]", ramp(100))
    write_table(tmp_path / "f" / "cork" / "1_force.csv", "t [s],x [mm]", ramp(100))
    report = import_store("folder", tmp_path / "f", tmp_path / "s")
    assert [note["text"] for note in report["notes"]] == ["1_force.csv: read as position, for its unit is m"]
    write_table(tmp_path / "f" / "cork" / "1_speed.csv", "t [s],x [mm]", ramp(100))
    with pytest.raises(DataError, match="1_speed.csv: position is in another file of the same take, too"):
        import_store("folder", tmp_path / "f", tmp_path / "t")


def test_a_mapping_of_the_files_of_a_take_is_one_of_each_file(tmp_path):
    write_table(
        tmp_path / "f" / "cork" / "1_acc.csv", "t [s],x [g],y [g]", [[t, k, 2 * k] for t, k in ramp(100)]
    )
    write_table(tmp_path / "f" / "cork" / "1_force.csv", "t [s],f [mN]", ramp(100))
    plain = import_store("folder", tmp_path / "f", preview=True, save_mapping=tmp_path / "m.toml")
    found = [(layout.columns, layout.stream) for layout in read_mapping(tmp_path / "m.toml").layout]
    assert found == [(("t [s]", "x [g]", "y [g]"), "acceleration"), (("t [s]", "f [mN]"), "force")]
    mapped = import_store("folder", tmp_path / "f", preview=True, mapping=tmp_path / "m.toml")
    assert mapped["layouts"][0]["streams"] == plain["layouts"][0]["streams"]
