"""Word scores of recordings, generated signals or images, by a rater model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.model import ImageKind
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_image, read_signal
from tactogram.workflows.training.loaded_run import LoadedRun, load_run


def score(run: Path | str | LoadedRun, given: Signal | Image) -> dict[str, Any]:
    """Return predicted word ratings of a signal or an image; a signal is prepared by the run's recipe.

    Keys of the result: ``scores`` (by word, on the raters' scale), ``scale`` (lowest and highest), ``predicted_by``
    (the model, and whether its raters were simulated), ``novelty`` (share of features outside the training range: the
    larger, the less reliable the scores; None where the model has no such figure) and ``simulated``.

    Raises `ParameterError` if the run is no predictor of scores.
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    predictor = loaded.predictor
    prepared = loaded.prepare(given) if isinstance(given, Signal) else given
    scale = loaded.any_kind.scale
    return {
        "scores": dict(predictor.predict(prepared)),
        "scale": None if scale is None else list(scale),
        "predicted_by": f"{loaded.facts.name} model" + (" of simulated raters" if loaded.simulated else ""),
        "novelty": predictor.novelty(prepared),
        "simulated": loaded.simulated,
    }


def score_file(run: Path | str | LoadedRun, path: Path | str, **arguments: Any) -> dict[str, Any]:
    """Return `score` of a signal file, read with ``arguments`` of `read_signal`, or of an image file.

    Raises
    ------
    ParameterError
        Naming the file, if it is not of the kind that the run was trained on.
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    of_images = isinstance(loaded.any_kind, ImageKind)
    stimulus = read_image(path) if of_images else read_signal(path, **arguments)
    try:
        return score(loaded, stimulus)
    except ParameterError as error:
        if loaded.facts.task != "prediction":
            raise
        hint = "" if of_images else "; give its unit, rate and axes if the file does not state them"
        raise ParameterError(f"{path}: {error}{hint}") from error
