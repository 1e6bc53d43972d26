"""Conditions that models are given: names, checks and weights."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError

CONDITIONS: Mapping[str, str] = {
    "material": "weight per material name, e.g. {'cork': 0.6, 'tile': 0.4}; a lone name is weight 1",
    "image": "photograph of the surface (Image)",
    "text": "the surface in English, e.g. 'coarse cork', for a model that learned materials by name",
    "words": "score per sensory word, e.g. {'rough': 6.0}",
    "vibration": "measured vibration of the surface (Signal)",
    "speed_mm_s": "stroking speed, mm/s",
    "force_n": "normal force, N",
    "contactor": "what strokes the surface: finger or stylus",
    "motion": "speed and force of the finger over time (Motion), in place of these two",
    "vibration_speed_mm_s": "speed of the measured vibration, mm/s",
    "vibration_force_n": "force of the measured vibration, N",
    "vibration_contactor": "what the measured vibration was stroked with: finger or stylus",
    "latent": "float array, shape (dimension,): the model's random input, to interpolate; by default drawn by the seed",
}
"""All condition names. Command line and studio build their forms from them."""

Condition = Mapping[str, Any]

MOST_NAMES = 30
"""Names that a message lists in full."""


def check_condition(condition: Condition, *, needs: Sequence[str] = (), takes: Sequence[str] = ()) -> None:
    """Refuse a condition that lacks a needed name or has one in neither ``needs`` nor ``takes``.

    Raises
    ------
    ParameterError
        Naming the missing or the unknown condition.
    """
    for name in needs:
        if condition.get(name) is None:
            raise ParameterError(f"condition {name!r} is needed: {CONDITIONS[name]}")
    for name, value in condition.items():
        if value is not None and name not in (*needs, *takes):
            allowed = ", ".join((*needs, *takes)) or "none"
            raise ParameterError(f"condition {name!r} is not one this model takes ({allowed})")


def check_state(names: Sequence[str], expected: Sequence[str]) -> None:
    """Refuse a saved state of other materials or words.

    Raises
    ------
    ParameterError
        Naming both.
    """
    if tuple(names) != tuple(expected):
        raise ParameterError(f"state is of {', '.join(names)}; expected {', '.join(expected)}")


def material_weights(condition: Condition, materials: Sequence[str]) -> NDArray[np.float64]:
    """Return the weight of each of ``materials`` in ``condition["material"]``.

    Parameters
    ----------
    condition : mapping
        ``material`` is a name or a mapping from name to weight >= 0.
    materials : sequence of str
        Materials of the model.

    Returns
    -------
    float64 array, shape (material,)
        Not scaled to sum to 1.

    Raises
    ------
    ParameterError
        For an unknown material, a weight that is negative or not finite, or weights that are all 0.
    """
    given = condition.get("material")
    if given is None:
        raise ParameterError(f"condition 'material' is needed: {CONDITIONS['material']}")
    given = {given: 1.0} if isinstance(given, str) else dict(given)
    weights = np.zeros(len(materials))
    for name, weight in given.items():
        if name not in materials:
            raise ParameterError(f"material must be {some_of(materials, like=name)}, got {name!r}")
        if not (np.isfinite(weight) and weight >= 0):
            raise ParameterError(f"weight of {name} must be finite and >= 0, got {weight}")
        weights[materials.index(name)] = weight
    if not weights.any():
        raise ParameterError("at least one material needs a weight > 0, got all 0")
    return weights


def contactor_number(name: str) -> float:
    """Return -1 for a finger, 1 for a stylus (a pen, tool or tip of any kind), NaN for other names."""
    words = set(name.lower().replace("-", " ").replace("_", " ").split())
    if words & {"finger", "fingertip", "hand"}:
        return -1.0
    return 1.0 if words & {"stylus", "pen", "tool", "tip", "probe"} else math.nan


def some_of(names: Sequence[str], *, like: str = "") -> str:
    """Return names in words, for a message: of very many those that are spelt most alike."""
    if len(names) <= MOST_NAMES:
        return f"one of {', '.join(names)}"
    alike = get_close_matches(like, names, n=8, cutoff=0.5) or names[:8]
    return f"one of {len(names)}, e.g. {', '.join(alike)}"
