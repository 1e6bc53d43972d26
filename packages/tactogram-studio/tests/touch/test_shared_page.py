"""A page saved from Touch works as a file: without the studio, without a network."""

import json

import pytest

VOICES = "studio/first/voices"
HEARD = "() => window.tactogramTouch.report.rms"


@pytest.fixture
def saved(tab, tmp_path):
    """Give the file that the page Touch saves with two textures."""
    tab.goto("/touch")
    for count in (1, 2):
        tab.wait_for_function(f"() => window.tactogramTouch?.rows.tables().length === {count}")
        if count == 1:
            tab.get_by_role("button", name="Add a texture").click()
    with tab.expect_download() as download:
        tab.get_by_role("link", name="Save as one page").click()
    assert download.value.suggested_filename == "touch artificial-grass and cork-sheet.html"
    path = tmp_path / "touch.html"
    download.value.save_as(path)
    return path


@pytest.fixture
def alone(browser, saved):
    """Give the saved file in a browser without a network, and fail on its errors and requests."""
    context = browser.new_context(offline=True)
    page = context.new_page()
    wrong = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda entry: wrong.append(entry.text))
    page.on("request", lambda request: wrong.append(request.url) if request.url != saved.as_uri() else None)
    page.goto(saved.as_uri())
    page.wait_for_selector("#touch[data-ready=true]")
    yield page
    context.close()
    assert wrong == []


def test_it_is_felt_from_a_disk(alone, faults):
    assert alone.get_by_role("heading", level=1).inner_text() == "Touch artificial-grass and cork-sheet"
    assert "What is felt here is simulated." in alone.locator("footer").inner_text()
    assert faults(alone) == []
    alone.locator("#touch-begin").click()
    alone.get_by_role("button", name="Simulated hand").click()
    alone.wait_for_function("() => window.tactogramTouch.report.rms > 0.1")
    assert alone.evaluate("() => window.tactogramTouch.sound.threaded")


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("no JSON", "open the page Touch again: its state could not be read"),
        ({"rows": []}, "share 1 to 4 textures at a time, got 0"),
        (
            {"rows": [{"key": json.dumps(["run", "../x", "y"]), "lay": "auto", "speed": None}]},
            "../x: lies outside of the workspace",
        ),
    ],
)
def test_what_cannot_be_shared_is_refused_in_a_line(tab, rows, message):
    tab.goto("/touch")
    text = rows if isinstance(rows, str) else json.dumps(rows)
    answer = tab.request.get("/touch/shared", params={"rows": text})
    assert answer.status == 400
    assert message in answer.json()["error"]
