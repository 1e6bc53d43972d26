import io
import sys

import pytest

from tactogram_studio.serving import shown_qr_code

ADDRESS = "https://192.0.2.7:8123/join/abcdefghijklmnopqrstuv"


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
