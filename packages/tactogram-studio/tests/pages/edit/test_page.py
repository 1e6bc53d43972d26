import json
from urllib.parse import urlsplit

import numpy as np
import pytest

from tactogram.rendering.files import read_haptic
from tactogram.signal import Signal
from tactogram_studio.effects.effect import effect_from_json, track_of
from tactogram_studio.workspace.shelf import ResultArchive

READY = "#timeline[data-drawn]"


def opened(tab, address="/edit"):
    tab.goto(address)
    tab.wait_for_selector(READY)
    return tab.get_by_role("region", name="Timeline")


def press(tab, name):
    """Click a button, and wait until the server's answer is drawn."""
    before = int(tab.locator("#timeline").get_attribute("data-drawn"))
    tab.get_by_role("button", name=name, exact=True).click()
    tab.wait_for_function(f"Number(document.getElementById('timeline').dataset.drawn) > {before}")


def item(tab, name):
    return tab.get_by_role("slider", name=name, exact=True)


def saved(workspace):
    """Return the newest effect of the workspace."""
    path = sorted((workspace / "studio" / "effects").iterdir())[-1] / "effect.json"
    return effect_from_json(path.read_text(), where="saved")


def downloaded(tab, folder):
    with tab.expect_download() as download:
        tab.get_by_role("button", name="Download", exact=True).click()
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def test_a_double_tap_and_a_fading_buzz_are_drawn_undone_and_written(tab, workspace, tmp_path):
    opened(tab)
    press(tab, "Double tap")
    press(tab, "Buzz")
    press(tab, "Fade in")
    press(tab, "Undo")
    press(tab, "Fade out")
    dot = tab.locator('[data-focus="item 1 amplitude 1"]')
    x, y = (
        dot.bounding_box()[key] + dot.bounding_box()[side] / 2
        for key, side in (("x", "width"), ("y", "height"))
    )
    lane = tab.locator('[data-lane="1 amplitude"]').bounding_box()
    tab.mouse.move(x, y)
    tab.mouse.down()
    tab.mouse.move(x, y - 100, steps=4)  # to full amplitude
    tab.mouse.up()
    tab.wait_for_function(
        "document.querySelector('[data-focus=\"item 1 amplitude 1\"]').getAttribute('aria-valuenow') === '1'"
    )
    assert lane["height"] > 50
    tab.get_by_role("button", name="Play Double tap").click()
    tab.wait_for_function("tactogramPlayer.state().url.startsWith('/edit/sound/')")
    path = downloaded(tab, tmp_path)
    assert path.name == "Double-tap.ahap"
    track = track_of(read_haptic(path).events, "Read")
    assert [(one.time, round(one.amplitude, 3)) for one in track.transients] == [(0, 0.8), (0.12, 1.0)]
    assert [round(one.frequency) for one in track.transients] == [230, 230]
    at = np.array([0.2, 0.25, 0.5, 0.7])
    drawn = np.interp(at, [p.time for p in track.amplitude], [p.value for p in track.amplitude])
    assert drawn == pytest.approx([0, 0.99, 0.485, 0.081], abs=0.03)
    tab.get_by_text("Verdict: ").wait_for()
    tab.get_by_text("To feel it on a phone, stop the studio and start it").wait_for()
    tab.get_by_role("button", name="Play As the file plays it").wait_for()
    assert saved(workspace).tracks[1].amplitude[1].value == 1.0

    tab.reload()  # the effect is still there, its history is not
    tab.wait_for_selector('[data-focus="item 1 amplitude 1"]')
    assert tab.get_by_role("button", name="Undo").is_disabled()


def test_two_tabs_do_not_overwrite_each_other(tab, workspace):
    opened(tab)
    press(tab, "Tap")
    tab.wait_for_url("**/edit?effect=*")  # the address leads to this effect, whatever other tabs open
    other = tab.context.new_page()
    other.goto(tab.url)
    other.wait_for_function("() => window.did_handshake")
    other.wait_for_selector('[data-focus="item 0 transients 0"]')
    press(other, "Buzz")
    other.get_by_role("group", name="Track 2: Buzz").wait_for()

    press(tab, "Warning")
    tab.get_by_text("Another tab has changed this effect").wait_for()
    tab.get_by_role("group", name="Track 2: Buzz").wait_for()
    assert [track.title for track in saved(workspace).tracks] == ["Tap", "Buzz"]
    press(tab, "Undo")
    tab.get_by_role("group", name="Track 2: Warning").wait_for()
    assert [track.title for track in saved(workspace).tracks] == ["Tap", "Warning"]

    other.evaluate("dispatchEvent(new Event('focus'))")
    other.get_by_role("group", name="Track 2: Warning").wait_for()
    other.close()


