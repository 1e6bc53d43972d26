"""Concatenative synthesis: texture made of random segments of recordings, joined by crossfades.

References
----------
- Schwarz, D. (2011). State of the art in sound texture synthesis. Proc. 14th Int. Conf. Digital Audio Effects
  (DAFx-11).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tactogram.signal.joining import extend
from tactogram.signal.signal import Signal


def excerpts(
    signals: Sequence[Signal], budget: int, *, segment: int, least: int, rng: np.random.Generator
) -> list[tuple[int, Signal]]:
    """Return a random interval of each of some ``signals``, with its index, together about ``budget`` samples.

    As many signals are drawn as there is room for a segment of each; budget left by short ones goes to longer ones. An
    interval has at least ``least`` samples.
    """
    number = min(len(signals), max(1, budget // segment))
    chosen = sorted(rng.permutation(len(signals))[:number], key=lambda i: len(signals[i]))
    kept = []
    for place, i in enumerate(chosen):
        length = min(len(signals[i]), max(least, budget // (number - place)))
        start = int(rng.integers(len(signals[i]) - length + 1))
        budget -= length
        kept.append((int(i), signals[i].cut(start, start + length)))
    return kept


def concatenated(
    recordings: Sequence[Signal],
    *,
    seconds: float,
    segment: int,
    overlap_s: float,
    search_s: float,
    rng: Callable[[int], np.random.Generator],
) -> Signal:
    """Return ``seconds`` of random segments of ``recordings``, joined by `tactogram.signal.joining.extend`.

    Longer recordings are drawn from more often; a segment has ``segment`` samples, crossfades included, or those of a
    shorter recording. ``rng(k)`` is the generator of segment k.
    """
    share = np.array([len(signal) for signal in recordings], dtype=np.float64)
    share /= share.sum()

    def draw(number: int) -> Signal:
        drawn = rng(number)
        signal = recordings[int(drawn.choice(len(recordings), p=share))]
        length = min(segment, len(signal))
        start = int(drawn.integers(len(signal) - length + 1))
        return signal.cut(start, start + length)

    return extend(draw, seconds=seconds, overlap_s=overlap_s, search_s=search_s)
