"""Band matching: strengths of bands in recordings, and in signals generated for their conditions."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from tactogram.model import Condition, Example
from tactogram.signal.band_levels import BandLevels
from tactogram.training.seeds import child_seed

RECORDINGS = 16
"""Most recordings of a material that the bands are matched to."""


Generate = Callable[[int, Condition, int, int], NDArray[np.floating]]
"""From the place of a material, a condition, a length in samples and a seed to (axis, time)."""


def match_bands(
    levels: BandLevels,
    examples: Sequence[Example],
    materials: Sequence[str],
    *,
    longest: int,
    generate: Generate,
) -> None:
    """Measure ``levels`` of recordings, up to ``longest`` samples of each, and of signals of their conditions."""
    levels.measure(
        _to_match(
            levels, [e for e in examples if e.material == name], place, longest=longest, generate=generate
        )
        for place, name in enumerate(materials)
    )


def _to_match(
    levels: BandLevels, examples: Sequence[Example], place: int, *, longest: int, generate: Generate
) -> tuple[list[NDArray[np.floating]], list[NDArray[np.floating]]]:
    """Return recordings of a material and a generated signal for each, all longer than the filters."""
    examples = [e for e in examples if len(e.signal) > 2 * levels.reach] or examples
    recorded, made = [], []
    for number, example in enumerate(examples[:: -(-len(examples) // RECORDINGS)]):
        x = example.signal.samples[:, :longest]
        length = max(x.shape[1], 2 * levels.reach + 1)
        recorded.append(np.pad(x, ((0, 0), (0, length - x.shape[1])), mode="wrap"))
        made.append(generate(place, example.condition, length, child_seed(0, "match", place, number)))
    return recorded, made
