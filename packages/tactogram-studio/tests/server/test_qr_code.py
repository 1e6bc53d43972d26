import io
import re
import sys
from urllib.parse import unquote

import pytest

from tactogram_studio.server.listening import svg_qr_code, terminal_qr_code
from tactogram_studio.serving import shown_qr_code

segno = pytest.importorskip("segno")

ADDRESS = "https://192.0.2.7:8123/join/abcdefghijklmnopqrstuv"


def test_the_terminal_shows_the_modules_that_the_code_has():
    drawn = terminal_qr_code(ADDRESS, 80)
    lines = [re.fullmatch("\x1b\\[40;97m([█▀▄ ]+)\x1b\\[0m", line)[1] for line in drawn.splitlines()]
    light = []
    for line in lines:
        light += [[c in "█▀" for c in line], [c in "█▄" for c in line]]
    expected = [[not dark for dark in row] for row in segno.make_qr(ADDRESS, error="l").matrix_iter(border=4)]
    assert light[: len(expected)] == expected


def test_where_a_terminal_is_too_narrow_there_is_none():
    width = len(terminal_qr_code(ADDRESS, 80).splitlines()[0]) - len("\x1b[40;97m\x1b[0m")
    assert terminal_qr_code(ADDRESS, width)
    assert terminal_qr_code(ADDRESS, width - 1) == ""


def test_the_picture_is_dark_on_light_and_asks_no_other_host():
    kind, _, data = svg_qr_code(ADDRESS).partition(",")
    svg = unquote(data)
    assert kind.startswith("data:image/svg+xml")
    assert ("fill='#fff'" in svg, "stroke='#000'" in svg) == (True, True)
    assert re.findall("https?://[^'\"]*", svg) == ["http://www.w3.org/2000/svg"]


@pytest.mark.parametrize(
    ("encoding", "terminal", "shown"),
    [("utf-8", True, True), ("utf-8", False, False), ("euc_jp", True, False)],
)
def test_only_a_terminal_that_has_its_characters_shows_it(monkeypatch, encoding, terminal, shown):
    screen = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    monkeypatch.setattr(screen, "isatty", lambda: terminal)
    monkeypatch.setattr(sys, "stdout", screen)
    monkeypatch.setenv("COLUMNS", "120")
    assert bool(shown_qr_code(ADDRESS)) == shown
