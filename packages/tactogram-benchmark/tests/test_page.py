"""The page of results, in a browser."""

import os
import shutil

import numpy as np
import pytest
from made_up_results import table

from tactogram.signal import Signal
from tactogram_benchmark.page import html
from tactogram_benchmark.result import save_shown
from tactogram_benchmark.table import markdown

PLAYED = """() => Promise.all([...document.querySelectorAll("[data-sound]")].map(button => new Promise(done => {
    const sound = new Audio("data:audio/flac;base64," + button.dataset.sound);
    sound.oncanplaythrough = () => done("played");
    sound.onerror = () => done(sound.error.message);
})))"""


BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """Give a browser with the page of two tasks, one simulated."""
    found = os.environ.get("TACTOGRAM_BROWSER") or next(filter(None, map(shutil.which, BROWSERS)), None)
    if not found:
        pytest.skip("no browser: install Chromium (Debian: apt install chromium)")
    folder = tmp_path_factory.mktemp("page")
    wave = Signal(np.sin(np.arange(2000) / 5)[None].astype(np.float32), 1000.0, "m/s^2")
    shown = {"felt": wave, "felt recorded": wave}
    save_shown(folder, "strokes-generate", "far", shown, simulated=True)
    tables = [
        table("lmt108-generate", {"near": 0.1, "far": 0.6, "middle": 0.3}),
        table("strokes-generate", {"far": 0.6, "other": 0.2}),
    ]
    (folder / "page.html").write_text(html(tables, [folder]), encoding="utf-8")
    playwright = pytest.importorskip("playwright.sync_api").sync_playwright().start()
    browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox", "--disable-gpu"])
    opened = browser.new_page()
    problems = []
    opened.on("pageerror", lambda error: problems.append(str(error)))
    opened.on("request", lambda sent: problems.append(sent.url) if sent.url.startswith("http") else None)
    opened.goto((folder / "page.html").as_uri())
    yield opened
    browser.close()
    playwright.stop()
    assert problems == []


def test_a_click_sorts_and_another_turns_the_order(page):
    section = page.locator("#lmt108-generate")
    models = section.locator("tbody td:nth-child(2) code")
    assert models.all_inner_texts() == ["near", "middle", "far"]
    section.get_by_role("button", name="model").click()
    assert models.all_inner_texts() == ["far", "middle", "near"]
    section.get_by_role("button", name="model").click()
    assert models.all_inner_texts() == ["near", "middle", "far"]
    section.get_by_role("button", name="value").click()
    assert models.all_inner_texts() == ["near", "middle", "far"]


def test_recorded_and_simulated_data_are_filtered(page):
    page.get_by_label("simulated", exact=True).check()
    assert not page.locator("#lmt108-generate").is_visible()
    assert page.locator("#strokes-generate").is_visible()
    page.get_by_label("all data").check()
    page.get_by_label("model").select_option("middle")
    assert page.locator("#lmt108-generate").is_visible()
    assert not page.locator("#strokes-generate").is_visible()
    assert page.locator("nav tbody tr:visible").count() == 1
    page.get_by_label("model").select_option("")
    assert page.locator("nav tbody tr:visible").count() == 2
    assert page.locator("#strokes-generate").is_visible()


def test_sounds_are_beside_the_recording(page):
    section = page.locator("#strokes-generate")
    section.get_by_text("Hear models beside the recording").click()
    assert section.get_by_role("button", name="play").count() == 2
    assert section.get_by_role("button", name="play recorded, felt").is_visible()
    assert page.evaluate(PLAYED) == ["played", "played"]  # recorded at 1 kHz, which browsers refuse


def test_what_was_not_trained_says_why(page):
    section = page.locator("#lmt108-generate")
    assert section.get_by_text("Without a result: slow, not trained within 1 minute.").is_visible()
    page.get_by_label("model").select_option("slow")
    assert section.is_visible()
    page.get_by_label("model").select_option("")
    text = markdown([table("lmt108-generate", {"near": 0.1})])
    assert "Without a result:\n\n- `slow`: not trained within 1 minute" in text


def test_a_model_that_is_no_better_than_random_is_marked():
    one = table("lmt108-generate", {"random": 0.3, "near": 0.1, "far": 0.6})
    text = markdown([one])
    assert "| `far` (no use of its input shown) |" in text
    assert "| `random` (copies, ignores what is given) |" in text
    assert "| `near` |" in text
    page = html([one], [])
    assert '<code>far</code><span class="about"> (no use of its input shown)</span>' in page
    assert "<strong>shows no use of its input</strong>" in page
    assert "<code>random</code> and <code>mean</code>" in page
