"""Photographs drawn as touch, kept with their signals, so that the page Touch shows where they are felt."""

from __future__ import annotations

from tactogram.rendering import SPEED_MM_S, fade_window, photo_to_touch, slopes_of
from tactogram.signal import Image, Signal
from tactogram.signal.io import decode_image_metadata
from tactogram_studio.workspace.shelf import KeptResult, ResultArchive
from tactogram_studio.workspace.uploads import read_uploaded_image

EDGE_MM = 1.0
"""From each side of a photograph, over which its relief fades: beside it, the pad shows it again."""


def keep_drawn(shelf: ResultArchive, name: str, data: bytes, *, width_mm: float) -> KeptResult:
    """Draw a photograph (a file's bytes) by `photo_to_touch`, and keep the signal with it.

    Raises `DataError` or `ParameterError` if it is not a picture, or its middle shows no contrast.
    """
    signal = photo_to_touch(read_uploaded_image(name, data, width_mm=width_mm))
    simulated = bool(decode_image_metadata(data, name=name).get("simulated"))
    facts = {"drawn_from": name, "width_mm": width_mm, "speed_mm_s": SPEED_MM_S, "simulated": simulated}
    return shelf.keep(signal, title=f"{name}, drawn", facts=facts, photograph=data)


def relief_of(photograph: Image) -> Signal:
    """Return the slopes along a photograph's middle row, over displacement, with ends that meet."""
    slopes = slopes_of(photograph)
    return slopes.with_samples(slopes.samples * fade_window(len(slopes), round(EDGE_MM * slopes.rate)))
