"""Parts of files: tables cut by labels and holes."""

import json

import numpy as np
import openpyxl
import pytest
from PIL import Image as Pillow

from tactogram.cli import main
from tactogram.datasets import open_store
from tactogram.errors import DataError
from tactogram.workflows.data.stores import import_store

RUNS = (("cork", 60), ("", 7), ("felt", 50), ("cork", 40), ("tin", 5), ("felt", 45))


def rows_of(runs, *, step=0.002):
    """Return rows of time, a ramp and the label; sample k is k."""
    labels = [label for label, count in runs for _ in range(count)]
    return [[f"{step * k:.3f}", k, label] for k, label in enumerate(labels)]


def write(path, rows, heading="t [s],x [g],surface"):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([heading, *(",".join(map(str, row)) for row in rows)]) + "\n")


def imported(tmp_path, **more):
    report = import_store("folder", tmp_path / "f", tmp_path / "s", **more)
    return report, open_store(tmp_path / "s")


def test_a_table_is_cut_where_the_label_changes(tmp_path):
    write(tmp_path / "f" / "all.csv", rows_of(RUNS))
    report, store = imported(tmp_path)
    assert [(info.material, info.source) for info in store.index] == [
        ("cork", "all.csv#1"),
        ("felt", "all.csv#2"),
        ("cork", "all.csv#3"),
        ("felt", "all.csv#5"),
    ]
    samples = store.signal(store.index[1].id, "acceleration").samples[0]
    np.testing.assert_allclose(samples, 9.80665 * np.arange(67, 117), rtol=1e-6)
    assert [each["reason"] for each in report["skipped"]] == [
        "all.csv: rows 159 to 163: 5 samples of 'tin', a recording needs 32; correct the labels there, or record "
        "longer",
        "all.csv: 7 rows without a label in column 'surface'",
    ]


@pytest.mark.parametrize(
    ("change", "lengths"),
    [
        (lambda rows: rows, [200]),
        (lambda rows: [[f"{0.002 * (k % 120):.3f}", *row[1:]] for k, row in enumerate(rows)], [120, 80]),
        (lambda rows: rows[:80] + rows[84:], [80, 116]),  # 4 rows are missing
        (lambda rows: rows[:80] + rows[83:], [200]),  # 3 are interpolated
        (lambda rows: [[t, "" if 80 <= k < 84 else k, label] for t, k, label in rows], [80, 116]),
        (lambda rows: [[t, "" if 80 <= k < 83 else k, label] for t, k, label in rows], [200]),
    ],
)
def test_a_table_is_cut_where_time_goes_back_or_too_much_is_missing(tmp_path, change, lengths):
    write(tmp_path / "f" / "all.csv", change(rows_of([("cork", 200)])))
    _, store = imported(tmp_path)
    assert [store.length(info.id, "acceleration") for info in store.index] == lengths
    assert {info.material for info in store.index} == {"cork"}


@pytest.mark.parametrize("heading", ["Material", "label", "CLASS", "texture", "activity"])
@pytest.mark.parametrize("codes", [("1", "2"), ("1.0", "2.0"), ("P80", "P120")])
def test_words_and_codes_under_the_usual_headings_are_labels(tmp_path, heading, codes):
    rows = rows_of([(codes[0], 50), (codes[1], 50)])
    write(tmp_path / "f" / "cork" / "all.csv", rows, f"t [s],x [g],{heading}")
    _, store = imported(tmp_path)
    assert [info.material for info in store.index] == [code.removesuffix(".0") for code in codes]
    assert store.streams["acceleration"].axes == ("x",)


def test_measurements_under_such_a_heading_are_samples(tmp_path):
    rows = [[t, k, k / 7] for t, k, _ in rows_of([("", 50)])]
    write(tmp_path / "f" / "cork" / "all.csv", rows, "t [s],x [g],texture [g]")
    _, store = imported(tmp_path)
    assert ([info.material for info in store.index], store.streams["acceleration"].axes) == (
        ["cork"],
        ("x",),
    )


