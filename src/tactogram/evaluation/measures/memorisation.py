"""Memorisation of training signals: the one measure that is not blind to phase."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from tactogram.errors import ParameterError
from tactogram.evaluation.measures.measure import check_alike, stacks
from tactogram.evaluation.measures.spectra import without_drift
from tactogram.signal import Signal

PIECE_S = 0.5
"""Length of the pieces, s. In a narrow band, shorter pieces match by chance."""


class Memorisation(NamedTuple):
    """Closeness of segments to the training signals; see `memorisation`.

    ``copied`` is the share of generated pieces nearer than ``limit``, 0..1; ``made`` and ``unseen`` are the
    median nearness of both sets, 0..1.
    """

    copied: float
    limit: float
    made: float
    unseen: float


def memorisation(
    made: Sequence[Signal], trained: Sequence[Signal], unseen: Sequence[Signal], *, seconds: float = PIECE_S
) -> Memorisation:
    """Return the share of generated pieces that are nearer to the training data than any unseen real piece.

    The nearness of a piece is its largest normalised cross-correlation with the training data
    (`nearness`). Two recordings of one texture are always somewhat alike, more so in a narrow band; the limit is
    therefore the nearness of real recordings that were *not* trained on. New draws exceed it by chance about
    once in ``len(unseen)`` pieces; a copy exceeds it whatever its level, sign and start.
    Blind to copies that were stretched in time or filtered strongly.

    All signals are of one material, rate, unit and set of axes; ``unseen`` are real ones absent from training.
    ``copied`` is the measure; lower is better.

    References
    ----------
    Normalised cross-correlation by FFT: J. P. Lewis, "Fast normalized cross-correlation", 1995. Unseen
    data as the limit: the idea of C. Meehan, K. Chaudhuri, S. Dasgupta, "A non-parametric test to detect
    data-copying in generative models", AISTATS 2020, with a distance for textures in place of theirs.
    """
    check_alike(made, trained, unseen)
    ours = nearness(made, trained, seconds=seconds)
    theirs = nearness(unseen, trained, seconds=seconds)
    limit = float(theirs.max())
    return Memorisation(float(np.mean(ours > limit)), limit, float(np.median(ours)), float(np.median(theirs)))


def nearness(
    signals: Sequence[Signal], trained: Sequence[Signal], *, seconds: float = PIECE_S
) -> NDArray[np.float64]:
    """Return how near each piece of ``signals`` comes to any interval of ``trained``: float64, shape (piece,), 0..1.

    max over positions t in ``trained`` of abs(sum of x(s) y(t + s)) / sqrt(sum of x(s)^2 sum of y(t + s)^2), sums over
    the piece and the axes, of the signals high-passed at 10 Hz. Pieces last ``seconds`` and overlap by half. 1 is a
    copy up to level and sign; silence is 0.
    """
    rate = check_alike(signals, trained).rate
    pieces = _pieces(signals, seconds)
    length = pieces.shape[-1]
    largest = np.zeros(len(pieces))
    compared = False
    for whole in stacks([signal for signal in trained if len(signal) >= length]):
        compared = True
        stack = without_drift(whole, rate)
        energy = np.cumsum(np.pad(np.sum(stack**2, axis=1), ((0, 0), (1, 0))), axis=1)
        local = energy[:, length:] - energy[:, :-length]
        # Rounding leaves some energy where there is silence.
        norm = np.sqrt(np.where(local > 1e-9 * energy[:, -1:], local, np.inf))
        points = fft.next_fast_len(stack.shape[-1], real=True)
        spectrum = fft.rfft(stack.astype(np.float32), points, axis=-1)
        inverse = (1 / norm).astype(np.float32)
        for number, piece in enumerate(pieces):
            match = np.einsum("rif,if->rf", spectrum, fft.rfft(piece, points, axis=-1).conj())
            correlation = fft.irfft(match, points, axis=-1)[:, : inverse.shape[1]]
            largest[number] = max(largest[number], float(np.abs(correlation * inverse).max()))
    if not compared:
        raise ParameterError.must("trained", f"hold a signal of {seconds:g} s, got none; use shorter pieces")
    return np.minimum(largest, 1.0)


def _pieces(signals: Sequence[Signal], seconds: float) -> NDArray[np.float32]:
    """Return the pieces of ``signals``, each scaled to energy 1: float32, shape (piece, axis, time)."""
    length = round(seconds * signals[0].rate) if 0 < seconds < np.inf else 0
    if length < 2:
        raise ParameterError.must("pieces", f"last at least two samples, got {seconds} s")
    pieces = []
    for signal in signals:
        x = without_drift(signal.samples.astype(np.float64), signal.rate)
        pieces += [x[:, k : k + length] for k in range(0, len(signal) - length + 1, length // 2)]
    if not pieces:
        raise ParameterError.must("signals", f"hold one of {seconds:g} s, got none; use shorter pieces")
    stack = np.stack(pieces)
    size = np.sqrt(np.sum(stack**2, axis=(1, 2), keepdims=True))
    return np.asarray(np.divide(stack, size, out=np.zeros_like(stack), where=size > 0), np.float32)
