import json
import re
import signal
import urllib.error
import urllib.request

import numpy as np
import pytest

from tactogram.datasets import open_store
from tactogram.signal import Image
from tactogram.signal.io import read_signal, write_image

ARGUMENTS = ("studio", "--port", "0", "--no-open", "--folder", ".")


PAGES = ("Make", "Touch", "Edit", "Materials", "Train", "Send", "Live", "Studies", "Reports")


WIDTH = "document.fonts.ready.then(() => document.documentElement.scrollWidth)"


@pytest.fixture(scope="module")
def empty(tmp_path_factory):
    """Give an empty folder."""
    return tmp_path_factory.mktemp("empty")


@pytest.fixture(scope="module")
def running(empty, served):
    """Give process and address of a studio started in an empty folder."""
    with served(*ARGUMENTS, folder=empty, prefix="studio: ") as found:
        yield found


@pytest.fixture(scope="module")
def server(running):
    """Give the address of a studio started in an empty folder."""
    return running[1]


def test_an_empty_workspace_gets_example_surfaces(tab, empty):
    tab.goto("/")
    tab.get_by_text("Preparing example surfaces").wait_for()
    tab.get_by_role("link", name="0 runs").wait_for()
    tab.get_by_role("button", name="Touch them").wait_for(timeout=120_000)
    tab.get_by_role("link", name="1 run", exact=True).wait_for()
    tab.get_by_role("link", name="1 store", exact=True).wait_for()
    voices = json.loads((empty / "studio/first/voices/data.json").read_text())
    assert voices["simulated"] is True
    speeds = {info.speed_mm_s for info in open_store(empty / "studio/first/surfaces").index}
    assert len(speeds) == 3  # a texture can follow the hand's speed


def test_a_surface_in_words_is_made_at_once(tab):
    tab.goto("/")
    words = tab.get_by_label("A surface or an effect, in English")
    words.fill("xyzzy")
    words.press("Enter")
    tab.get_by_text("The words must name a material or an effect that is known").wait_for()
    assert words.input_value() == "xyzzy"
    words.fill("wet lego bricks")
    tab.get_by_role("button", name="Make it").click()
    made = tab.get_by_role("heading", name="wet lego bricks: studded-plastic, seed 0")
    made.wait_for()
    assert tab.evaluate("location.pathname + location.search").startswith("/make?key=")
    tab.reload()
    made.wait_for()
    assert made.count() == 1
    assert tab.get_by_label("Describe it in English").input_value() == "wet lego bricks"
    tab.get_by_text("Understood: studded-plastic; not understood: wet.").wait_for()
    with tab.expect_download() as download:
        tab.get_by_role("button", name=re.compile("Download wet lego bricks")).click()
        tab.get_by_role("menuitem", name="WAV", exact=True).click()
    assert download.value.suggested_filename == "wet-lego-bricks-studded-plastic-seed-0-listening.wav"


def test_an_effect_in_words_is_opened_to_edit(tab):
    tab.goto("/")
    words = tab.get_by_label("A surface or an effect, in English")
    words.fill("Heart beat")
    words.press("Enter")
    tab.get_by_role("heading", level=1, name="Edit").wait_for()
    assert tab.get_by_label("Title").input_value() == "Heart beat"
    with tab.expect_download() as download:
        tab.get_by_role("button", name="Download").click()
    assert download.value.suggested_filename == "Heart-beat.ahap"
    tab.goto("/")
    words.fill("rain on a tent")
    words.press("Enter")
    tab.get_by_text("Understood: rain; not understood: tent.").wait_for()
    assert words.input_value() == "rain on a tent"
    tab.get_by_role("button", name="Open it on the page Edit").click()
    tab.get_by_role("heading", level=1, name="Edit").wait_for()
    assert tab.get_by_label("Title").input_value() == "rain on a tent"


def test_a_photograph_is_drawn_as_a_relief_to_touch(tab, empty, tmp_path):
    ribs = 128 + 90 * np.sin(2 * np.pi * np.arange(400) / 20)
    pixels = np.broadcast_to(ribs[None, :, None], (100, 400, 3))
    write_image(tmp_path / "ribs.png", Image(pixels.astype(np.uint8)))
    (tmp_path / "words.png").write_text("no picture")
    tab.goto("/")
    chooser = tab.locator("input[type=file][accept='image/*']")
    chooser.set_input_files(tmp_path / "words.png")
    tab.get_by_role("alert").get_by_text("words.png: not a readable picture").wait_for()
    tab.get_by_label("Width that it shows, mm").fill("200")
    chooser.set_input_files(tmp_path / "ribs.png")
    tab.get_by_role("application", name="Surface. Photograph ribs.png, drawn.").wait_for()
    signal = read_signal(max((empty / "studio/kept").glob("*/signal.npz")))
    assert signal.seconds == pytest.approx(2.0)  # 200 mm at 100 mm/s
    spectrum = np.abs(np.fft.rfft(signal.samples[0]))
    assert np.argmax(spectrum) / signal.seconds == pytest.approx(10)  # a rib every 10 mm


