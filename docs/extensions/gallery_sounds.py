"""Signals in the gallery: picture and player of each, and the front page's cards with the sound of each example."""

import base64
import re
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx_gallery.scrapers import figure_rst

from tactogram.signal import Signal
from tactogram.signal.figure import signal_figure
from tactogram.signal.listening import wav_bytes

FIRST = ("plot_first_steps", "plot_one_stroke", "plot_moving_finger")
"""Examples to begin with; the others follow by name."""
PLAYER = re.compile(r"<audio .*?</audio>")


def in_order(path: str) -> tuple[int, str]:
    """Return the key by which examples are sorted."""
    name = Path(path).stem
    return FIRST.index(name) if name in FIRST else len(FIRST), name


def scrape_signal(block: Any, variables: dict[str, Any], settings: dict[str, Any]) -> str:
    """Return a signal that is a block's last expression as reST: its facts, picture and player."""
    names = variables["example_globals"]
    signal, names["___"] = names.get("___"), None  # where sphinx-gallery keeps a last expression
    if not isinstance(signal, Signal):
        return ""
    path = next(variables["image_path_iterator"])
    figure = signal_figure(signal)
    figure.set_size_inches(9, 1.4 + 2 * len(signal.axes))
    figure.savefig(path, dpi=100)
    sound = base64.b64encode(wav_bytes(signal)).decode()
    player = f'.. raw:: html\n\n    <audio controls src="data:audio/wav;base64,{sound}"></audio>\n'
    return f"``{signal}``\n\n{figure_rst([path], settings['src_dir'], str(signal))}\n{player}\n"


def write_cards(app: Sphinx) -> None:
    """Write the examples as cards, for the front page: thumbnail, title and the last sound that it makes."""
    folder = Path(app.srcdir) / "gallery"
    cards = []
    for page in sorted(folder.glob("plot_*.rst"), key=in_order):
        text = page.read_text(encoding="utf-8")
        title = re.search(r"^(.+)\n=+$", text, re.MULTILINE)
        players = PLAYER.findall(text)
        cards += [
            f":::{{grid-item-card}} {title[1] if title else page.stem}",
            f"[![](gallery/images/thumb/sphx_glr_{page.stem}_thumb.png)](gallery/{page.stem}.rst)",
            *players[-1:],
            ":::",
        ]
    text = "\n".join(["::::{grid} 1 2 3 3", ":gutter: 3", "", *cards, "::::", ""])
    (folder / "cards.md").write_text(text, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Run after the examples, which `sphinx_gallery` runs at the same event."""
    app.connect("builder-inited", write_cards, priority=900)
    return {"parallel_read_safe": True}