def test_session_subject_and_trial_divide_a_material_and_are_stored(tmp_path):
    rows = [[*row, "A", "s1" if k < 100 else "s2", k // 50] for k, row in enumerate(rows_of([("cork", 150)]))]
    write(tmp_path / "f" / "all.csv", rows, "t [s],x [g],material,participant,session,Take")
    _, store = imported(tmp_path)
    found = [(info.material, info.subject, info.session, info.labels["trial"]) for info in store.index]
    assert found == [("cork", "A", "s1", "0"), ("cork", "A", "s1", "1"), ("cork", "A", "s2", "2")]


def test_a_worksheet_is_cut_as_a_table_is(tmp_path):
    book = openpyxl.Workbook()
    for row in [["t [s]", "x [g]", "label"], *([0.002 * k, k, 3 if k < 60 else 4] for k in range(100))]:
        book.active.append(row)
    (tmp_path / "f").mkdir()
    book.save(tmp_path / "f" / "all.xlsx")
    _, store = imported(tmp_path)
    found = [(info.material, store.length(info.id, "acceleration")) for info in store.index]
    assert found == [("3", 60), ("4", 40)]


MAPPING = """
[[layout]]
columns = ["t [s]", "x [g]", "f", "word"]
time = "t [s]"
material = "word"
axes.x = "x [g]"
stream = "acceleration"

[[layout]]
columns = ["t [s]", "x [g]", "f", "word"]
time = "t [s]"
unit = "N"
axes.z = "f"
stream = "force"
"""


def test_a_mapping_names_the_column_for_all_streams(tmp_path):
    rows = [[t, k, -k, label] for t, k, label in rows_of([("cork", 60), ("felt", 40)])]
    write(tmp_path / "f" / "all.csv", rows, "t [s],x [g],f,word")
    (tmp_path / "m.toml").write_text(MAPPING)
    _, store = imported(tmp_path, mapping=tmp_path / "m.toml")
    assert [info.material for info in store.index] == ["cork", "felt"]
    np.testing.assert_allclose(
        store.signal(store.index[1].id, "force").samples[0], -np.arange(60, 100), rtol=1e-6
    )


def test_a_saved_mapping_has_the_column_and_without_it_the_folder_names_the_material(tmp_path):
    write(tmp_path / "f" / "day 1" / "all.csv", rows_of(RUNS))
    saved = tmp_path / "m.toml"
    plain = import_store("folder", tmp_path / "f", preview=True, save_mapping=saved)
    mapped = import_store("folder", tmp_path / "f", preview=True, mapping=saved)
    assert mapped["layouts"][0]["materials"] == plain["layouts"][0]["materials"] == {"cork": 2, "felt": 2}
    saved.write_text(saved.read_text().replace('material = "surface"\n', ""))
    facts = import_store("folder", tmp_path / "f", preview=True, mapping=saved)
    assert (facts["layouts"][0]["materials"], facts["skipped"]) == ({"day 1": 1}, [])


def test_a_row_of_metadata_decides_against_the_labels(tmp_path):
    write(tmp_path / "f" / "all.csv", rows_of(RUNS))
    (tmp_path / "f" / "recordings.csv").write_text("file,material\nall.csv,slate\n")
    _, store = imported(tmp_path)
    assert [(info.material, info.source) for info in store.index] == [("slate", "all.csv")]


def test_a_folders_picture_is_of_its_own_material_alone(tmp_path):
    write(tmp_path / "f" / "felt" / "all.csv", rows_of([("cork", 60), ("felt", 60)]))
    Pillow.new("RGB", (6, 4)).save(tmp_path / "f" / "felt" / "photo.png")
    _, store = imported(tmp_path)
    assert {info.material: store.image(info.id) is not None for info in store.index} == {
        "cork": False,
        "felt": True,
    }


@pytest.mark.parametrize(
    ("runs", "says"),
    [
        ([("", 90)], "column 'surface' has no label in any row; fill it in, or omit it, `mapping=FILE.toml`"),
        ([("a", 9), ("b", 9)] * 9, "column 'surface': none of its 2 labels holds for 32 rows in succession"),
    ],
)
def test_a_table_without_a_usable_label_is_refused(tmp_path, runs, says):
    write(tmp_path / "f" / "cork" / "all.csv", rows_of(runs))
    with pytest.raises(DataError, match=f"all.csv: {says}"):
        imported(tmp_path)
    assert not (tmp_path / "s").exists()


def test_a_broken_part_stops_the_import_and_alone_is_skipped(tmp_path):
    rows = rows_of([("cork", 60), ("felt", 60)])
    rows[70][1] = "1e99"
    write(tmp_path / "f" / "all.csv", rows)
    says = "all.csv: rows 62 to 121: row 72, column 'x .g.': expected a finite number, got 9.80665e.99"
    with pytest.raises(DataError, match=says):
        imported(tmp_path)
    facts = import_store("folder", tmp_path / "f", preview=True)
    assert (facts["needs_skip_bad"], facts["skipped_files"]) == (True, 0)
    report, store = imported(tmp_path, skip_bad=True)
    assert ([info.material for info in store.index], report["skipped"]) == (["cork"], facts["skipped"])


def test_the_command_counts_materials_and_recordings(tmp_path, capsys):
    write(tmp_path / "f" / "all.csv", rows_of(RUNS))
    words = ["data", "import", "folder", str(tmp_path / "f"), "--preview"]
    assert main(words) == 0
    assert "  column 'surface': labels, 2 materials in 4 recordings\n" in capsys.readouterr().out
    assert main([*words, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["layouts"][0]["files"], facts["files"], facts["skipped_files"]) == (1, 1, 0)
    assert (facts["layouts"][0]["columns"][2]["heading"], facts["layouts"][0]["columns"][2]["role"]) == (
        "surface",
        "material",
    )


def write_table(path, heading, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([heading, *(",".join(map(str, row)) for row in rows)]) + "\n")


def ramp(count, *, missing=(0, 0), step=0.01):
    return [[f"{step * k:.3f}", k] for k in range(count) if not missing[0] <= k < missing[1]]


@pytest.mark.parametrize(
    ("missing", "lengths"),
    [((150, 154), [150, 246]), ((150, 153), [400]), ((20, 40), [360]), ((100, 300), [100, 100])],
)
def test_a_hole_divides_a_table(tmp_path, missing, lengths):
    write_table(tmp_path / "f" / "cork" / "a.csv", "t [s],x [g]", ramp(400, missing=missing))
    report = import_store("folder", tmp_path / "f", tmp_path / "s")
    store = open_store(tmp_path / "s")
    assert [store.length(info.id, "acceleration") for info in store.index] == lengths
    notes = [note["text"] for note in report["notes"]]
    assert notes == ["a hole of more than three missing samples divides the recording"] * (lengths != [400])
    assert [each["source"] for each in report["skipped"]] == ["cork/a.csv#1"] * (missing == (20, 40))


def test_a_hole_divides_all_files_of_a_take(tmp_path):
    write_table(tmp_path / "f" / "cork" / "1_acc.csv", "t [s],x [g]", ramp(400, missing=(150, 170)))
    write_table(tmp_path / "f" / "cork" / "1_force.csv", "t [s],f [N]", ramp(800, step=0.005))
    import_store("folder", tmp_path / "f", tmp_path / "s")
    store = open_store(tmp_path / "s")
    first, second = (store.signal(info.id, "force").samples[0] for info in store.index)
    assert (first[0], first[-1], second[0], second[-1]) == (0, 298, 340, 799)


def test_pauses_between_blocks_of_stamps_are_no_holes(tmp_path):
    rows = [[f"{0.02 * (k // 10) + 1e-4 * (k % 10):.4f}", k] for k in range(400)]
    write_table(tmp_path / "f" / "cork" / "a.csv", "t [s],x [g]", rows)
    report = import_store("folder", tmp_path / "f", tmp_path / "s", skip_bad=True, preview=True)
    assert not any("hole" in each["text"] for each in report["notes"] + report["problems"])
