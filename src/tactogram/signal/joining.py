"""Joining of pieces to a longer signal without seams in level or waveform; texture made of random pieces of recordings.

Two pieces are crossfaded. The power of their sum depends on their correlation: gains that suit unlike pieces raise the
level of alike ones by 3 dB, gains that suit alike ones lower that of unlike ones by 3 dB. So the gains follow the
measured correlation (Fink, Holters & Zölzer 2016). Before that the second piece may slide to where it best continues
the first, as in WSOLA (Verhelst & Roelands 1993).

References
----------
- Fink, M., Holters, M. & Zölzer, U. (2016). Signal-matched power-complementary cross-fading and dry-wet mixing. Proc.
  19th Int. Conf. Digital Audio Effects (DAFx-16), 109-112.
- Schwarz, D. (2011). State of the art in sound texture synthesis. Proc. 14th Int. Conf. Digital Audio Effects
  (DAFx-11).
- Verhelst, W. & Roelands, M. (1993). An overlap-add technique based on waveform similarity (WSOLA) for high quality
  time-scale modification of speech. Proc. ICASSP, vol. 2, 554-557. doi 10.1109/ICASSP.1993.319366
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal.signal import Signal

Array = NDArray[np.float64]

LEAST_CORRELATION = -0.9
"""The level of more opposed pieces dips: compensation would take gains above 2.3."""


def join(pieces: Sequence[Signal], *, overlap_s: float, search_s: float = 0.0) -> Signal:
    """Return ``pieces`` as one signal, each crossfaded into the next; the power is kept throughout.

    The power (variance) of each axis changes smoothly from one piece to the next, whatever their correlation, as long
    as it is above `LEAST_CORRELATION`; so does the mean, such as gravity.

    ``pieces``: of one rate, unit, set of axes and domain. Each at least ``overlap_s`` + ``search_s`` long.
    ``overlap_s``: length of each crossfade, s (mm over displacement, as all lengths here); 0 puts the pieces end to
    end. ``search_s``: longest cut, s, at the beginning of each further piece, so that the rest best matches what it is
    faded into (normalised cross-correlation, summed over the axes). All axes move together.
    """
    if not pieces:
        raise ParameterError("join needs at least one piece, got none")
    return pieces[0].with_samples(np.hstack(list(_joined(pieces, overlap_s, search_s))).astype(np.float32))


def extend(
    draw: Callable[[int], Signal], *, seconds: float, overlap_s: float, search_s: float = 0.0
) -> Signal:
    """Return exactly ``seconds`` of the pieces ``draw(0)``, ``draw(1)``, …, joined as by `join`.

    It has ``round(seconds * rate)`` samples, at least one. A piece that adds nothing is a `ParameterError`.
    """
    if not (seconds > 0 and np.isfinite(seconds)):
        raise ParameterError.must("seconds", "be > 0 and finite", seconds)
    first = draw(0)
    total = max(1, round(seconds * first.rate))
    if len(first) >= total:
        return first.cut(0, total)

    def pieces() -> Iterator[Signal]:
        yield first
        number = 0
        while True:
            number += 1
            piece = draw(number)
            if len(piece) <= round(overlap_s * piece.rate) + round(search_s * piece.rate):
                raise ParameterError.must(
                    "pieces",
                    f"be longer than overlap_s + search_s, {overlap_s + search_s:g} s; got {piece.extent:g} s",
                )
            yield piece

    kept: list[Array] = []
    length = 0
    for part in _joined(pieces(), overlap_s, search_s):
        kept.append(part)
        length += part.shape[1]
        if length >= total:
            break
    return first.with_samples(np.hstack(kept)[:, :total].astype(np.float32))


def _joined(pieces: Iterable[Signal], overlap_s: float, search_s: float) -> Iterator[Array]:
    """Yield the joined signal part by part, float64 (axis, time), withholding what may still be faded."""
    for name, value in (("overlap_s", overlap_s), ("search_s", search_s)):
        if not (value >= 0 and np.isfinite(value)):
            raise ParameterError(f"{name} must be >= 0 s and finite, got {value:g}")
    first: Signal | None = None
    tail = np.empty((0, 0))
    for number, piece in enumerate(pieces):
        first = piece if first is None else first
        n, search = round(overlap_s * first.rate), round(search_s * first.rate)
        _check(number, piece, first, n + (search if number else 0))
        x = piece.samples.astype(np.float64)
        if number:
            if n:
                x = x[:, _best_lag(tail, x[:, : n + search]) :]
            x = np.hstack((_crossfade(tail, x[:, :n]), x[:, n:]))
        split = x.shape[1] - n
        if split:
            yield x[:, :split]
        tail = x[:, split:]
    if tail.shape[1]:
        yield tail


def _check(number: int, piece: Signal, first: Signal, least: int) -> None:
    got, expected = ((s.rate, s.unit, s.axes, s.domain) for s in (piece, first))
    if got != expected:
        raise ParameterError.must(
            "pieces",
            f"be of one rate, unit, set of axes and domain; piece {number} is {got[0]:g}, {got[1]}, "
            f"{','.join(got[2])} over {got[3]}, the first {expected[0]:g}, {expected[1]}, "
            f"{','.join(expected[2])} over {expected[3]}",
        )
    if len(piece) < least:
        raise ParameterError(
            f"piece {number} must have at least {least} samples for the crossfade and the search, got {len(piece)}"
        )


def _best_lag(before: Array, after: Array) -> int:
    """Return the lag at which ``after``, (axis, n + search), best matches ``before``, (axis, n).

    It has the highest normalised cross-correlation, without means, since gravity is alike everywhere.
    """
    n = before.shape[1]
    if after.shape[1] == n:
        return 0
    before, after = (x - x.mean(axis=1, keepdims=True) for x in (before, after))
    products = sum(scipy.signal.correlate(a, b, mode="valid") for a, b in zip(after, before, strict=True))
    energy = np.concatenate(([0.0], np.cumsum((after**2).sum(axis=0))))
    window = energy[n:] - energy[:-n]
    return int(np.argmax(products / np.sqrt(np.maximum(window, 1e-12 * energy[-1] + 1e-30))))


def _crossfade(before: Array, after: Array) -> Array:
    """Return ``before`` faded into ``after``, each axis with gains that depend on its own correlation.

    With the fades ``u = cos^2, v = sin^2`` scaled to ``u^2 + v^2 = 1``, the sum ``u a + v b`` has the power ``u^2 Pa +
    v^2 Pb + 2 u v r sqrt(Pa Pb)``; both are divided so that it becomes ``u^2 Pa + v^2 Pb``. For alike pieces (r = 1)
    the gains then sum to 1, for unlike ones (r = 0) their squares do. This applies to the deviations from the means,
    which would make any two pieces look alike and are faded linearly.
    """
    n = before.shape[1]
    if n == 0:
        return before
    rise = np.sin(np.pi / 2 * (np.arange(n) + 0.5) / n) ** 2
    u, v = (1 - rise, rise) / np.hypot(1 - rise, rise)
    mean_a, mean_b = before.mean(axis=1, keepdims=True), after.mean(axis=1, keepdims=True)
    a, b = before - mean_a, after - mean_b
    pa, pb, cross = ((u * v * p).sum(axis=1, keepdims=True) for p in (a**2, b**2, a * b))
    r = np.clip(cross / np.sqrt(np.maximum(pa * pb, 1e-300)), LEAST_CORRELATION, 1.0)
    meant = u**2 * pa + v**2 * pb
    got = meant + 2 * u * v * r * np.sqrt(pa * pb)
    scale = np.sqrt(np.where(got > 0, meant / np.maximum(got, 1e-300), 1.0))
    mixed: Array = scale * (u * a + v * b) + (1 - rise) * mean_a + rise * mean_b
    return mixed


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
    for index, i in enumerate(chosen):
        length = min(len(signals[i]), max(least, budget // (number - index)))
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
