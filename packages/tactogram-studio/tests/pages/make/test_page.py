"""The page Make in a browser: mix, generate, play, keep, compare, undo, reload; photographs, words, bad input."""

import json

import numpy as np
import pytest
import soundfile
from PIL import Image as Pillow

from tactogram.datasets import Ratings, Recording, create_store
from tactogram.datasets.ratings.words import WORDS
from tactogram.signal import Signal
from tactogram.signal.io import read_signal
from tactogram_studio.generation.form import word_label
from tactogram_studio.workspace.folder import Workspace


@pytest.fixture(scope="module")
def photo_run(workspace):
    """Add a run conditioned on photographs."""
    from tactogram.workflows.training.train import train

    train(
        "nearest_photo",
        workspace / "studio/first/surfaces",
        recipe="tiny",
        split="all",
        out=workspace / "runs/by-photo",
    )
    return workspace


@pytest.fixture(scope="module")
def words_run(workspace):
    """Add a run conditioned on the ten words, trained for a second on noise with random ratings."""
    from tactogram.workflows.training.train import train

    rng = np.random.default_rng(0)
    plates = [
        Recording(
            streams={"strain": Signal(rng.normal(size=(4, 720)), 600.0, "V", tuple("abcd"))},
            material=f"plate{plate}",
            source=f"plate{plate}/{number}",
            simulated=True,
        )
        for plate in range(2)
        for number in range(4)
    ]
    drives = [
        Recording(
            streams={"drive": Signal(rng.normal(size=(1, 400)), 400.0, "1", ("drive",))},
            labels={"item": f"drive{number}"},
            source=f"drive{number}",
            simulated=True,
        )
        for number in range(4)
    ]
    items = ["plate0", "plate1", *(f"drive{number}" for number in range(4))]
    rows = [(rater, item, word) for item in items for rater in ("r1", "r2") for word in WORDS]
    ratings = Ratings(*zip(*rows, strict=True), rng.integers(1, 8, len(rows)).astype(float))
    store = workspace / "data/by-words"
    create_store(store, plates + drives, name="drawn", licence="-", simulated=True, ratings=ratings)
    train("ultrasonic_cgan", store, recipe="tiny", split="all", out=workspace / "runs/by-words")


SHARES = "all => [...document.querySelectorAll('.sliders .share')].map((s) => s.innerText).join() "
"""Reads the labels of the sliders; a comparison follows."""


def generate(tab):
    """Press Generate."""
    tab.get_by_role("button", name="Generate", exact=True).click()


def test_mix_generate_play_keep_compare_undo_and_reload(tab, workspace):
    tab.goto("/make")
    tab.wait_for_selector("[data-map-handle]")  # the first to need torch

    # The map by keyboard: towards a corner, and back by undo. Each key press is a step to wait for.
    tab.locator("[data-map-handle]").focus()
    shares = tab.locator(".sliders .share").all_inner_texts()
    for key in ("Shift+ArrowRight", "Shift+ArrowDown", "Shift+ArrowDown"):
        tab.keyboard.press(key)
        tab.wait_for_function(SHARES + "!== all.join()", arg=shares)
        shares = tab.locator(".sliders .share").all_inner_texts()
    tab.wait_for_function(
        "() => !document.querySelector('[aria-label=\"Undo the last change of the form\"]').disabled"
    )
    assert sum(float(text.rstrip(" %")) for text in shares) == pytest.approx(100, abs=2)
    assert 1 <= sum(text != "0 %" for text in shares) <= 3

    generate(tab)
    card = tab.locator(".signal").first
    card.get_by_text("m/s² rms").wait_for()
    assert "detection threshold" in card.inner_text()
    assert card.locator(".simulated").count() == 1
    tab.locator(".signal canvas").nth(1).wait_for()
    tab.wait_for_function("() => document.querySelector('.spectrogram img').naturalWidth === 640")

    # Play: the level is shown.
    card.locator(".player").click()
    tab.wait_for_function("() => window.tactogramPlayer.state().place > 0.02")
    assert "of full scale per m/s²" in card.locator("[data-player-status]").inner_text()
    tab.keyboard.press("Escape")
    assert tab.evaluate("window.tactogramPlayer.state().url") == ""

    # Keep: the facts are stored with the result.
    card.get_by_role("button", name="Keep").click()
    card.get_by_role("link", name="Send").wait_for()
    (kept,) = (Workspace.at(workspace).studio_folder / "kept").glob("2*")
    facts = json.loads((kept / "facts.json").read_text())
    assert facts["run"] == "studio/first/voices"
    assert facts["simulated"] is True
    assert facts["command"].startswith("tactogram generate studio/first/voices --mix ")

    # Compare with recordings on the same scales, switching between them while playing.
    tab.get_by_role("button", name="Nearest recordings").click()
    tab.wait_for_function("() => document.querySelectorAll('.compared > .signal').length === 3")
    assert "recording" in tab.locator(".signal").nth(1).inner_text()
    tab.get_by_role("switch", name="At their true strengths").click()
    tab.wait_for_function("() => document.querySelectorAll('[data-player-url*=\"gain=\"]').length === 3")
    urls = [one.get_attribute("data-player-url") for one in tab.locator("[data-player-url]").all()]
    assert len({url.split("gain=")[1] for url in urls}) == 1
    tab.locator("h1").click()
    tab.keyboard.press("1")
    tab.wait_for_function("() => window.tactogramPlayer.state().place > 0.05")
    tab.keyboard.press("3")
    tab.wait_for_function("url => window.tactogramPlayer.state().url === url", arg=urls[2])
    assert tab.evaluate("window.tactogramPlayer.state().place") >= 0.05
    tab.keyboard.press("Escape")

    # Undo, redo; a reload loses nothing.
    tab.get_by_role("button", name="Undo the last change of the form").click()
    tab.wait_for_function(SHARES + "!== all.join()", arg=shares)
    tab.get_by_role("button", name="Redo").click()
    tab.wait_for_function(SHARES + "=== all.join()", arg=shares)
    tab.reload()
    tab.wait_for_selector("[data-map-handle]")
    tab.wait_for_function("() => document.querySelectorAll('.compared > .signal').length === 3")
    assert tab.locator(".sliders .share").all_inner_texts() == shares


