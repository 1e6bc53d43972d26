"""Sounds and pictures of answers, kept beside results for the page."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from tactogram.signal import Image, Signal
from tactogram.signal.io import atomic_write, write_signal

RECORDED = "recorded"
REAL_FOLDER = "recorded-data"
"""Of samples made from recorded data, whose licences differ: kept apart, so that results can be shared without."""


def save_shown(
    out: Path, task: str, model: str, shown: Mapping[str, Signal | Image], *, simulated: bool
) -> None:
    """Write answers to ``OUT/TASK/shown/MODEL/ITEM.flac`` or ``.png``, and what was recorded to ``…/recorded``.

    Those of recorded data go to ``OUT/recorded-data/TASK``.
    """
    folder = (out if simulated else out / REAL_FOLDER) / task / "shown"
    for name, content in shown.items():
        item = name.removesuffix(f" {RECORDED}")
        place = folder / (model if item == name else RECORDED) / re.sub(r"[^\w.=+-]+", "_", item)
        if isinstance(content, Image):
            from PIL import Image as Picture

            with atomic_write(place.with_name(place.name + ".png")) as part:
                Picture.fromarray(content.pixels).save(part)
        else:
            write_signal(place.with_name(place.name + ".flac"), content)
