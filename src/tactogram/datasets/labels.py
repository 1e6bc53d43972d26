"""Class labels of recordings."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from tactogram.datasets.ratings.ratings import item_of
from tactogram.datasets.recording import RecordingInfo
from tactogram.errors import ParameterError

Label = Literal["material", "material+contactor", "item"] | Callable[[RecordingInfo], str | None]
"""Class of a recording: its material; material and contactor, as ``"carpet1-pen"``; what is rated, which may be a
single vibration of no material; or the value of a function."""


def label_of(info: RecordingInfo, label: Label) -> str | None:
    """Return the class of one recording, None if it has none.

    ``"material+contactor"`` gives the 30 classes of Saga et al. (Table I); a recording without a contactor has its
    material's class.
    """
    if callable(label):
        return label(info)
    if label == "material":
        return info.material
    if label == "item":
        return item_of(info)
    if label == "material+contactor":
        return "-".join(part for part in (info.material, info.contactor) if part) or None
    raise ParameterError(
        f"label must be 'material', 'material+contactor', 'item' or a function, got {label!r}"
    )
