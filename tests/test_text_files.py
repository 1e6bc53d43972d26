"""Tables and settings from other programs: one line names the file, what is wrong and what to do."""

import shutil

import pytest

from tactogram.datasets import open_store
from tactogram.datasets.importers import folder
from tactogram.errors import DataError, ParameterError
from tactogram.recipe import Recipe
from tactogram.rendering.displays.catalogue import open_display, shipped
from tactogram.rendering.displays.response import read_response
from tactogram.rendering.drive.friction_calibration import read_calibrations
from tactogram.rendering.motion.recorded_motion import MotionFile
from tactogram.signal.io import read_signal
from tactogram.text_files import csv_rows, parse_json, parse_toml, read_table, read_text
from tactogram.workflows.training.loaded_run import load_run
from tactogram_benchmark.importers import biotac_slide, vibviz
from tactogram_capture.session.plan import SessionPlan
from tactogram_playback.friction_fit import read_pairs
from tactogram_playback.transducer.circuit import read_sweep
from tactogram_study.answers import read_answers
from tactogram_study.study_file import Study

TABLES = {
    "recordings.csv": (folder.find, "file,material,notes\n", "a.wav,{},x\n"),
    "materials.csv": (biotac_slide.find, "material_id,name\n", "1,{}\n"),
    "vibrationAnnotations-1.csv": (vibviz.ratings, f"id,{','.join(vibviz.RATINGS)},name\n", "1,2,{}\n"),
    "pairs.csv": (read_pairs, "voltage_v_rms,friction,normal_force_n,person\n", "1,2,3,{}\n"),
    "sweep.csv": (read_sweep, "frequency_hz,conductance_s,susceptance_s,state\n", "1,2,3,{}\n"),
    "response.csv": (read_response, "frequency,gain\n", "1,{}\n"),
    "motion.csv": (MotionFile, "time_s,speed_mm_s\n", "1,{}\n"),
    "answers.csv": (read_answers, "study,participant\n", "a,{}\n"),
    "signal.csv": (read_signal, "time [s],x\n", "0,{}\n"),
}
OF_FOLDERS = ("recordings.csv", "materials.csv", "vibrationAnnotations-1.csv")


def refusal(name, content, tmp_path):
    """Return the one line with which a table is refused."""
    (tmp_path / name).write_bytes(content)
    (tmp_path / "mat01.npz").touch()  # whose table materials.csv is
    read = TABLES[name][0]
    with pytest.raises(DataError) as caught:
        read(tmp_path if name in OF_FOLDERS else tmp_path / name)
    assert len(str(caught.value)) < 500
    return str(caught.value)


@pytest.mark.parametrize("name", [name for name in TABLES if name not in ("signal.csv", "answers.csv")])
@pytest.mark.parametrize("encoding", ["latin-1", "cp932", "utf-16"])
def test_a_table_in_another_encoding_is_refused(name, encoding, tmp_path):
    _, headings, row = TABLES[name]
    text = headings + row.format({"latin-1": "Stoffmuster grün", "cp932": "ゴム", "utf-16": "x"}[encoding])
    line = refusal(name, text.encode(encoding), tmp_path)
    assert str(tmp_path / name) in line
    assert line.endswith("save it as UTF-8")


@pytest.mark.parametrize("encoding", ["cp1252", "cp932", "utf-16"])
def test_answers_are_read_in_any_encoding(encoding, tmp_path):
    said = {"cp1252": "Stoffmuster grün", "cp932": "さらさらする", "utf-16": "x"}[encoding]
    path = tmp_path / "answers.csv"
    path.write_bytes(f"study,participant,design,question,answer\ns,p,rating,rough,{said}\n".encode(encoding))
    answers = read_answers(path)
    assert answers.column("answer") == (said,)
    assert answers.notes == (() if encoding == "utf-16" else (f"text read as {encoding}, not UTF-8",))


@pytest.mark.parametrize("name", TABLES)
def test_a_cell_longer_than_any_is_refused(name, tmp_path):
    _, headings, row = TABLES[name]
    line = refusal(name, (headings + row.format('"' + "x" * 200_000)).encode(), tmp_path)
    assert "larger than field limit (131072); is a quote left open?" in line