def test_everything_works_by_keys(tab, workspace):
    opened(tab, "/edit?effect=none")
    tab.get_by_text("it was deleted: choose another").wait_for()
    press(tab, "Ramp up")
    point = item(tab, "Amplitude point 2 of 3")
    item(tab, "Amplitude point 1 of 3").focus()
    tab.keyboard.press("PageDown")
    tab.wait_for_function("document.activeElement.getAttribute('aria-label') === 'Amplitude point 2 of 3'")
    for key in ("ArrowLeft", "ArrowLeft", "ArrowDown", "Shift+ArrowDown"):
        tab.keyboard.press(key)
    tab.wait_for_function("document.activeElement.getAttribute('aria-valuetext') === '0.57 s, 0.94'")
    tab.keyboard.press("Enter")
    item(tab, "Amplitude point 3 of 4").wait_for()
    tab.keyboard.press("Delete")
    point.wait_for()
    item(tab, "Cursor").focus()
    tab.keyboard.press("Home")
    for _ in range(5):
        tab.keyboard.press("Shift+ArrowRight")
    tab.get_by_label("To, s").wait_for()
    tab.wait_for_function("document.activeElement.getAttribute('aria-valuetext') === '0 to 0.05 s selected'")
    press(tab, "Clear")
    tab.keyboard.press("Control+z")
    point.wait_for()
    [track] = saved(workspace).tracks
    assert [(p.time, p.value) for p in track.amplitude] == [(0, 0), (0.57, 0.94), (0.6, 0)]


def test_a_hand_draws_an_amplitude_and_sets_transients(tab, workspace):
    opened(tab)
    tab.get_by_role("button", name="New").click()
    tab.get_by_text("Empty. Choose a ready effect").wait_for()
    press(tab, "Add a track")
    tab.get_by_role("button", name="Draw", exact=True).click()
    tab.locator('#timeline[data-tool="draw"]').wait_for()
    box = tab.locator('[data-lane="0 amplitude"]').bounding_box()
    tab.mouse.move(box["x"] + 40, box["y"] + box["height"] - 4)
    tab.mouse.down()
    tab.mouse.move(box["x"] + 200, box["y"] + 2, steps=10)
    tab.mouse.up()
    tab.locator('[data-item="amplitude"]').nth(1).wait_for()
    tab.get_by_role("button", name="Add transients").click()
    tab.locator('#timeline[data-tool="transient"]').wait_for()
    tab.mouse.click(box["x"] + 300, box["y"] + box["height"] / 2)
    tab.locator('[data-item="transients"]').wait_for()
    [track] = saved(workspace).tracks
    assert track.amplitude[0].value == 0
    assert track.amplitude[-1].value == 1
    assert track.transients[0].time > track.amplitude[-1].time
    assert track.transients[0].amplitude == pytest.approx(0.5, abs=0.02)


def test_a_kept_result_and_a_file_become_tracks_and_a_kept_effect_stays_one(tab, workspace):
    shelf = ResultArchive(workspace / "studio" / "kept")
    tone = np.sin(2 * np.pi * 120 * np.arange(4000) / 8000).astype(np.float32)
    kept = shelf.keep(Signal(3 * tone, 8000, "m/s^2"), title="Tone", facts={"simulated": True})
    opened(tab, f"/edit?of=kept:{kept.id}")
    tab.get_by_role("group", name="Track 1: Tone", exact=False).last.wait_for()
    tab.get_by_role("region", name="Effect").get_by_text("simulated", exact=True).wait_for()
    press(tab, "Tap")
    tab.get_by_role("button", name="Keep").click()
    tab.get_by_text("is kept: it is on the pages").wait_for()
    made = shelf.all()[0]
    assert made.facts["simulated"]
    assert [track["title"] for track in json.loads(made.facts["effect"])["tracks"]][-2:] == ["Tone", "Tap"]
    pattern = {"name": "mine.json", "mimeType": "application/json", "buffer": b"[100, 50, 100]"}
    tab.locator("input[type=file]").set_input_files(pattern)
    tab.get_by_text("here for 100, 50, 100 ms").wait_for()
    assert saved(workspace).tracks[-1].title == "mine"
    broken = {"name": "mine.ahap", "mimeType": "application/json", "buffer": b"{}"}
    tab.locator("input[type=file]").set_input_files(broken)
    tab.get_by_text("mine.ahap: not valid AHAP").wait_for()


def test_a_phone_plays_the_file_without_the_token(browser, workspace, served, faults, tmp_path):
    arguments = ("studio", "--port", "0", "--no-open", "--folder", ".", "--host", "0.0.0.0")
    with served(*arguments, folder=workspace, prefix="studio: ") as (_, address):
        parts = urlsplit(address)
        root = f"http://127.0.0.1:{parts.port}"
        desk = browser.new_context(accept_downloads=True)
        page = desk.new_page()
        page.goto(f"{root}/edit?{parts.query}")
        page.wait_for_selector(READY)
        press(page, "Warning")
        downloaded(page, tmp_path)
        link = page.get_by_role("link", name="/feel/")
        link.wait_for()
        page.get_by_role("img", name="QR code").wait_for()
        felt = urlsplit(link.get_attribute("href"))
        assert f"{felt.scheme}://{felt.netloc}" == f"{parts.scheme}://{parts.netloc}"
        phone = browser.new_context(viewport={"width": 390, "height": 844})
        mine = phone.new_page()
        mine.add_init_script("window.asked = []; navigator.vibrate = (p) => { asked.push(p); return true; };")
        mine.goto(f"{root}{felt.path}")
        mine.get_by_role("button", name="Play").click()
        mine.get_by_text("can only switch the phone's motor on and off").wait_for()
        assert faults(mine) == []
        [pattern] = mine.evaluate("asked")
        shown = mine.locator("#pattern").inner_text()
        assert shown == "On and off, ms: " + " · ".join(map(str, pattern))
        assert mine.goto(f"{root}/edit").status == 401
        assert mine.goto(f"{root}/feel/20260101-000000-000000~x").status == 404
        desk.close()
        phone.close()
