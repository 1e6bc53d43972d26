"""Mapping files: saved, edited and refused."""

import tomllib

import numpy as np
import pytest
import soundfile

from tactogram.datasets.mapping import read_mapping
from tactogram.errors import ParameterError
from tactogram.workflows.data.stores import import_store


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


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"us"', '"fortnights"', "layout.0: time_unit must be s, ms, us or ns, got 'fortnights'"),
        ('time = "ticks"', 'time = "tick"', "time must be one of the columns ticks, left, right, got 'tick'"),
        ('"right"\n', '"left"\n', "a column must be used once, got left, left, ticks"),
        ('"g"', '"furlong"', "unit must be one of m/s.2, .* got 'furlong'"),
        ("stream", "streem", "unknown key 'layout.0.streem'; known here: axes, columns, material"),
        ('unit = "g"', "rate = -4", "layout.0.rate: must be greater than .* got -4"),
        ("[[layout]]", "[layout]", "layout: must be a list"),
        (LAB, LAB + LAB, "two layouts have the columns ticks, left, right; keep one of them, or name"),
    ],
)
def test_a_wrong_mapping_is_refused_in_one_line(tmp_path, old, new, says):
    (tmp_path / "m.toml").write_text(LAB.replace(old, new))
    with pytest.raises(ParameterError, match=says):
        read_mapping(tmp_path / "m.toml")
