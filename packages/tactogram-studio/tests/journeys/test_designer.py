"""A haptic designer: from a few words, or a photograph, to files for six engines."""

import json

import numpy as np

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
