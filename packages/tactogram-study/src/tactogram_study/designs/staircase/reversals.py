"""Answers of one staircase in order, and its reversals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactogram_study.answers import Answers


def reversals_of(own: Answers) -> NDArray[np.bool_]:
    """Return which trials of one staircase are reversals: bool, shape (trial,).

    From the column ``reversals`` (their number before the trial), else from the steps of the intensity. Whether the
    last trial is one follows from the rule of the earlier ones.
    """
    values = own.numbers("value")
    last = _ends_turning(values, own.numbers("correct"))
    if "reversals" in own.extra_columns and all(own.column("reversals")):
        before = np.array([int(text) for text in own.column("reversals")])
        return np.append(np.diff(before) > 0, last)
    turned = np.zeros(len(values), bool)
    heading = 0.0
    for trial, step in enumerate(np.sign(np.diff(values))):
        if step:
            turned[trial] = bool(heading) and step != heading
            heading = step
    turned[-1] = last
    return turned


def _ends_turning(values: NDArray[np.float64], right: NDArray[np.float64]) -> bool:
    """Return whether the last answer is a reversal: against the heading, after as many answers as earlier moves."""
    steps = np.sign(np.diff(values))
    moves = np.flatnonzero(steps).tolist()
    direction = -1 if right[-1] else 1
    if not moves or steps[moves[-1]] == direction:
        return False
    starts = dict(zip(moves, [0, *(move + 1 for move in moves[:-1])], strict=True))
    needed = [_run(right[starts[move] : move + 1]) for move in moves if steps[move] == direction]
    return bool(needed) and _run(right[moves[-1] + 1 :]) >= min(needed)


def _run(right: NDArray[np.float64]) -> int:
    """Return the number of equal answers at the end."""
    other = np.flatnonzero(right != right[-1])
    return len(right) - (int(other[-1]) + 1 if len(other) else 0)


def in_order(own: Answers) -> Answers:
    """Return the answers of one participant in the order of their trials."""
    return Answers(tuple(sorted(own.rows, key=lambda row: (row.session, row.trial))))