def test_a_dropped_photograph_is_drawn_and_no_import(tab, tmp_path):
    tab.goto("/")
    tab.evaluate("""async () => {
      const canvas = document.createElement("canvas");
      canvas.getContext("2d").fillRect(50, 0, 100, 150);
      const picture = await new Promise((done) => canvas.toBlob(done));
      const carried = new DataTransfer();
      carried.items.add(new File([picture], "edge.png", {type: "image/png"}));
      document.querySelector("[data-receive]").dispatchEvent(
        new DragEvent("drop", {dataTransfer: carried, bubbles: true, cancelable: true}));
    }""")
    tab.get_by_role("application", name="Surface. Photograph edge.png, drawn.").wait_for()


def test_a_run_that_was_trained_with_photographs_is_offered(tab, empty, until):
    until((empty / "studio/first/voices/model.json").is_file)
    (empty / "studio/first/voices/photographs.json").write_text("{}")
    tab.goto("/")
    link = tab.get_by_role("link", name="Predict it from a photograph, with studio/first/voices")
    assert link.get_attribute("href") == "/make?run=studio/first/voices"


def test_keyboard_and_navigation_lead_to_every_page_on_a_tablet(tab, empty, until):
    tab.set_viewport_size({"width": 820, "height": 1180})  # a tablet: nothing may be wider than the screen
    tab.goto("/")
    tab.keyboard.press("Tab")
    tab.keyboard.press("Enter")
    assert tab.evaluate("document.activeElement.id") == "content"
    assert tab.evaluate(WIDTH) <= 820
    for name in PAGES:
        tab.get_by_role("navigation", name="Pages").get_by_role("link", name=name, exact=True).click()
        tab.get_by_role("heading", level=1, name=name).wait_for()
        assert tab.locator("nav [aria-current=page]").all_inner_texts() == [name]
        assert tab.evaluate(WIDTH) <= 820, name
    # What pages store per browser lies in the workspace, written with a delay.
    until(lambda: list((empty / "studio/state").glob("storage-user-*.json")))
    assert not list(empty.glob(".nicegui"))


def test_a_door_can_be_pressed_anywhere(tab):
    tab.goto("/")
    tab.get_by_text("Ask people what they feel").click(force=True)  # the link lies over it
    tab.get_by_role("heading", level=1, name="Studies").wait_for()


PLAYED = """() => {
  window.played = new Set();
  const note = ({target}) => target.ariaPressed === "true" && played.add(target.dataset.playerUrl);
  const observer = new MutationObserver((changes) => changes.forEach(note));
  observer.observe(document.body, {subtree: true, attributes: true, attributeFilter: ["aria-pressed"]});
}"""
"""Collects the addresses that play as their buttons are marked, since a click is over within 30 ms."""


def test_an_example_is_heard_and_moves_at_a_press(tab, until):
    tab.goto("/")
    tab.evaluate(PLAYED)
    for title in ("Sandpaper", "A photograph", "Click", "Heartbeat"):
        tab.get_by_role("button", name=f"Play: {title}").click()
        name = title.rpartition(" ")[2].lower()
        until(lambda name=name: tab.evaluate(f"played.has('/examples/{name}.wav')"))
    dot = tab.locator("[data-player-head$='heartbeat.wav']")
    until(lambda: 0 < float(dot.evaluate("dot => dot.style.getPropertyValue('--at')")) < 1)
    tab.get_by_role("button", name="Play: Heartbeat", pressed=True).click()
    tab.get_by_role("button", name="Play: Heartbeat", pressed=False).wait_for()
    tab.get_by_role("button", name="Edit it").first.click()
    tab.get_by_role("heading", level=1, name="Edit").wait_for()
    assert tab.get_by_label("Title").input_value() == "Heartbeat"


def test_the_header_is_one_line_on_a_phone(tab):
    tab.set_viewport_size({"width": 390, "height": 844})
    tab.goto("/reports")
    header = tab.locator("header.bar").bounding_box()
    assert header["height"] <= 64
    current = tab.locator("nav [aria-current=page]").bounding_box()
    assert current["x"] + current["width"] <= 390  # the current page comes first
    assert tab.evaluate(WIDTH) <= 390


def test_dark_or_light_is_as_the_system_until_chosen_and_remembered(tab):
    tab.emulate_media(color_scheme="dark")
    tab.goto("/")
    tab.wait_for_selector(".body--dark")
    tab.get_by_role("button", name="Light or dark").click()
    tab.get_by_role("menuitemradio", name="Light").click()
    tab.wait_for_selector(".body--light")
    tab.goto("/studies")
    tab.get_by_role("heading", level=1, name="Studies").wait_for()
    tab.wait_for_selector(".body--light")
    tab.get_by_role("button", name="Light or dark").click()
    tab.get_by_role("menuitemradio", name="Light", checked=True).wait_for()


def test_an_unknown_page_is_not_found(server):
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(f"{server}/nothing", timeout=60)


def test_an_interrupt_ends_the_server(running):  # the last: the others need it
    process, _ = running
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60) == 0
