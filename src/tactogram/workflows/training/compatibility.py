"""Compatibility of a model with a data set, checked before anything is prepared or written."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactogram.datasets import signal_kind
from tactogram.errors import ParameterError
from tactogram.model import Example
from tactogram.workflows.training.plan import TrainingPlan, planned
from tactogram.workflows.training.requests import TrainingRequest

LOOKED_AT = 400
"""Recordings that are compared."""
GLANCE_S = 0.5
"""Length of each that is prepared, s (mm over displacement)."""


def check_training(request: TrainingRequest) -> dict[str, Any]:
    """Return the facts of a training that could be done, or refuse it as the training would.

    Rate, axes, unit and domain of `LOOKED_AT` recordings, even over the training part, are compared by a short
    piece of one of each sort. Faults that only whole recordings show, such as a short one, come later.

    Returns
    -------
    dict
        ``train``, ``validation``, ``test`` (recordings, or rated items, in each part), ``materials``, ``rate``,
        ``unit`` and ``axes`` of the signals (null of models that learn from ratings), ``simulated``.

    Raises
    ------
    TactogramError
        In one sentence: the mismatch, and what to do.
    """
    plan = planned(request)
    parts = {part: len(held) for part, held in plan.parts.parts.items()}
    facts: Mapping[str, Any] = {"materials": [], "rate": None, "unit": None, "axes": None}
    if plan.rated is None:
        kind = signal_kind(_glances(plan), simulated=plan.store.simulated)
        facts = {
            "materials": list(kind.materials),
            "rate": kind.rate,
            "unit": kind.unit,
            "axes": list(kind.axes),
        }
    return {**parts, **facts, "simulated": plan.store.simulated}


def _glances(plan: TrainingPlan) -> list[Example]:
    """Return a short prepared piece of one recording of each rate and set of axes."""
    store, prepare = plan.store, plan.recipe.prepare
    ids = list(dict.fromkeys(segment.id for segment in plan.parts.train))
    if not ids:
        raise ParameterError("there are no examples: the part of the split is empty")
    found: dict[tuple[Any, ...], Example] = {}
    for id in ids[:: -(-len(ids) // LOOKED_AT)]:
        stream = prepare.stream_of(store.streams_of(id))
        rate = store.rate(id, stream)
        piece = store.signal(id, stream, stop=min(store.length(id, stream), max(64, round(GLANCE_S * rate))))
        material = store.info(id).material
        sort = (piece.rate, piece.axes, piece.unit, piece.domain, material)
        if sort not in found:
            found[sort] = Example(id, prepare.apply(piece), material)
    return list(found.values())
