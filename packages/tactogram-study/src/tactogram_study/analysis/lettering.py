"""Fonts for names in figures: matplotlib's default has no Chinese or Japanese."""

from __future__ import annotations

from collections.abc import Iterable

from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, fontManager, get_font
from matplotlib.text import Text

DEFAULT_FONT = "DejaVu Sans"
"""Part of matplotlib."""
EAST_ASIAN = (
    *("Noto Sans CJK JP", "Noto Sans JP", "IPAexGothic", "IPAGothic", "TakaoGothic", "VL Gothic"),
    *("Hiragino Sans", "Yu Gothic", "Meiryo", "MS Gothic"),
    *("Noto Sans CJK SC", "Noto Sans SC", "WenQuanYi Zen Hei", "PingFang SC", "Microsoft YaHei", "SimHei"),
)
"""Fonts of Linux, macOS and Windows, where installed."""


def font_with(texts: Iterable[str]) -> str | None:
    """Return an installed font with all letters of the texts, matplotlib's default first; None if there is none."""
    letters = {ord(letter) for text in texts for letter in text}
    for font in (DEFAULT_FONT, *EAST_ASIAN):
        if font in fontManager.get_font_names() and letters <= set(
            get_font(findfont(FontProperties(family=font))).get_charmap()
        ):
            return font
    return None


def letter(figure: Figure, font: str) -> None:
    """Set the fonts of a figure's texts: matplotlib's default, and another for the letters that it lacks."""
    for text in figure.findobj(Text):
        if isinstance(text, Text):
            text.set_fontfamily([DEFAULT_FONT, font] if font != DEFAULT_FONT else [DEFAULT_FONT])
