"""A psychologist: a study of her own from a shipped one, up to her first participant's answers, in pages alone."""

import csv
import io
import json
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest

from tactogram.signal import Signal
from tactogram_studio.workspace.shelf import ResultArchive
from tactogram_study.study_file import Study

TABLET = {"width": 1180, "height": 820}
AHEAD = """{
  const now = performance.now.bind(performance);
  performance.now = () => now() + (window.ahead ?? 0);
}"""
KEPT = json.dumps({"px_per_mm": 5.0, "screen": "820x1180@1"})


@pytest.fixture
def kept(workspace):
    rng = np.random.default_rng(0)
    signal = Signal(rng.standard_normal(800).astype(np.float32) / 5, 8000.0, "m/s^2")
    return ResultArchive(Path(workspace) / "studio" / "kept").keep(signal, title="My cork", facts={})


@pytest.fixture
def participant(browser, server, watched):
    """Give a second browser's page, on a screen that was matched with a card."""
    context = browser.new_context(base_url=server, viewport=TABLET)
    context.add_init_script(f"localStorage.setItem('tactogram.screen', '{KEPT}')")
    context.add_init_script(AHEAD)
    with watched(context, server) as page:
        yield page
    context.close()


def edit(tab, name, own):
    tab.goto("/studies")
    tab.get_by_role("button", name=f"Make your own from {name}").click()
    tab.get_by_label("Name of your study").fill(own)
    tab.get_by_role("button", name="Copy and edit").click()
    tab.wait_for_url(f"**/studies/edit?study=studies/{own}.toml")
    tab.get_by_role("status").filter(has_text="Valid").wait_for()


def choose(tab, label, option):
    tab.get_by_role("dialog").get_by_role("combobox", name=label, exact=True).click()
    tab.get_by_role("option", name=option).click()


def later(page, press):
    """Press what leads to the next page, later than a double click on the page before."""
    page.evaluate("() => { window.ahead = (window.ahead ?? 0) + 300; }")
    page.locator(press).click()


def answer_trial(page, number):
    form = f'form[data-token="trial-{number}.1"]'
    page.wait_for_selector(form)
    page.click("[data-play]")
    page.wait_for_selector(".player.playing", state="detached")
    for question in page.locator(f"{form} [data-key]").all():
        question.locator('label:has(input[value="5"])').click()
    later(page, ".foot button")
    page.wait_for_selector(form, state="detached")


def test_a_study_of_her_own_is_made_previewed_begun_taken_and_exported(
    tab, workspace, kept, participant, step
):
    tab.context.add_init_script(AHEAD)
    with step("a shipped study becomes her own"):
        edit(tab, "display-words", "my_words")
        tab.get_by_label("Title", exact=True).fill("How does it feel?")
        for word in ("uneven", "rough"):
            tab.get_by_label(word, exact=True).fill(f"{word} to the finger")
        tab.get_by_label("Number of items").fill("1")
        tab.get_by_text("Up to 5 trials, 5 stimuli; about").wait_for()
        tab.get_by_role("button", name="List them one by one").click()
        tab.get_by_role("button", name="Change plate01/sensor").click()
        choose(tab, "Signal", "A kept result")
        choose(tab, "Kept result", "My cork")
        tab.get_by_role("dialog").get_by_text(
            re.compile(r"^file my_words_stimuli/My_cork-.*, 1 s$")
        ).wait_for()
        tab.get_by_role("button", name="Done").click()
    with step("a trial is previewed"):
        with tab.context.expect_page() as opened:
            tab.get_by_role("link", name="Preview a trial").click()
        preview = opened.value
        preview.get_by_role("heading", name="Preview").wait_for()
        assert "code" not in preview.locator("body").inner_text().lower()
        later(preview, ".moment button.primary")
        preview.get_by_text("rough to the finger").wait_for()
        preview.close()
    with step("a session begins, and somebody is enrolled"):
        tab.get_by_role("button", name="Save and begin a session").click()
        tab.get_by_role("button", name="Begin", exact=True).click()
        tab.wait_for_url("**/experiment/sessions~my_words")
        assert (
            Study.load(Path(workspace) / "studies/my_words.toml").title.in_language("en")
            == "How does it feel?"
        )
        tab.get_by_label("Code (empty: random)").fill("K7")
        tab.get_by_role("button", name="Enrol").click()
    with step("the first participant agrees and answers"):
        participant.goto(tab.get_by_role("link", name="Open their pages").get_attribute("href"))
        participant.get_by_role("heading", name="Let's begin").wait_for()
        later(participant, ".moment button.primary")
        participant.locator('label:has(input[value="agreed"])').click()
        later(participant, ".foot button")
        participant.locator(".sound-test").wait_for()
        later(participant, ".moment > button.primary")
        for number in (1, 2):
            answer_trial(participant, number)
        tab.get_by_role("row", name="K7").get_by_text("trial 3 of 5").wait_for()
    with step("her tables"), tab.expect_download() as packed:
        tab.get_by_role("button", name="Download tables (ZIP)").click()
    with zipfile.ZipFile(packed.value.path()) as held:
        [name] = [name for name in held.namelist() if name.endswith(".csv") and "." not in Path(name).stem]
        rows = list(csv.DictReader(io.TextIOWrapper(held.open(name), "utf-8")))
    trials = [row for row in rows if row["design"] == "rating"]
    assert {row["study"] for row in rows} == {"my_words"}
    assert len(trials) == 2 * 10
    assert {row["answer"] for row in trials} == {"5"}
