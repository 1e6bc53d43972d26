"""What every page sends to a browser without a cache, and the memory of a server that has served them all."""

import os
import re
import sys
from pathlib import Path

from benchmarks.bench_studio import (
    CHART_KB,
    MOST_KB,
    MOST_MB,
    PAGES,
    kilobytes_sent,
    megabytes,
    wait_until_idle,
)
from benchmarks.bench_touch import served
from fontTools.ttLib import TTFont

import tactogram_studio


def test_pages_are_small_and_so_is_a_server_at_rest(browser, tmp_path, monkeypatch):
    """With the example surfaces of an empty folder."""
    monkeypatch.delenv("PYTEST_CURRENT_TEST")  # NiceGUI compresses nothing in a test
    serving = served(tmp_path)
    with serving as address:
        sent = {path: kilobytes_sent(browser, address, path) for path in PAGES}
        sent["/make"] -= CHART_KB
        assert {path: kb for path, kb in sent.items() if kb > MOST_KB} == {}
        assert min(sent.values()) > 100  # it was all counted
        wait_until_idle(serving.pid)
        if sys.platform == "linux" and "COVERAGE_PROCESS_CONFIG" not in os.environ:
            assert megabytes(serving.pid) < MOST_MB


def test_the_font_of_icons_has_those_that_pages_name():
    """It is cut from NiceGUI's Material Icons, which pages would otherwise load whole."""
    studio = Path(tactogram_studio.__path__[0])
    named = re.compile(r'icon(?:_button)?(?:=|\()"([a-z_]+)"|: \("([a-z_]+)", [0-9.]+\)')
    icons = {
        name for path in studio.rglob("*.py") for found in named.findall(path.read_text()) for name in found
    }
    assert {"contrast", "zoom_in", "delete"} < icons
    assert icons - {""} <= ligatures(studio / "static" / "icons.woff")


def ligatures(font):
    """Return the texts that a font draws as one sign."""
    loaded = TTFont(font)
    letters = {glyph: chr(code) for code, glyph in loaded.getBestCmap().items()}
    return {
        "".join(letters[glyph] for glyph in (first, *ligature.Component))
        for lookup in loaded["GSUB"].table.LookupList.Lookup
        for table in lookup.SubTable
        for first, several in getattr(table, "ExtSubTable", table).ligatures.items()
        for ligature in several
    }
