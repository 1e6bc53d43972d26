"""Preview of a folder's import, and the mapping that corrects it."""

import json
import tomllib

import numpy as np
import pytest
import soundfile

from tactogram.cli import main
from tactogram.datasets import open_store
from tactogram.datasets.mapping import read_mapping
from tactogram.datasets.preview import preview_file
from tactogram.errors import DataError, ParameterError
from tactogram.workflows.data.stores import import_store


def test_a_saved_mapping_changes_nothing_until_it_is_edited(source, tmp_path):
    plain = import_store("folder", source, preview=True, save_mapping=tmp_path / "m.toml")
    saved = tomllib.loads((tmp_path / "m.toml").read_text())["layout"]
    assert saved[0]["axes"] == {"x": "X-Axis (g)"}
    assert saved[0]["time"] == "Elapsed Time"
    mapped = import_store("folder", source, preview=True, mapping=tmp_path / "m.toml")
    alike = ("files", "skipped", "columns", "streams", "rates_hz", "seconds")
    assert [[x[key] for key in alike] for x in mapped["layouts"]] == [
        [x[key] for key in alike] for x in plain["layouts"]
    ]
    with pytest.raises(ParameterError, match="m.toml exists; remove it"):
        import_store("folder", source, preview=True, save_mapping=tmp_path / "m.toml")


def test_a_mapping_is_saved_with_all_that_it_said(source, tmp_path):
    (tmp_path / "m.toml").write_text(LAB + "rate = 250.0\n")
    import_store(
        "folder", source, preview=True, mapping=tmp_path / "m.toml", save_mapping=tmp_path / "n.toml"
    )
    [lab] = read_mapping(tmp_path / "m.toml").layout
    assert lab in read_mapping(tmp_path / "n.toml").layout


def write_table(path, heading, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([heading, *(",".join(map(str, row)) for row in rows)]) + "\n")


@pytest.fixture
def source(tmp_path):
    """Two tables of a logger with a gap, two of a laboratory, a sound, and a broken table."""
    wave = np.sin(np.arange(400))
    for number, material in enumerate(("cork", "felt")):
        rows = [[k / 100, f"{(number + 1) * v:.6f}", "ok"] for k, v in enumerate(wave)]
        rows[100][1] = ""
        write_table(tmp_path / "f" / material / "log.csv", "Elapsed Time,X-Axis (g),Note", rows)
        lab = [[2000 * k, f"{v:.6f}", k % (7 + number)] for k, v in enumerate(wave)]
        write_table(tmp_path / "f" / material / "lab.csv", "ticks,left,right", lab)
    write_table(tmp_path / "f" / "felt" / "broken.csv", "t [s],x [g]", [[0, 1], [0.1, "one"], [0.2, 3]])
    soundfile.write(tmp_path / "f" / "felt" / "a.wav", wave, 1000)
    return tmp_path / "f"


LAB = """
[[layout]]
columns = ["ticks", "left", "right"]
time = "ticks"
time_unit = "us"
unit = "g"
stream = "tap"
axes.x = "right"
axes.y = "left"
"""


def layouts_of(facts):
    return {layout["example"].rpartition("/")[2]: layout for layout in facts["layouts"]}


def test_what_each_column_is_read_as_is_shown(source):
    found = layouts_of(import_store("folder", source, preview=True))
    log = found["log.csv"]
    roles = {column["heading"]: (column["role"], column["unit"]) for column in log["columns"]}
    assert roles == {"Elapsed Time": ("time", "s"), "X-Axis (g)": ("x", "g"), "Note": ("ignored", None)}
    assert (log["files"], log["materials"], log["skipped"]) == (2, {"cork": 1, "felt": 1}, 0)
    assert log["streams"] == {"acceleration": {"unit": "m/s^2", "axes": ["x"]}}
    assert (log["rates_hz"], log["interpolated"], log["seconds"]) == ([100.0], 2, [4.0, 4.0])
    assert log["largest_gap_s"] == pytest.approx(0.02)
    assert (found["a.wav"]["columns"], found["a.wav"]["rates_hz"]) == ([], [1000.0])


def test_files_that_would_be_skipped_are_listed_with_their_columns(source):
    facts = import_store("folder", source, preview=True)
    assert [each["source"] for each in facts["skipped"]] == [
        "cork/lab.csv",
        "felt/broken.csv",
        "felt/lab.csv",
    ]
    assert "expected a number, got 'one'" in facts["skipped"][1]["reason"]
    found = layouts_of(facts)
    assert (found["lab.csv"]["files"], found["lab.csv"]["skipped"]) == (2, 2)
    assert [column["role"] for column in found["broken.csv"]["columns"]] == ["time", "x"]


def test_a_preview_is_what_the_import_does(source, tmp_path):
    facts = import_store("folder", source, preview=True)
    report = import_store("folder", source, tmp_path / "s", skip_bad=True)
    assert report["skipped"] == facts["skipped"]
    assert report["recordings"] == facts["files"] - len(facts["skipped"]) == 3


