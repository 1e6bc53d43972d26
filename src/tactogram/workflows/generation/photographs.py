"""Facts about a surface described: the material of its photograph, and what a prediction from it is worth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactogram.errors import ParameterError
from tactogram.features.photo_descriptor import UNLIKE
from tactogram.model import Condition
from tactogram.workflows.training.known_photographs import known_photographs
from tactogram.workflows.training.loaded_run import LoadedRun

RECOGNISED = 0.5
"""Confidence from which a predicted surface is mainly that of the material that its photograph is classified as."""


def description_facts(loaded: LoadedRun, condition: Condition) -> dict[str, Any]:
    """Return facts about a photograph or a text, as far as the run has them.

    ``classified_as`` and possibly ``confidence``, if the model classifies photographs; ``nearest_photograph``, the
    material of the nearest training photograph, and ``novelty`` (`tactogram.features.photo_descriptor`), if the run
    describes its photographs; ``prediction``, as of `tactogram.model.Model.prediction_facts`.
    """
    predicted = loaded.model.prediction_facts(condition)
    facts: dict[str, Any] = {"prediction": predicted} if predicted else {}
    if (image := condition.get("image")) is None:
        return facts
    try:
        material, confidence = loaded.model.classify_photograph(image)
        facts |= {"classified_as": material}
        facts |= {} if confidence is None else {"confidence": round(float(confidence), 4)}
    except ParameterError:  # a model, or a variant, that does not
        pass
    if (known := known_photographs(loaded.run)) is not None:
        nearest = known.nearest(image)
        facts |= {"nearest_photograph": nearest.material, "novelty": round(nearest.novelty, 4)}
    return facts


def description_text(facts: Mapping[str, Any]) -> str:
    """Return `condition_facts` on a description as a sentence without a full stop; "" if a reader needs none."""
    mix = facts.get("material", {}) if "text" in facts else {}
    described = f"described: {', '.join(f'{name} {weight:g}' for name, weight in mix.items())}" if mix else ""
    unknown = f"not understood: {', '.join(facts['not_understood'])}" if "not_understood" in facts else ""
    return "; ".join(filter(None, (described, unknown, _photograph_text(facts))))


def _photograph_text(facts: Mapping[str, Any]) -> str:
    sure = f", confidence {facts['confidence']:.2f}" if "confidence" in facts else ""
    classified, predicted = f"classified as {facts.get('classified_as')}{sure}", ""
    if "prediction" in facts and facts.get("confidence", 0) < RECOGNISED:
        predicted = _prediction_text(facts["prediction"])
    elif "classified_as" not in facts:
        predicted = f"the nearest shows {facts.get('nearest_photograph')}"
    if facts.get("novelty", 0) < UNLIKE:
        return f"photograph {classified}" if not predicted else predicted * ("prediction" in facts)
    treated = predicted or f"{classified}{',' * bool(sure)} all the same"
    return (
        "photograph unlike anything the run was trained on: it is farther from the nearest training photograph than "
        f"{100 * facts['novelty']:.0f} % of these are from one of another material; {treated}"
    )


def _prediction_text(facts: Mapping[str, Any]) -> str:
    inputs = " and ".join("photograph" if name == "image" else name for name in facts["given"])
    which = f"of this run's {facts['materials']} materials"
    if facts.get("nearest"):
        return f"taken for the material of the nearest photograph {which}, too few to predict another"
    if "explained" not in facts:
        return f"the mean of all materials was generated: {which}, too few show what the {inputs} tells"
    share, low, high = (100 * each for each in (facts["explained"], *facts["explained_range"]))
    explains = f"explains {share:.0f} % ({low:.0f} to {high:.0f}) of the variance {which}, each left out"
    if facts["mean"]:
        return f"the mean of all materials was generated, as the {inputs} may tell nothing: it {explains}"
    unlike = "; the text is like no material's name, and counts for little" if facts.get("unlike") else ""
    return f"predicted from the {inputs}, which {explains}; standard deviation {facts['error_db']:.1f} dB{unlike}"
