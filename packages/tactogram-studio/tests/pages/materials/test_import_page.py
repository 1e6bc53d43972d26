"""The page that imports a folder: what its lists mean, and a zip from its drop to the store."""

import base64
import io
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from scipy.io import savemat

from tactogram.datasets import open_store
from tactogram.datasets.preview import preview_dataset
from tactogram.errors import ParameterError
from tactogram.signal.io import read_file
from tactogram.signal.io.content import TableLayout
from tactogram_studio.pages.materials.import_page import safe_store_name
from tactogram_studio.pages.materials.layout_card import ColumnChoices, by_key, timing_text

T = np.arange(400) / 500


WAVES = np.stack([np.sin(2 * np.pi * 60 * T + phase) for phase in range(3)])


HEADINGS = ("t", "a", "b", "c", "note")


def choices(roles, units=("", "", "", "", ""), **more):
    return ColumnChoices(HEADINGS, tuple(roles), tuple(units), **more)


def write(path, heading, rows, separator=","):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([heading, *(separator.join(row) for row in rows)]))


def lab(folder):
    """Write what a laboratory has: tables of two loggers, a matrix, a film and a broken table."""
    for take, material in enumerate(("cork", "felt", "felt")):
        stamps = T + np.random.default_rng(take).normal(0, 1e-4, len(T))
        rows = [
            [f"{t:.5f}", *(f"{v:.5f}" for v in x)] for t, x in zip(stamps, WAVES.T * (1 + take), strict=True)
        ]
        write(folder / material / f"take_{take}.csv", "Elapsed Time,X-Axis (g),Y-Axis (g),Z-Axis (g)", rows)
    clock = [f"23:59:{59 + t:06.3f}" if t < 1 else f"00:00:{t - 1:06.3f}" for t in T + 0.5]
    rows = [
        [stamp, *(f"{v:.5f}".replace(".", ",") for v in x)]
        for stamp, x in zip(clock, WAVES[:2].T, strict=True)
    ]
    write(folder / "Kork ä" / "Messung.csv", "Uhrzeit;Kanal 1;Kraft", rows, ";")
    savemat(folder / "cork" / "matrix.mat", {"data": np.column_stack([T, *WAVES])})
    rows = [["0", "1", "2", "3"], ["0.1", "one", "2", "3"]]
    write(folder / "felt" / "broken.csv", "Elapsed Time,X-Axis (g),Y-Axis (g),Z-Axis (g)", rows)
    (folder / "cork" / "film.mp4").write_bytes(b"film")
    return folder


def zip_of(folder):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(folder.rglob("*.*")):
            archive.write(path, path.relative_to(folder.parent))
    return file.getvalue()


def labelled(path):
    """Write a table of two materials."""
    rows = [[f"{0.002 * k:.3f}", f"{k % 7}", "cork" if k < 300 else "felt"] for k in range(500)]
    write(path, "t [s],x [g],surface", rows)


def test_a_column_of_labels_is_a_choice(tmp_path):
    labelled(tmp_path / "lab/all.csv")
    [facts] = preview_dataset("folder", tmp_path / "lab", workers=1)["layouts"]
    chosen = ColumnChoices.of(facts["columns"], [])
    assert chosen.roles == ("time", "x", "material")
    [layout] = chosen.layouts()
    assert (layout.material, ColumnChoices.of(facts["columns"], [layout]).roles) == ("surface", chosen.roles)
    [without] = chosen.with_role(2, "ignored").layouts()
    assert without.labels == {}
    with pytest.raises(
        ParameterError, match="material must be one column, got x .g., surface; choose another"
    ):
        replace(chosen, roles=("y", "material", "material")).layouts()


def test_choices_are_a_mapping_and_back():
    chosen = choices(["time", "y", "x", "force", "ignored"], ["ms", "g", "g", "mN", ""], rate=100.0)
    axes, force = chosen.layouts()
    assert axes == TableLayout(
        columns=HEADINGS,
        axes={"y": "a", "x": "b"},
        unit="g",
        time="t",
        time_unit="ms",
        rate=100.0,
        stream="acceleration",
    )
    assert (force.axes, force.unit, force.stream, force.rate) == ({"z": "c"}, "mN", "force", 100.0)
    columns = [{"heading": name, "role": "unclear", "unit": None} for name in HEADINGS]
    again = ColumnChoices.of(columns, [axes, force])
    assert (again.roles, again.units, again.layouts()) == (chosen.roles, chosen.units, [axes, force])


@pytest.mark.parametrize(
    ("roles", "says"),
    [
        (
            ["time", "ignored", "ignored", "unclear", "ignored"],
            "choose x, y, z, force or position for at least",
        ),
        (["time", "x", "x", "ignored", "ignored"], "x must be one column, got a, b; choose another"),
        (["time", "x", "time", "ignored", "ignored"], "time must be one column, got t, b; choose another"),
    ],
)
def test_choices_that_contradict_each_other_are_refused(roles, says):
    with pytest.raises(ParameterError, match=says):
        choices(roles).layouts()
    with pytest.raises(ParameterError, match="layout: rate: must be greater"):
        choices(["time", "x", "y", "z", "ignored"], rate=-1.0).layouts()


