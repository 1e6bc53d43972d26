"""Classification of recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.signal import Signal, signal_of
from tactogram.workflows.training.loaded_run import LoadedRun, load_run
from tactogram.workflows.training.surface_index import SurfaceIndex, surface_vector


def classify(run: Path | str | LoadedRun, signal: Signal) -> dict[str, Any]:
    """Classify a signal with a trained classifier.

    Parameters
    ----------
    run : Path, str or LoadedRun
        Run of a classifier.
    signal : Signal
        A recording; it is prepared by the run's recipe.

    Returns
    -------
    dict
        ``material`` (the likeliest), ``probability``, ``probabilities`` by material (likeliest first), ``candidates``:
        the materials among which that of a recording under known conditions is with 95 %, None if the model does not
        know, and ``none_of_these``: whether all known recordings are too far (see
        `tactogram.workflows.recognition.search`).

    Raises
    ------
    ParameterError
        If the run is no classifier, or the signal cannot be prepared for it.

    Examples
    --------
    >>> import tactogram
    >>> found = tactogram.classify("runs/cnn", tactogram.read_signal("stroke.wav"))  # doctest: +SKIP
    >>> found["material"], found["none_of_these"]  # doctest: +SKIP
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    classifier = loaded.classifier
    prepared = loaded.prepare(signal_of(signal))
    probabilities = classifier.probabilities(prepared)
    ranked = sorted(zip(loaded.kind.materials, probabilities.tolist(), strict=True), key=lambda p: -p[1])
    none_of_these = None
    if (loaded.run.folder / "search.json").is_file():
        none_of_these = SurfaceIndex.load(loaded.run).novelty(surface_vector(loaded.embedder, prepared)) > 1
    return {
        "material": ranked[0][0],
        "probability": ranked[0][1],
        "probabilities": dict(ranked),
        "candidates": classifier.candidates(probabilities),
        "none_of_these": none_of_these,
        "simulated": loaded.simulated,
    }