def test_a_row_is_numbered_as_in_a_spreadsheet(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text('\ufefffile,note\n\na,"two\nlines"\nb\n', encoding="utf-8")
    expected = [(3, {"file": "a", "note": "two\nlines"}), (4, {"file": "b", "note": ""})]
    assert read_table(path, needed=("file",)) == expected
    with pytest.raises(DataError, match="needs columns file, size, lacks size, has file, note"):
        read_table(path, needed=("file", "size"))
    path.write_text("file\na,b\n")
    with pytest.raises(DataError, match="row 2 has more values than there are columns"):
        read_table(path)
    path.write_text("")
    assert read_table(path) == []


def test_a_large_text_is_refused_before_it_is_read_whole(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("x" * 101)
    with pytest.raises(DataError, match="must have at most 100 bytes"):
        read_text(path, most_bytes=100)
    path.write_text("x" * 100)
    assert read_text(path, most_bytes=100) == "x" * 100
    with pytest.raises(DataError, match="is a folder"):
        read_text(tmp_path)


BAD_TOML = {
    "thousands of digits": ("x = " + "9" * 5000, "at most 64 bits"),
    "more than 64 bits": ("[a]\nx = [1, 9223372036854775808]", "at most 64 bits, got 65"),
    "lists in lists": ("x = " + "[" * 3000 + "]" * 3000, "nested too deep"),
    "tables in tables": ("x = " + "{a=" * 40 + "1" + "}" * 40, "nested deeper than 32"),
    "a long key": (".".join(["a"] * 20_000) + " = 1", "a key must have at most 32 parts"),
    "a long quoted key": (".".join(['"a b"'] * 40) + " = 1", "a key must have at most 32 parts"),
    "no TOML": ("x = ", "not readable as TOML: Invalid value"),
    "another encoding": ("x = 'ü'", "not UTF-8 text at byte 5"),
    "too large": ("# " + "x" * 2**20, "must have at most 1048576 bytes"),
}
SETTINGS = {
    "recipe": Recipe.load,
    "display": open_display,
    "study": Study.load,
    "plan": SessionPlan.load,
    "calibrations": read_calibrations,
}


@pytest.mark.parametrize("problem", BAD_TOML)
@pytest.mark.parametrize("kind", SETTINGS)
def test_bad_settings_are_refused(kind, problem, tmp_path):
    text, line = BAD_TOML[problem]
    path = tmp_path / "a.toml"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(DataError, match=line) as caught:
        SETTINGS[kind](path)
    assert str(caught.value).startswith(f"{path}: ")
    assert len(str(caught.value)) < 400


def test_dots_in_a_text_are_no_key():
    dots = "Name: " + "." * 200 + "\n" + "One is enough. Two are more. " * 50
    values = parse_toml(f'x = 9223372036854775807\ntext = """{dots}"""\na.b.c = 1', "here")
    assert values == {"x": 2**63 - 1, "text": dots, "a": {"b": {"c": 1}}}


def test_json_beyond_its_limits_is_refused():
    assert parse_json('{"x": [1, NaN]}', "here")["x"][0] == 1
    for text in ("[" * 100_000, "9" * 5000, "{", "[NaN]", "[9223372036854775808]"):
        with pytest.raises(DataError, match="here: not a JSON document"):
            parse_json(text, "here", finite=True)


def test_cells_between_tabs_are_read():
    assert csv_rows("a\tb\n1\t2\n", "here", delimiter="\t") == [(1, ["a", "b"]), (2, ["1", "2"])]


def test_a_display_that_begins_with_a_byte_order_mark_is_read(tmp_path):
    path = tmp_path / "display.toml"
    shutil.copy(shipped()["voice-coil"], path)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert open_display(path).name


@pytest.mark.parametrize("job", [open_store, load_run, open_display])
@pytest.mark.parametrize("value", [5, None, [0.0, 1.0]])
def test_what_is_no_path_is_refused_in_one_line(job, value):
    with pytest.raises(ParameterError, match="^(path|run|name) must be a path, got "):
        job(value)