def test_a_stream_has_one_unit_and_time_another():
    chosen = choices(["time", "x", "y", "force", "ignored"]).with_unit(1, "g")
    assert chosen.units == ("", "g", "g", "", "")
    assert chosen.with_role(3, "z").units == ("", "g", "g", "g", "")
    assert chosen.with_role(1, "time").units == ("", "", "g", "", "")
    three = choices(["ignored", "force", "force", "force", "ignored"]).layouts()
    assert [layout.axes for layout in three] == [{"x": "a", "y": "b", "z": "c"}]


def test_the_unit_of_a_heading_stays_unless_another_is_chosen():
    chosen = ColumnChoices(("t (ms)", "a [g]"), ("ignored", "ignored"), ("", ""))
    assert chosen.with_role(0, "time").with_role(1, "x").units == ("ms", "g")
    assert chosen.with_role(1, "time").with_role(0, "x").units == ("", "")


def test_other_streams_of_a_saved_mapping_stay(tmp_path):
    layouts = [
        TableLayout(columns=HEADINGS, axes={"x": "a"}, time="t", stream="tap"),
        TableLayout(columns=HEADINGS, axes={"tip": "c"}, time="t", unit="N", stream="finger"),
    ]
    columns = [{"heading": name, "role": "ignored", "unit": None} for name in HEADINGS]
    chosen = ColumnChoices.of(columns, layouts)
    assert chosen.roles == ("time", "x", "ignored", "finger: tip", "ignored")
    assert chosen.layouts() == layouts


def test_what_a_preview_read_is_chosen_at_first(tmp_path):
    facts = preview_dataset("folder", lab(tmp_path / "lab"), workers=1)
    table, korks, matrix = facts["layouts"]
    chosen = ColumnChoices.of(table["columns"], [])
    assert (chosen.roles, chosen.units) == (("time", "x", "y", "z"), ("s", "g", "g", "g"))
    assert ColumnChoices.of(korks["columns"], []).roles == ("time", "ignored", "Kraft")
    assert ColumnChoices.of(matrix["columns"], []).roles == ("time", "x", "y", "z")
    assert timing_text(table).startswith("acceleration: x, y, z in m/s^2 · 500 Hz · time stamps: ")
    assert [*by_key([table, table])] == [repr(chosen.headings), table["example"]]
    mapped = read_file(tmp_path / "lab/felt/take_1.csv", layouts=chosen.layouts()).signal
    np.testing.assert_array_equal(mapped.samples, read_file(tmp_path / "lab/felt/take_1.csv").signal.samples)


def test_a_store_may_have_the_suggested_name():
    assert (safe_store_name("Kork ä (1)"), safe_store_name("…")) == ("Kork____1", "recordings")


def drop(tab, zone, name, data):
    """Drop a file as a hand does."""
    tab.locator(zone).evaluate(
        """(zone, [name, data]) => {
          const bytes = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
          const dataTransfer = new DataTransfer();
          dataTransfer.items.add(new File([bytes], name));
          const init = { dataTransfer, bubbles: true, cancelable: true };
          zone.dispatchEvent(new DragEvent("dragover", init));
          zone.dispatchEvent(new DragEvent("drop", init));
        }""",
        [name, base64.b64encode(data).decode()],
    )


def choose(tab, name, option):
    tab.get_by_role("combobox", name=name, exact=True).click()
    tab.get_by_role("option", name=option, exact=True).click()
    tab.get_by_role("option").first.wait_for(state="detached")


