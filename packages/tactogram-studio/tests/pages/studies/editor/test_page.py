"""The editor of studies in a browser: a reload, faults beside their fields, and files that are none."""

from pathlib import Path

from tactogram_study.study_file import Study, shipped_studies

EXTRA = """
[[stimuli]]
name = "denim"
run = "texture_flow"
material = "denim"
"""


def test_changes_survive_a_reload_faults_are_beside_their_fields_and_hand_written_files_are_warned_of(
    tab, workspace
):
    path = Path(workspace) / "studies" / "by_hand.toml"
    path.parent.mkdir(exist_ok=True)
    path.write_text(shipped_studies()["abx"].read_text())
    tab.goto("/studies/edit?study=studies/by_hand.toml")
    tab.get_by_text("Saving from this page removes the comments").wait_for()
    tab.get_by_label("Repeats of each pair").fill("0")
    field = tab.locator(".q-field", has=tab.get_by_label("Repeats of each pair"))
    field.get_by_role("alert").get_by_text("repeats: must be greater than or equal to 1, got 0").wait_for()
    assert tab.get_by_role("button", name="Save", exact=True).is_disabled()
    tab.reload()
    tab.get_by_role("status").filter(has_text="1 problem").wait_for()
    tab.get_by_label("Repeats of each pair").fill("8")
    tab.get_by_role("status").filter(has_text="Valid").wait_for()
    tab.get_by_role("button", name="Save", exact=True).click()
    tab.get_by_text("Saved.").wait_for()
    assert Study.load(path).first_difference(Study.load("abx")) == "design.repeats"
    assert Study.load(path).design.repeats == 8
    assert "#" not in path.read_text()


def test_conditions_and_sources_of_a_grid_and_what_a_model_is_given_have_fields(tab, workspace):
    path = Path(workspace) / "studies" / "grid.toml"
    path.parent.mkdir(exist_ok=True)
    path.write_text(shipped_studies()["display-words"].read_text() + EXTRA)
    tab.goto("/studies/edit?study=studies/grid.toml")
    source = tab.get_by_label("Changes to the source for A")
    source.fill("seed = ")
    tab.get_by_role("alert").get_by_text("each line must be NAME = VALUE").wait_for()
    source.fill("seed = 7\nseconds = 1.5")
    tab.get_by_role("status").filter(has_text="Valid").wait_for()
    tab.get_by_label("Another condition").fill("twin")
    tab.get_by_role("button", name="Add the condition").click()
    tab.get_by_label("Changes to the source for twin").fill('simulated = "stroking9/tile"')
    tab.get_by_role("button", name="Change denim").click()
    tab.get_by_label("Given speed, mm/s").fill("120")
    tab.get_by_role("button", name="Done").click()
    tab.get_by_role("textbox", name="denim").and_(tab.locator("[value*='speed_mm_s 120']")).wait_for()
    tab.get_by_role("button", name="Remove the condition twin").click()
    tab.get_by_role("status").filter(has_text="Valid").wait_for()
    tab.get_by_role("button", name="Save", exact=True).click()
    tab.get_by_text("Saved.").wait_for()
    saved = Study.load(path)
    assert saved.grid.conditions == ("sensor", "A", "B", "C", "D")
    assert saved.grid.by_condition["A"] == {"seed": 7, "seconds": 1.5}
    assert saved.grid.by_condition["B"] == {"autoregressive": True, "seed": 2}
    assert saved.stimuli[0].given == {"speed_mm_s": 120}


def test_what_is_limited_of_a_stimulus_is_said_to_who_edits_and_to_who_runs_the_study(tab, workspace):
    path = Path(workspace) / "studies" / "fast.toml"
    path.parent.mkdir(exist_ok=True)
    head = 'title = "Fast"\nconsent = "Do you agree?"\nlevel = "gain=0.1"\n[design]\nkind = "magnitude"'
    path.write_text(f"{head}{EXTRA}seconds = 0.2\ngiven.speed_mm_s = 900\n")
    said = "timulus denim: speed 900 mm/s is outside of what was recorded: it counts as 399.7 mm/s"
    tab.goto("/studies/edit?study=studies/fast.toml")
    tab.get_by_role("button", name="Make and render every stimulus").click()
    tab.get_by_role("listitem").filter(has_text=said).wait_for()
    tab.get_by_role("button", name="Begin a session").click()
    tab.get_by_role("button", name="Begin", exact=True).click()
    tab.get_by_text(f"S{said}.").wait_for()


def test_a_preview_offers_neither_a_code_nor_to_continue(tab, workspace):
    path = Path(workspace) / "studies" / "looked_at.toml"
    path.parent.mkdir(exist_ok=True)
    path.write_text(shipped_studies()["abx"].read_text())
    tab.goto("/studies/edit?study=studies/looked_at.toml")
    with tab.context.expect_page() as shown:
        tab.get_by_role("link", name="Preview a trial").click()
    preview = shown.value
    for _ in range(2):
        preview.get_by_role("heading", name="Preview").wait_for()
        text = preview.locator("body").inner_text()
        assert "Answers are not stored." in text
        assert not [word for word in ("PREVIEW1", "code", "Continue") if word in text]
        preview.reload()  # where participants would continue
    preview.close()


def test_what_is_no_study_of_the_workspace_is_not_edited(tab):
    tab.goto("/studies/edit?study=../../etc/passwd")
    tab.get_by_role("alert").get_by_text("lies outside of the workspace").wait_for()
    tab.goto("/studies/edit?study=studies/none.toml")
    tab.get_by_role("alert").get_by_text("studies/none.toml: no such study in this workspace").wait_for()
