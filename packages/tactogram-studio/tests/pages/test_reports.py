import json
import re

import pytest

from tactogram.evaluation.report import ReportSection, ReportText, write_report

REPORT = """<!doctype html><title>Report</title><h1>A report</h1>
<script>document.title = "it ran"; parent.document.title = "it ran"; fetch("/stolen")</script>
<img src="data:image/gif;base64,R0lGODlhAQABAAAAACw=" alt="a figure">"""


@pytest.fixture(scope="module", name="run")
def run_fixture(workspace):
    """Give a run on simulated data, with numbers and a report that contains a script."""
    run = workspace / "runs" / "nine"
    run.mkdir(parents=True)
    (run / "recipe.toml").write_text('model = "stroke_cnn"\n')
    (run / "data.json").write_text('{"simulated": true}')
    (run / "report.html").write_text(REPORT)
    (run / "evaluation.json").write_text(json.dumps({"recording_accuracy": 0.9444, "recordings": 18}))
    return run


def test_a_report_is_shown_without_running_its_scripts(tab, run):
    tab.goto("/reports")
    tab.frame_locator("iframe.report").get_by_role("heading", name="A report").wait_for()
    assert tab.title() == "Reports · tactogram"
    # The browser logs that it blocked the script; any other error still fails.
    blocked = [text for text in tab.wrong if "sandbox" in text or "Content Security Policy" in text]
    assert blocked == tab.wrong
    tab.wrong.clear()
    reader = tab.get_by_role("region", name="Reader")
    reader.get_by_text("simulated data").wait_for()
    tab.get_by_role("button", name="evaluation.json").click()
    reader.get_by_text("0.9444").wait_for()
    tab.wait_for_url("**/reports?of=runs/nine/evaluation.json")
    tab.reload()
    reader.get_by_text("0.9444").wait_for()
    tab.go_back()
    tab.frame_locator("iframe.report").get_by_role("heading", name="A report").wait_for()
    tab.wrong.clear()
    tab.get_by_label("Search").first.fill("no such report")
    tab.get_by_text("No report matches.").wait_for()


@pytest.mark.usefixtures("run")
def test_a_report_is_served_with_a_policy_against_scripts(tab):
    answer = tab.request.get("/reports/file/runs/nine/report.html")
    policy = answer.headers["content-security-policy"]
    assert answer.ok
    assert "sandbox" in policy
    assert "default-src 'none'" in policy
    assert "script-src" not in policy
    for path in ("..%2Fserver.log", "runs/nine/recipe.toml", "studio/state/secret", "%2Fetc%2Fpasswd"):
        assert tab.request.get(f"/reports/file/{path}").status in (400, 404)


def test_published_figures_can_be_searched(tab):
    tab.goto("/reports?tab=published")
    panel = tab.get_by_role("region", name="Published and ours")
    panel.get_by_role("table").wait_for()
    panel.get_by_label("Search").fill("stroke_cnn 30 classes 100 mm/s")
    panel.get_by_role("status").get_by_text(re.compile(r"^1 of ")).wait_for()
    row = panel.get_by_role("row").nth(1).inner_text()
    assert "89" in row
    assert "Table II" in row
    assert "simulated" in row


def test_a_report_is_light_or_dark_as_the_page_whatever_the_system_is(tab, workspace):
    folder = workspace / "runs" / "styled"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "recipe.toml").write_text('model = "stroke_cnn"\n')
    section = ReportSection("Findings", [ReportText("A text")])
    write_report(folder / "report.html", title="Styled", summary="", sections=[section], simulated=True)
    body = tab.frame_locator("iframe.report").locator("body")

    def ground(choice, query):
        tab.get_by_role("button", name="Light or dark").click()
        tab.get_by_role("menuitemradio", name=choice).click()
        tab.locator(f'iframe.report[src$="report.html{query}"]').wait_for()
        body.get_by_role("heading", name="Styled").wait_for()
        return body.evaluate("body => getComputedStyle(body).backgroundColor")

    light, dark = "rgb(255, 255, 255)", "rgb(18, 24, 28)"
    tab.emulate_media(color_scheme="light")
    tab.goto("/reports?of=runs/styled/report.html")
    assert ground("Dark", "?scheme=dark") == dark
    assert ground("As the system", "") == light
    tab.emulate_media(color_scheme="dark")
    assert ground("As the system", "") == dark
    assert ground("Light", "?scheme=light") == light
