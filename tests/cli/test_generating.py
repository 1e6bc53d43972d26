"""What is printed of generated files: limits, and what a file keeps."""

import json

import pytest

from tactogram.cli import main
from tactogram.signal.io import read_metadata

FASTEST = "it counts as 399.7 mm/s"


def test_a_limited_speed_is_in_the_result_the_file_and_a_note(tmp_path, capsys):
    told = ["generate", "texture_flow", "--material", "corduroy", "--seconds", "0.5", "--json", "--quiet"]
    out = tmp_path / "fast.wav"
    assert main([*told, "--speed", "600", "--out", str(out)]) == 0
    printed = capsys.readouterr()
    [row] = json.loads(printed.out)["files"]
    assert row["limited"] == [f"speed 600 mm/s is outside of what was recorded: {FASTEST}"]
    assert read_metadata(out)["limited"] == row["limited"]
    assert printed.err == f"note: {row['limited'][0]}\n"
    assert main([*told, "--speed", "400", "--out", str(out)]) == 0
    printed = capsys.readouterr()
    assert "limited" not in json.loads(printed.out)["files"][0]
    assert "limited" not in read_metadata(out)
    assert printed.err == ""


@pytest.mark.parametrize("suffix", [".ahap", ".haptic", ".hjif"])
def test_words_are_generated_straight_into_a_haptic_file(suffix, tmp_path, capsys):
    out = tmp_path / f"rough{suffix}"
    assert main(["generate", "texture_flow", "--words", "rough=6", "--seconds", "1", "--out", str(out)]) == 0
    assert "The file keeps " in capsys.readouterr().out
    assert main(["convert", "--check", str(out)]) == 0
