"""The editor of studies in a browser: a reload, faults beside their fields, and files that are none."""

from pathlib import Path

from tactogram.study.study_file import Study, shipped_studies


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


def test_what_is_no_study_of_the_workspace_is_not_edited(tab):
    tab.goto("/studies/edit?study=../../etc/passwd")
    tab.get_by_role("alert").get_by_text("lies outside of the workspace").wait_for()
    tab.goto("/studies/edit?study=studies/none.toml")
    tab.get_by_role("alert").get_by_text("studies/none.toml: no such study in this workspace").wait_for()