def test_a_link_starts_no_work(tab, workspace):
    stored = workspace / "studio" / "made"
    before = set(stored.glob("*"))
    tab.goto("/make?run=studio/first/voices&generate=true")
    tab.get_by_text("Press Generate to see and play a result here.").wait_for()
    generate(tab)
    tab.locator(".signal").first.wait_for()
    assert len(set(stored.glob("*")) - before) == 1  # what the button made


def test_each_tab_keeps_its_form_and_result_through_a_reload(tab):
    tab.goto("/make?run=studio/first/voices")
    seed = tab.get_by_role("spinbutton", name="Seed")
    seed.fill("41")
    seed.press("Tab")
    generate(tab)
    tab.get_by_role("heading", name="seed 41").wait_for()
    tab.wait_for_url("**/make?key=*")
    other = tab.context.new_page()
    other.goto("/make?run=texture_flow")
    other.wait_for_function("() => window.did_handshake")
    other.get_by_role("spinbutton", name="Seed").fill("7")
    other.get_by_role("spinbutton", name="Seed").press("Tab")
    generate(other)
    other.get_by_role("heading", name="seed 7").wait_for()

    tab.reload()
    tab.get_by_role("heading", name="artificial-grass, seed 41").wait_for()
    assert tab.get_by_role("combobox", name="Run").input_value().startswith("example surfaces")
    assert seed.input_value() == "41"
    tab.goto("/send")
    tab.get_by_role("heading", level=1, name="Send").wait_for()
    tab.go_back()
    tab.get_by_role("heading", name="artificial-grass, seed 41").wait_for()
    tab.get_by_role("button", name="seed 7").wait_for()  # among the earlier results, whichever tab made it
    other.close()


def test_a_result_on_a_phone_is_scrolled_to_announced_and_can_be_downloaded(tab, tmp_path):
    tab.set_viewport_size({"width": 390, "height": 844})
    tab.goto("/make")
    assert tab.locator(".make-results").bounding_box()["y"] > 844
    generate(tab)
    tab.get_by_role("status").get_by_text("is generated.").wait_for(state="attached")
    tab.wait_for_function(
        "() => Math.abs(document.querySelector('.make-results').getBoundingClientRect().top) < 2"
    )
    assert tab.evaluate("document.documentElement.scrollWidth") == 390
    tab.get_by_role("button", name="Download").click()
    with tab.expect_download() as started:
        tab.get_by_role("menuitem", name="WAV, 32-bit float").click()
    started.value.save_as(tmp_path / "made.wav")
    assert read_signal(tmp_path / "made.wav").unit == "m/s^2"
    tab.get_by_role("button", name="Download").click()
    tab.get_by_role("group", name="For an engine").get_by_role("menuitem", name="iOS: AHAP").wait_for()
    with tab.expect_download() as started:
        tab.get_by_role("group", name="For listening").get_by_role("menuitem").click()
    started.value.save_as(tmp_path / "heard.wav")
    assert soundfile.info(tmp_path / "heard.wav").samplerate == 48_000
    tab.get_by_text("is for listening alone: it loses its strength").wait_for()


