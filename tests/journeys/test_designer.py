"""A haptic designer: from a few words to files for six engines."""

import json

from tactogram.rendering.files.conversion import read_haptic

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


def test_a_photograph_of_hers_is_answered_in_a_line(tactogram, tmp_path):
    (tmp_path / "photo.jpg").write_bytes(b"")
    said = tactogram("generate texture_flow --image photo.jpg --out photo.ahap", status=1)
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "photo.ahap").exists()
