"""JSON document of a texture: for `<tactogram-pad>` in any page, and for engines.

It holds the table that the studio's own pad plays, and the picture of the surface. Version 1, as JSON values:

- ``format`` ("tactogram-texture"), ``version``, ``name``, ``simulated``, ``notes`` (what of strokes is limited)
- ``kind``: noise, autoregressive or surface; ``follows`` in words; ``unit`` of the samples
- ``rate``: of the audio, Hz; ``peak``, ``rms`` and ``level`` under a simulated hand, in ``unit``
- ``arrays``: by name ``type`` (float64, float32, int16) and ``values``. All kinds have ``vibration``: the amplitude of
  the sine with the texture's power in the felt band, in ``unit``; of a surface at each ``vibration_step_mm`` of its
  ``length_mm``, of the others at each of ``speeds`` (mm/s) and, fastest, ``forces`` (N)
- ``picture``: ``webp`` (base64), ``kind`` (photograph, rendered or drawn), ``mm_per_pixel`` (null: it fills the pad),
  ``words`` (a description), ``line`` (the row that is felt, as a share of the height; null: all)
"""

from __future__ import annotations

import base64
import json
from typing import Any

from tactogram_studio.touch.pictures import PadPicture
from tactogram_studio.touch.tables import TouchTexture

FORMAT, VERSION = "tactogram-texture", 1


def texture_document(table: TouchTexture, picture: PadPicture) -> str:
    """Return the document of a texture, with numbers from which the same bits are read again."""
    arrays: dict[str, Any] = {}
    for name, array in table.arrays.items():
        # Of float32 the shortest decimals, not those of the double.
        values = [float(str(value)) for value in array] if array.dtype == "float32" else array.tolist()
        arrays[name] = {"type": array.dtype.name, "values": values}
    shown = {
        "webp": base64.b64encode(picture.webp).decode(),
        "kind": picture.kind,
        "mm_per_pixel": picture.mm_per_pixel,
        "words": picture.words,
        "line": picture.line,
    }
    facts = {"format": FORMAT, **table.head, "version": VERSION, "arrays": arrays, "picture": shown}
    return json.dumps(facts, ensure_ascii=False, separators=(",", ":")) + "\n"
