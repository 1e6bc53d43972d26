"""Displays as they are listed and shown."""

import json

from tactogram.cli import main


def said(capsys, *arguments):
    """Run a verb with ``--json`` and return what it says."""
    assert main([*map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_displays_are_listed_and_shown(capsys, tmp_path):
    listed = said(capsys, "displays")
    assert listed["voice-coil"]["family"] == "linear"
    assert "path" not in listed
    shown = said(capsys, "displays", "voice-coil", "--set", "limit=2.5")
    assert shown["limit"] == 2.5
    assert shown["levels"] == ["physical", "sensation", "gain", "peak"]
    assert said(capsys, "displays", "audio")["levels"] == ["gain", "peak"]
    assert main(["displays"]) == 0
    assert "string-tablet" in capsys.readouterr().out
