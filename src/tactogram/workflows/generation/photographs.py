"""Facts about the photograph that a run generates from: the material it is classified as, and its novelty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.features.photo_novelty import UNLIKE
from tactogram.model import PhotographClassifier
from tactogram.signal import Image
from tactogram.signal.io import read_image
from tactogram.workflows.training.known_photographs import known_photographs
from tactogram.workflows.training.loaded_run import LoadedRun, load_run


def photograph_facts(loaded: LoadedRun, image: Image) -> dict[str, Any]:
    """Return facts about a photograph, as far as the run has them.

    Returns
    -------
    dict
        ``classified_as`` and possibly ``confidence``, if the model classifies photographs; ``nearest_photograph``, the
        material of the nearest training photograph, and ``novelty``, as of `tactogram.features.photo_novelty`, if the
        run describes its photographs.
    """
    found: dict[str, Any] = {}
    if isinstance(loaded.model, PhotographClassifier):
        try:
            material, confidence = loaded.model.classify_photograph(image)
            found = {"classified_as": material}
            found |= {} if confidence is None else {"confidence": round(float(confidence), 4)}
        except ParameterError:  # a variant without a label
            pass
    if (known := known_photographs(loaded.run)) is not None:
        nearest = known.nearest(image)
        found |= {"nearest_photograph": nearest.material, "novelty": round(nearest.novelty, 4)}
    return found


def facts_of_files(run: Path | str, files: Sequence[Path | str]) -> dict[str, dict[str, Any]]:
    """Return `photograph_facts` of each photograph by the file's name without suffix; no file loads no run."""
    if not files:
        return {}
    loaded = load_run(run)
    return {Path(file).stem: photograph_facts(loaded, read_image(file)) for file in files}


def photograph_text(facts: Mapping[str, Any]) -> str:
    """Return `photograph_facts` as a sentence without a full stop; "" if they say nothing that a reader needs."""
    sure = f", confidence {facts['confidence']:.2f}" if "confidence" in facts else ""
    if facts.get("novelty", 0) < UNLIKE:
        return f"photograph classified as {facts['classified_as']}{sure}" if "classified_as" in facts else ""
    treated = (
        f"classified as {facts['classified_as']}{sure}{',' * bool(sure)} all the same"
        if "classified_as" in facts
        else f"the nearest shows {facts['nearest_photograph']}"
    )
    return (
        "photograph unlike anything the run was trained on: it is farther from the nearest training photograph than "
        f"{100 * facts['novelty']:.0f} % of these are from one of another material; {treated}"
    )