def test_a_photograph_is_dropped_cropped_and_used(tab, photo_run, tmp_path):
    pixels = np.random.default_rng(0).integers(0, 255, (90, 120, 3), np.uint8)
    Pillow.fromarray(pixels).save(tmp_path / "stone.png")
    tab.goto("/make?run=runs/by-photo")
    tab.wait_for_selector("[data-drop]")

    # A missing photograph and a file that is not a picture are refused with a reason.
    generate(tab)
    tab.get_by_text("This model needs a photograph").wait_for()
    upload = tab.locator("input[type=file]").first
    upload.set_input_files({"name": "no.png", "mimeType": "image/png", "buffer": b"not a picture"})
    tab.get_by_text("no.png", exact=False).first.wait_for()

    # Dropped with a pointer.
    data = list((tmp_path / "stone.png").read_bytes())
    tab.evaluate(
        """data => {
          const held = new DataTransfer();
          held.items.add(new File([new Uint8Array(data)], 'stone.png', {type: 'image/png'}));
          const drop = document.querySelector('[data-drop]');
          drop.dispatchEvent(new DragEvent('drop', {dataTransfer: held, bubbles: true, cancelable: true}));
        }""",
        data,
    )
    tab.wait_for_function("() => document.querySelector('[data-crop] img')?.naturalWidth === 120")
    box = tab.locator("[data-crop]").bounding_box()
    tab.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 0.25 * box["height"])
    tab.mouse.down()
    tab.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 0.75 * box["height"], steps=3)
    tab.mouse.up()
    tab.get_by_role("button", name="Use the whole photograph").wait_for()

    generate(tab)
    made = tab.locator(".signal", has_text="stone").first
    made.wait_for()
    # Noise is no surface: the result says so, and which material it was taken for.
    assert "Photograph unlike anything the run was trained on" in made.inner_text()
    assert "classified as " in made.inner_text()
    (part,) = (photo_run / "studio" / "photos").glob("stone-*-part-*.png")
    rows, columns = np.array(Pillow.open(part)).shape[:2]
    assert abs(rows - 45) <= 2
    assert abs(columns - 60) <= 2
    tab.get_by_text("Equivalent command").click()
    assert f"--image studio/photos/{part.name}" in tab.locator(".code").inner_text()


def test_a_description_is_the_material_named_or_refused(tab):
    tab.goto("/make?run=texture_flow")
    field = tab.get_by_label("Describe it in English")
    field.fill("xyzzy")
    field.press("Enter")
    tab.get_by_text("text must name a material or an effect that is known").wait_for()
    assert field.input_value() == "xyzzy"
    field.fill("Wet corrugated cardboard")
    field.press("Enter")
    tab.locator("[data-material='corrugated-cardboard']").wait_for()
    assert tab.locator(".sliders .share").first.inner_text() == "100 %"
    tab.get_by_text("Understood: corrugated-cardboard; not understood: wet.").wait_for()
    assert field.input_value() == "Wet corrugated cardboard"
    field.fill("car engine")
    field.press("Enter")
    tab.get_by_text("Understood: engine.").wait_for()
    assert field.input_value() == "car engine"
    tab.get_by_role("button", name="Open it on the page Edit").click()
    tab.get_by_role("heading", level=1, name="Edit").wait_for()
    assert tab.get_by_label("Title").input_value() == "car engine"


@pytest.mark.usefixtures("words_run")
def test_words_are_ticked_scored_and_used(tab):
    tab.goto("/make?run=runs/by-words")
    tab.locator("[data-word]").nth(9).wait_for()
    labels = tab.locator(".sliders.words .q-checkbox").all_inner_texts()
    assert labels == [" ".join(word_label(word).split()) for word in WORDS]
    shares = tab.locator(".sliders .share")
    assert shares.all_inner_texts() == ["mean"] * 10

    slider = tab.get_by_role("slider", name="Score of rough")  # the element that the keyboard reaches
    slider.press("PageUp")
    tab.wait_for_function("() => document.activeElement.ariaValueNow === '5'")
    assert slider.evaluate("slider => slider === document.activeElement")
    tab.get_by_role("checkbox", name="sticky").click()
    rough, sticky = (list(WORDS).index(word) for word in ("rough", "sticky"))
    tab.wait_for_function(
        "() => [...document.querySelectorAll('.share')].filter((s) => s.innerText !== 'mean').length === 2"
    )
    assert (shares.nth(rough).inner_text(), shares.nth(sticky).inner_text()) == ("5.0", "4.0")

    generate(tab)
    card = tab.locator(".signal").first
    card.get_by_text("no unit").first.wait_for()
    assert card.locator(".simulated").count() == 1
    tab.get_by_text("Equivalent command").click()
    assert "--words rough=5,sticky=4 --rest mean" in tab.locator(".code").inner_text()


def test_bad_input_is_refused_and_the_page_keeps_working(tab):
    tab.goto("/make?run=studio/first/voices")
    tab.wait_for_selector("[data-map-handle]")
    speed = tab.get_by_label("Speed, mm/s")
    speed.fill("-5")
    speed.press("Tab")

    generate(tab)
    tab.get_by_text("speed_mm_s must be finite and >= 0, got -5").wait_for()

    speed.fill("")
    speed.press("Tab")
    generate(tab)
    tab.locator(".signal").first.wait_for()
    for path in (
        "/signals/0000/sound.wav",
        "/make/photo/..%2Fsecret",
        "/make/image/kept/..",
        "/make/image/x/y",
    ):
        assert tab.request.get(path).status in (400, 403, 404), path