def test_a_dropped_zip_is_mapped_and_imported(tab, workspace, tmp_path, faults):
    tab.goto("/")
    drop(tab, "[data-receive]", "lab.zip", zip_of(lab(tmp_path / "lab")))
    tab.wait_for_url("**/materials/import?**")
    tab.get_by_text(
        "5 recordings of 3 materials would be imported from 7 files; 2 would be skipped"
    ).wait_for()
    tab.get_by_text("left out: Kanal 1 (no unit)").wait_for()
    for name, role in (
        ("Kanal 1", "x"),
        ("Kraft", "force"),
        ("data:1", "time"),
        ("data:2", "x"),
        ("data:3", "not read"),
        ("data:4", "z"),
    ):
        choose(tab, f"{name}: read as", role)
    for name, unit in (("Kanal 1", "g"), ("Kraft", "mN"), ("data:2", "g")):
        choose(tab, f"{name}: unit", unit)
    tab.get_by_text("left out: Kanal 1").wait_for(state="detached")
    tab.get_by_text(
        "5 recordings of 3 materials would be imported from 7 files; 2 would be skipped"
    ).wait_for()
    tab.get_by_role("region", name="Layout 3").get_by_role("img").nth(1).wait_for()
    for scheme in ("light", "dark"):
        tab.emulate_media(color_scheme=scheme)
        tab.locator(f".body--{scheme}").wait_for()
        # Quasar's bar also shows that axe-core loads the style sheets.
        tab.locator(".q-loading-bar[aria-hidden=true]").wait_for(state="attached")
        assert faults(tab) == []
    tab.reload()  # the mapping survives
    tab.get_by_text("5 recordings of 3 materials").wait_for()
    tab.get_by_role("button", name="Import", exact=True).click()
    tab.get_by_text("tick the box above").wait_for()
    tab.get_by_role("checkbox", name="Leave the skipped files out").click()
    tab.get_by_role("button", name="Import", exact=True).click()
    tab.get_by_text("data/lab is complete").wait_for()
    tab.goto("/materials")
    tab.get_by_role("link", name="data/lab", exact=True).wait_for()
    store = open_store(workspace / "data/lab")
    found = {info.source: (info.material, info.id) for info in store.index}
    assert sorted(material for material, _ in found.values()) == ["Kork ä", "cork", "cork", "felt", "felt"]
    force = store.signal(found["Kork ä/Messung.csv"][1], "force")
    np.testing.assert_allclose(force.samples[0], 1e-3 * WAVES[1], atol=1e-7)
    matrix = store.signal(found["cork/matrix.mat"][1], "acceleration")
    assert (matrix.axes, matrix.rate) == (("x", "z"), 500.0)
    np.testing.assert_allclose(matrix.samples, 9.80665 * WAVES[[0, 2]], rtol=1e-5, atol=1e-5)


def test_a_chosen_folder_of_the_workspace_and_a_saved_mapping(tab, workspace, tmp_path):
    lab(workspace / "mine")
    tab.goto("/materials/import")
    tab.get_by_role("combobox", name="Or a folder of the workspace").fill("mine")
    tab.get_by_role("option", name="mine", exact=True).click()
    tab.wait_for_url("**/import?folder=mine")
    choose(tab, "X-Axis (g): read as", "z")
    tab.get_by_text("z must be one column, got X-Axis (g), Z-Axis (g)").wait_for()
    choose(tab, "Z-Axis (g): read as", "x")
    tab.get_by_text("z: -9.8").first.wait_for()
    tab.get_by_role("button", name="Save mapping").click()
    tab.get_by_text("Saved as mappings/mine.toml").wait_for()
    tab.goto("/materials/import?folder=mine/felt")
    choose(tab, "Saved mapping", "mine")
    choose(tab, "Material named by", "the file name up to the first _")
    tab.get_by_text("take (2)").wait_for()
    tab.get_by_text("--mapping mappings/mine.toml --set material_from=file_start").wait_for()
    assert (workspace / "mappings/mine.toml").is_file()


def test_a_table_of_several_materials_is_imported(tab, workspace):
    labelled(workspace / "mixed/all.csv")
    tab.goto("/materials/import?folder=mixed")
    tab.get_by_text(
        "2 recordings of 2 materials would be imported from 1 files; 0 would be skipped"
    ).wait_for()
    choose(tab, "surface: read as", "not read")
    tab.get_by_text("no folder names the material; state it with").first.wait_for()
    choose(tab, "surface: read as", "material")
    tab.get_by_text("2 recordings of 2 materials").wait_for()
    tab.get_by_role("button", name="Import", exact=True).click()
    tab.get_by_text("data/mixed is complete").wait_for()
    assert [info.material for info in open_store(workspace / "data/mixed").index] == ["cork", "felt"]


@pytest.mark.parametrize(
    ("name", "data", "says"),
    [
        ("..%2Fa.csv", b"t,x\n0,1\n", "leads out of the folder"),
        ("a.zip", b"PK nothing", "a.zip: truncated or damaged"),
    ],
)
def test_what_is_refused_is_said_and_leaves_nothing(tab, server, workspace, name, data, says):
    before = sorted(workspace.rglob("*"))
    file = {"name": name, "mimeType": "text/csv", "buffer": data}
    answer = tab.request.post(f"{server}/materials/received", multipart={"file": file})
    assert (answer.status, says in answer.json()["problem"]) == (422, True)
    assert [path for path in sorted(workspace.rglob("*")) if path.suffix in (".csv", ".zip")] == [
        path for path in before if path.suffix in (".csv", ".zip")
    ]


def test_a_refused_drop_says_why_on_the_page(tab):
    tab.goto("/materials")
    tab.locator("[data-receive]").wait_for()
    drop(tab, "[data-receive]", "lab.zip", b"PK\x03\x04 nothing")
    tab.get_by_text("lab.zip: truncated or damaged").wait_for()
    tab.wrong.clear()  # the browser logs the status 422