def test_a_mapping_decides_what_columns_hold(source, tmp_path):
    (tmp_path / "m.toml").write_text(LAB + '[[layout]]\ncolumns = ["none"]\n')
    facts = import_store("folder", source, preview=True, mapping=tmp_path / "m.toml")
    lab = layouts_of(facts)["lab.csv"]
    assert [column["role"] for column in lab["columns"]] == ["time", "y", "x"]
    assert (lab["mapped"], lab["rates_hz"], facts["unused_layouts"]) == (True, [500.0], [["none"]])
    import_store("folder", source, tmp_path / "s", mapping=tmp_path / "m.toml", skip_bad=True)
    store = open_store(tmp_path / "s")
    tap = store.signal(next(info.id for info in store.index if info.source == "cork/lab.csv"), "tap")
    np.testing.assert_allclose(tap.samples[0, :9], 9.80665 * (np.arange(9) % 7), rtol=1e-6)
    assert (tap.axes, tap.unit, tap.rate) == (("x", "y"), "m/s^2", 500.0)


def test_the_mapping_overrides_headings_and_states_a_rate(source, tmp_path):
    layout = 'columns = ["Elapsed Time", "X-Axis (g)", "Note"]\nunit = "m/s^2"\nrate = 200\naxes.w = "X-Axis (g)"\n'
    (tmp_path / "m.toml").write_text("[[layout]]\n" + layout + 'time = "Elapsed Time"\n')
    facts = import_store("folder", source, preview=True, mapping=tmp_path / "m.toml")
    log = layouts_of(facts)["log.csv"]
    assert (log["rates_hz"], log["streams"]["acceleration"]["axes"]) == ([200.0], ["w"])
    assert log["columns"][1]["unit"] == "m/s^2"


def test_layouts_of_the_same_table_are_streams(source, tmp_path):
    force = LAB.replace("tap", "force").replace('"g"', '"mN"').replace('axes.x = "right"\n', "")
    (tmp_path / "m.toml").write_text(LAB.replace('axes.y = "left"\n', "") + force)
    facts = import_store("folder", source, preview=True, mapping=tmp_path / "m.toml")
    lab = layouts_of(facts)["lab.csv"]
    assert [column["role"] for column in lab["columns"]] == ["time", "force: y", "tap: x"]
    assert {name: stream["unit"] for name, stream in lab["streams"].items()} == {"tap": "m/s^2", "force": "N"}
    import_store("folder", source, tmp_path / "s", mapping=tmp_path / "m.toml", skip_bad=True)
    store = open_store(tmp_path / "s")
    [cork] = [info.id for info in store.index if info.source == "cork/lab.csv"]
    wave = 1e-3 * np.sin(np.arange(400))
    np.testing.assert_allclose(store.signal(cork, "force").samples[0], wave, atol=1e-8)
    assert store.signal(cork, "tap").rate == store.signal(cork, "force").rate == 500.0


@pytest.mark.parametrize(
    ("material_from", "materials"),
    [
        ("folder", {"day 1": 3}),
        ("last_folder", {"cork": 2, "felt": 1}),
        ("file", {"P80": 1, "P80_fast": 1, "take(3)x": 1}),
        ("file_start", {"P80": 2, "take(3)x": 1}),
    ],
)
def test_the_material_is_named_by_folder_or_file(tmp_path, material_from, materials):
    for number, name in enumerate(["cork/P80_1", "cork/P80_fast-02", "felt/take(3)x"]):
        rows = [[k / 100, k % 7 + number] for k in range(99)]
        write_table(tmp_path / "f" / "day 1" / f"{name}.csv", "t [s],x [g]", rows)
    options = {"material_from": material_from}
    facts = import_store("folder", tmp_path / "f", preview=True, options=options)
    assert facts["layouts"][0]["materials"] == materials
    with pytest.raises(ParameterError, match="material_from must be one of folder, last_folder, file"):
        import_store("folder", tmp_path / "f", preview=True, options={"material_from": "colour"})


def test_one_file_is_previewed_as_it_is_imported(source, tmp_path):
    (tmp_path / "m.toml").write_text(LAB)
    options = {"mapping": read_mapping(tmp_path / "m.toml")}
    recording = preview_file("folder", source, "felt/lab.csv", options=options)
    import_store("folder", source, tmp_path / "s", mapping=tmp_path / "m.toml", skip_bad=True)
    assert recording.id in {info.id for info in open_store(tmp_path / "s").index}
    with pytest.raises(
        DataError, match="felt/broken.csv: row 3, column 'x .g.': expected a number, got 'one'"
    ):
        preview_file("folder", source, "felt/broken.csv")
    with pytest.raises(DataError, match="felt/gone.csv: no longer there"):
        preview_file("folder", source, "felt/gone.csv")


def test_the_command_previews_and_writes_nothing(source, tmp_path, capsys):
    before = sorted(tmp_path.rglob("*"))
    assert main(["data", "import", "folder", str(source), "--preview", "--json"]) == 1
    facts = json.loads(capsys.readouterr().out)
    assert facts == import_store("folder", source, preview=True)
    assert main(["data", "import", "folder", str(source), "--preview", "--skip-bad"]) == 0
    said = capsys.readouterr().out
    assert "  X-Axis (g)    x        g\n" in said
    assert "files: 6; photographs: 0; duplicates: 0; would be skipped: 3\n" in said
    assert sorted(tmp_path.rglob("*")) == before


def test_an_import_needs_out_or_preview(source, tmp_path, capsys):
    assert main(["data", "import", "folder", str(source)]) == 1
    assert "--out must be given; omit it only with --preview" in capsys.readouterr().err
    words = ["data", "import", "folder", str(source), "--out", str(tmp_path / "s"), "--save-mapping", "m"]
    assert main(words) == 1
    assert "--save-mapping must come with a preview; add --preview" in capsys.readouterr().err
