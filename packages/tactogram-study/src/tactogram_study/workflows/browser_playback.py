"""Displays that a participant's browser can stand in for."""

from __future__ import annotations

from tactogram.errors import ParameterError
from tactogram.rendering import Display, open_display, shipped

BROWSER_RATES = (8000, 96_000)
"""Rates that every browser plays, Hz (Web Audio API, createBuffer); beyond them Firefox refuses."""


def check_browser(display: Display) -> None:
    """Raise `ParameterError` for a drive that is not in parts of full scale, or whose rate browsers do not play."""
    if not plays_in_browser(display):
        low, high = BROWSER_RATES
        usable = ", ".join(known for known in shipped() if plays_in_browser(open_display(known)))
        raise ParameterError(
            f"a browser plays parts of full scale at {low} to {high} Hz, {display.name} takes {display.unit} at "
            f"{display.rate:g} Hz: give a display such as {usable}, or played_by = 'server'"
        )


def plays_in_browser(display: Display) -> bool:
    """Return whether `check_browser` accepts a display."""
    low, high = BROWSER_RATES
    return display.unit == "1" and low <= display.rate <= high and display.rate % 1 == 0
