"""Surfaces described by an English text: one that a run predicts, or the materials of a run that it is most like."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactogram.datasets.simulate.everyday import SYNONYMS, known_from
from tactogram.errors import ParameterError
from tactogram.features.text_classifier import describe, plain
from tactogram.model import Condition
from tactogram.workflows.training.loaded_run import LoadedRun


def with_materials(run: LoadedRun, condition: Condition) -> dict[str, Any]:
    """Return a condition whose ``text``, if it has one, is replaced by the weights of the materials it describes.

    The name of a material, with no photograph, is that material. Another text stays for a run that predicts surfaces
    from text; otherwise it is a mix of the materials that it is most like.

    Raises `ParameterError` if the model takes no material or knows none, a material is given too, or the text of a mix
    is like none of them; `MissingExtraError` without the extra ``text``.
    """
    found = dict(condition)
    text = found.pop("text", None)
    if text is None:
        return found
    if found.get("material") is not None:
        raise ParameterError("conditions 'material' and 'text' describe the surface twice; give one of them")
    materials = run.any_kind.materials
    if "material" not in run.facts.conditions or not materials:
        raise ParameterError(f"condition 'text' needs a run that knows materials; {run.run.name} knows none")
    if not isinstance(text, str) or not text.strip():
        raise ParameterError(f"text must describe a material, e.g. 'corrugated cardboard', got {text!r}")
    if found.get("image") is None and (named := [name for name in materials if plain(name) == plain(text)]):
        return found | {"material": {named[0]: 1.0}}
    if run.model.prediction_facts(condition):
        return found | {"text": text}
    return found | {"material": describe(text, materials, synonyms=SYNONYMS)}


def set_from(run: LoadedRun, material: str | Mapping[str, float] | None) -> dict[str, str]:
    """Return what each everyday material named was set from, in words; empty for a run of other materials."""
    if run.run.data.get("materials", {}).get("name") != "everyday (simulated)":
        return {}
    named = {material} if isinstance(material, str) else {*(material or ())}
    return {name: known_from(name) for name in run.any_kind.materials if name in named}
