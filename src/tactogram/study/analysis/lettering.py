"""Fonts for names in figures: matplotlib's own has no Japanese."""

from __future__ import annotations

from collections.abc import Iterable

from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, fontManager, get_font
from matplotlib.text import Text

OWN = "DejaVu Sans"
"""Comes with matplotlib."""
JAPANESE = (
    *("Noto Sans CJK JP", "Noto Sans JP", "IPAexGothic", "IPAGothic", "TakaoGothic", "VL Gothic"),
    *("Hiragino Sans", "Yu Gothic", "Meiryo", "MS Gothic"),
)
"""Fonts of Linux, macOS and Windows, if they are installed."""


def font_with(texts: Iterable[str]) -> str | None:
    """Return an installed font that has all letters of some texts, matplotlib's own before others; None if none has."""
    letters = {ord(letter) for text in texts for letter in text}
    for font in (OWN, *JAPANESE):
        if font in fontManager.get_font_names() and letters <= set(
            get_font(findfont(FontProperties(family=font))).get_charmap()
        ):
            return font
    return None


def letter(figure: Figure, font: str) -> None:
    """Write what stands in a figure with matplotlib's own font, and with another what that has not."""
    for text in figure.findobj(Text):
        if isinstance(text, Text):
            text.set_fontfamily([OWN, font] if font != OWN else [OWN])
