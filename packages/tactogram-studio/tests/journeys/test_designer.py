"""A haptic designer: from words, a photograph or a file of another program to files for engines."""

import json

import numpy as np
import pytest

from tactogram.rendering.files.reading import read_haptic
from tactogram.signal import Image
from tactogram.signal.io import write_image

FILES = {
    "box.ahap": "",
    "box.haptic": "",
    "box.hjif": "",
    "envelope.json": "android_envelope",
    "pattern.json": "vibration",
    "pad.json": "gamepad",
}


def test_words_become_files_for_six_engines(tactogram, tmp_path, step):
    with step("words to a vibration"):
        said = tactogram("generate texture_flow --text grater --speed 120 --seconds 2 --out box.wav")
    assert "described: " in said
    with step("the vibration to six files"):
        for name, format in FILES.items():
            said = tactogram(f"convert box.wav {name}" + (f" --format {format}" if format else ""))
            assert "Verdict: " in said, name
    with step("a file at once"):
        tactogram("generate texture_flow --material silk --speed 80 --seconds 2 --out silk.ahap")
    for name in (*FILES, "silk.ahap"):
        tactogram(f"convert --check {name}")
    signal = read_haptic(tmp_path / "box.haptic").signal
    assert 1.9 < signal.seconds < 2.1
    assert max(json.loads((tmp_path / "pattern.json").read_text())["pattern"]) > 0


def test_a_photograph_becomes_files_for_six_engines(tactogram, tmp_path, step):
    bricks = 90 + 90 * (np.arange(1200) % 300 < 20)
    pixels = np.broadcast_to(bricks[None, :, None], (900, 1200, 3))
    write_image(tmp_path / "bricks.png", Image(pixels.astype(np.uint8)))
    with step("a photograph to six files"):
        for name, format in FILES.items():
            said = tactogram(f"convert bricks.png {name}" + (f" --format {format}" if format else ""))
            assert "Verdict: " in said, name
            assert "no prediction of how the material feels" in said
    for name in FILES:
        tactogram(f"convert --check {name}")
    pulses = read_haptic(tmp_path / "envelope.json").signal.samples[0]
    quiet, loud = pulses[round(0.12 * 8000) : round(0.2 * 8000)], pulses[round(0.24 * 8000) :][:400]
    assert np.abs(loud).max() > 5 * np.abs(quiet).max()  # a joint every quarter of a second, else nothing


def test_a_model_without_photographs_says_what_to_do_with_one(tactogram, tmp_path):
    (tmp_path / "photo.jpg").write_bytes(b"")
    said = tactogram("generate texture_flow --image photo.jpg --out photo.ahap", status=1)
    assert len(said.splitlines()) == 1
    assert "tactogram convert photo.jpg" in said
    assert not (tmp_path / "photo.ahap").exists()


AHAP = """{
  "Version": 1.0,
  "Metadata": {"Project": "Doorbell", "Created": "12 May 2024"},
  "Pattern": [
    {"Event": {"Time": 0.0, "EventType": "HapticTransient", "EventParameters": [
      {"ParameterID": "HapticIntensity", "ParameterValue": 0.8},
      {"ParameterID": "HapticSharpness", "ParameterValue": 0.4}]}},
    {"Event": {"Time": 0.1, "EventType": "HapticContinuous", "EventDuration": 0.5, "EventParameters": [
      {"ParameterID": "HapticIntensity", "ParameterValue": 0.5},
      {"ParameterID": "HapticSharpness", "ParameterValue": 0.2}]}}
  ]
}"""


def test_a_file_of_another_program_is_edited_and_written_for_an_engine(page, saved, step, tmp_path):
    (tmp_path / "doorbell.ahap").write_text(AHAP)
    with step("words on the first page open an effect"):
        page.goto("/")
        page.get_by_label("A surface or an effect, in English").fill("heartbeat")
        page.get_by_role("button", name="Make it").click()
        page.get_by_role("heading", level=1, name="Edit").wait_for()
        page.wait_for_selector("#timeline[data-drawn]")
    with step("written for an engine"):
        page.get_by_label("Format").click()
        page.get_by_role("option", name=".haptic").click()
        file = saved(page.get_by_role("button", name="Download", exact=True))
    beats = json.loads(file.read_text())
    assert beats["version"]["major"] == 1
    assert beats["signals"]["continuous"]["envelopes"]["amplitude"][-1]["time"] > 0.1
    with step("a file of another program is opened"):
        page.get_by_role("button", name="New").click()
        page.get_by_text("Empty. Choose a ready effect").wait_for()
        page.locator("input[type=file]").set_input_files(tmp_path / "doorbell.ahap")
        page.get_by_role("group", name="Track 1: doorbell").wait_for()
    with step("and a tap is added at its end"):
        page.get_by_role("button", name="Tap", exact=True).click()
        page.get_by_role("group", name="Track 2: Tap").wait_for()
        file = saved(page.get_by_role("button", name="Download", exact=True))
    found = json.loads(file.read_text())["signals"]["continuous"]["envelopes"]["amplitude"]
    emphases = [point["time"] for point in found if "emphasis" in point]
    assert len(emphases) == 2
    assert emphases[0] == 0
    assert emphases[1] == pytest.approx(0.7, abs=0.02)  # the cursor stands 0.1 s after the buzz
    assert max(point["time"] for point in found) == pytest.approx(0.7, abs=0.1)
