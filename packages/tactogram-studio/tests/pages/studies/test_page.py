import re
from pathlib import Path

import pytest

from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import shipped_studies


@pytest.fixture
def studies(tab):
    tab.goto("/studies")
    tab.get_by_role("heading", level=1, name="Studies").wait_for()
    return tab


def test_a_design_is_copied_begun_with_changes_and_analysed(studies, workspace):
    tab = studies
    for name in shipped_studies():
        assert tab.locator(f"[data-study={name}]").count() == 1
    tab.get_by_role("button", name="Make your own from threshold").click()
    tab.get_by_label("Name of your study").fill("Threshold!")
    tab.get_by_role("button", name="Copy and edit").click()
    tab.get_by_text("name must be 1 to 40 lower-case letters").wait_for()
    tab.get_by_label("Name of your study").fill("threshold")
    tab.get_by_role("button", name="Copy and edit").click()
    tab.wait_for_url("**/studies/edit?study=studies/threshold.toml")
    tab.get_by_role("link", name="All studies").click()

    tab.get_by_role("button", name="Begin a session of studies/threshold.toml").click()
    tab.get_by_label("Name of the session's folder").fill("../out")
    tab.get_by_role("button", name="Begin", exact=True).click()
    tab.get_by_text("name must be 1 to 40 letters").wait_for()
    tab.get_by_label("Name of the session's folder").fill("pilot")
    tab.get_by_label("Changes (optional)").fill("design.most_trials=6, practice.trials=1")
    tab.get_by_role("button", name="Begin", exact=True).click()
    tab.wait_for_url("**/experiment/sessions~pilot")
    tab.get_by_text("0 participants; 0 answers").wait_for()
    with SessionStore(Path(workspace) / "sessions" / "pilot") as store:
        assert (store.study.trials, store.study.practice.trials) == (12, 1)

    tab.get_by_text("Simulated participants").click()
    tab.get_by_label("How many").fill("4")
    tab.get_by_role("button", name="Simulate", exact=True).click()
    tab.get_by_text("4 simulated participants finished").wait_for()
    tab.goto("/studies")
    row = tab.get_by_role("row", name="sessions/pilot-simulated")
    row.get_by_text("4 simulated participants, 4 finished").wait_for()
    tab.get_by_label("Answers", exact=True).click()
    tab.get_by_role("option", name="session sessions/pilot-simulated (simulated)").click()
    tab.get_by_role("button", name="Analyse").click()
    tab.get_by_role("link", name="Open the report").wait_for()
    assert (Path(workspace) / "sessions" / "pilot-simulated" / "analysis" / "report.html").is_file()


def test_what_a_study_could_show_is_calculated_and_nonsense_is_told(studies):
    tab = studies
    tab.get_by_label("Design", exact=True).click()
    tab.get_by_role("option", name="realism").click()
    tab.get_by_label("Participants", exact=True).fill("ten")
    tab.get_by_role("button", name="Calculate power").click()
    tab.get_by_text("Participants needs whole numbers separated by commas, got 'ten'").wait_for()
    tab.get_by_label("Participants", exact=True).fill("12")
    tab.get_by_label("Trials each").fill("30")
    tab.get_by_role("button", name="Calculate power").click()
    table = tab.get_by_role("table").filter(has_text="shows the effect")
    table.wait_for()
    cells = table.locator("tbody th, tbody td").all_inner_texts()
    assert cells[:2] == ["12", "30"]
    assert all(0 <= float(cell) <= 1 for cell in cells[2:])


def test_a_file_that_is_dropped_beside_the_field_is_taken(studies, workspace):
    text = shipped_studies()["image-words"].read_text(encoding="utf-8")
    tab = studies
    tab.evaluate(
        """text => {
          const dataTransfer = new DataTransfer();
          dataTransfer.items.add(new File([text], "dropped.toml"));
          const init = { dataTransfer, bubbles: true, cancelable: true };
          document.querySelector("h1").dispatchEvent(new DragEvent("dragover", init));
          document.querySelector("h1").dispatchEvent(new DragEvent("drop", init));
        }""",
        text,
    )
    tab.locator('[data-study="studies/dropped.toml"]').wait_for()
    assert (workspace / "studies/dropped.toml").read_text(encoding="utf-8") == text


def test_a_study_file_is_added_and_one_that_is_wrong_is_refused(studies, workspace):
    tab = studies
    text = shipped_studies()["preference"].read_bytes()
    assert tab.get_attribute("html", "lang") == "en-US"
    assert tab.get_by_role("button", name=re.compile("^$")).count() == 0
    with tab.expect_file_chooser():
        tab.get_by_role("button", name="Choose a file: Add a study file (TOML)").click()
    upload = tab.locator("input[type=file]")
    upload.set_input_files(
        {"name": "mine.toml", "mimeType": "application/toml", "buffer": b"[design]\nkind = 'x'\n"}
    )
    tab.get_by_text("design.kind must be one of").first.wait_for()
    assert not (Path(workspace) / "studies" / "mine.toml").exists()
    upload.set_input_files({"name": "mine.toml", "mimeType": "application/toml", "buffer": text})
    tab.locator("[data-study='studies/mine.toml']").wait_for()
    assert (Path(workspace) / "studies" / "mine.toml").read_bytes() == text
