"""Rules of accessibility, decided by axe-core, on every page and report, light and dark."""

import re
import shutil

import pytest
from matplotlib.figure import Figure

from tactogram.evaluation.report import ReportFigure, ReportSection, ReportSound, ReportTable, write_report
from tactogram.signal import Signal
from tactogram_study.study_file import shipped_studies
from tactogram_study.workflows.analysis import analyse_study
from tactogram_study.workflows.sessions import simulate_study

STORE = "studio/first/surfaces"
RUN = "studio/first/voices"
SESSION = "sessions/done"
PAGES = {
    "home": "/",
    "make": "/make",
    "touch": "/touch",
    "edit": "/edit",
    "materials": "/materials",
    "store": f"/materials/set?set={STORE}",
    "upload": "/materials/drop",
    "import": "/materials/import",
    "train": "/train",
    "run": f"/train/watch?run={RUN}",
    "compare": f"/train/compare?run={RUN}&run=runs/second",
    "send": "/send",
    "live": "/live",
    "studies": "/studies",
    "editor": "/studies/edit?study=studies/mine.toml",
    "reports": "/reports",
    "absent": "/absent",
}


@pytest.fixture(scope="module", autouse=True)
def second_run_own_study_and_analysed_session(workspace):
    """Add a run to compare with, a study to edit, and a session with a report."""
    shutil.copytree(workspace / RUN, workspace / "runs/second")
    (workspace / "studies").mkdir()
    shutil.copy(shipped_studies()["image-words"], workspace / "studies/mine.toml")
    simulate_study("two-area", workspace / SESSION, participants=3, changes={"design.repeats": 1})
    analyse_study(workspace / SESSION, workspace / SESSION / "analysis", draws=100, figures=False)


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", PAGES)
def test_no_rule_is_broken(name, scheme, tab, faults):
    tab.emulate_media(color_scheme=scheme)
    tab.goto(PAGES[name])
    tab.get_by_role("heading", level=1).wait_for()
    if name == "live":  # it never stops asking
        tab.wait_for_selector("#live-traces[data-drawn='1']")
    else:
        tab.wait_for_load_state("networkidle")
    if name == "studies":
        assert tab.get_by_role("link", name=f"Open the report of {SESSION}").count() == 1
    if name == "compare":
        tab.get_by_role("cell", name="ar_texture").first.wait_for()
    if name == "absent":
        tab.wrong.clear()  # the browser logs the status 404
    assert tab.locator(f".body--{scheme}").count() == 1
    assert faults(tab) == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_rule_is_broken_by_the_editor_with_all_parts_open_and_a_fault(scheme, tab, faults):
    tab.emulate_media(color_scheme=scheme)
    tab.goto(PAGES["editor"])
    for part in ("Questions after", "Practice", "Analysis", "The file", "Names on pages"):
        tab.get_by_role("button", name=re.compile(part)).click()
    tab.get_by_label("Lowest step").fill("9")
    tab.get_by_role("status").filter(has_text="1 problem").wait_for()
    assert faults(tab) == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_rule_is_broken_by_the_form_of_a_stimulus(scheme, tab, faults):
    tab.emulate_media(color_scheme=scheme)
    tab.goto(PAGES["editor"])
    tab.get_by_role("button", name="Add a stimulus").click()
    tab.get_by_role("dialog").get_by_text("nothing played", exact=True).wait_for()
    assert faults(tab) == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_rule_is_broken_by_a_result(scheme, tab, faults):
    tab.emulate_media(color_scheme=scheme)
    tab.goto("/make")
    tab.get_by_role("button", name="Generate", exact=True).click()
    tab.locator("canvas").nth(1).wait_for()
    assert faults(tab) == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_rule_is_broken_by_an_effect_and_its_file(scheme, tab, faults):
    tab.emulate_media(color_scheme=scheme)
    tab.goto("/edit")
    tab.wait_for_selector("#timeline[data-drawn]")
    for name in ("Error", "Rumble", "Fade out"):
        tab.get_by_role("button", name=name, exact=True).click()
    tab.locator('[data-focus="item 1 amplitude 1"]').focus()
    tab.keyboard.press("ArrowUp")
    tab.get_by_role("group", name="Amplitude point 2", exact=True).wait_for()
    tab.get_by_role("button", name="Download", exact=True).click()
    tab.locator(".spectrogram").nth(1).wait_for()
    assert faults(tab) == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_rule_is_broken_by_a_report(scheme, tab, faults, tmp_path):
    figure = Figure()
    figure.subplots().plot([1, 2])
    blocks = [
        ReportTable(("material", "share"), [("cork", 0.5)], caption="Shares"),
        ReportTable(("material", "share"), [("cork", 0.5)], folded="All shares"),
        ReportFigure(figure, "Shares of materials"),
        ReportSound(Signal([0.0, 1.0, 0.0, -1.0] * 100, 400.0, "m/s^2"), "Cork"),
    ]
    sections = [ReportSection("Shares", blocks)]
    path = write_report(
        tmp_path / "report.html", title="Cork", summary="A run.", sections=sections, simulated=True
    )
    tab.emulate_media(color_scheme=scheme)
    tab.set_content(path.read_text(encoding="utf-8"))
    assert tab.get_by_role("main").get_by_role("heading", name="Shares").count() == 1
    assert faults(tab) == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_rule_is_broken_by_the_report_of_a_study(scheme, tab, faults, workspace):
    tab.emulate_media(color_scheme=scheme)
    tab.set_content((workspace / SESSION / "analysis/report.html").read_text(encoding="utf-8"))
    tab.evaluate("document.querySelectorAll('details').forEach((folded) => (folded.open = true))")
    assert tab.get_by_role("columnheader", name="95 % interval").first.is_visible()
    assert faults(tab) == []
