"""The page that imports a folder: a zip from its drop to the store."""

import base64
import io
import zipfile

import numpy as np
import pytest
from laboratory_files import WAVES, lab, labelled

from tactogram.datasets import open_store
from tactogram_studio.pages.materials.import_page import safe_store_name


def zip_of(folder):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(folder.rglob("*.*")):
            archive.write(path, path.relative_to(folder.parent))
    return file.getvalue()


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
