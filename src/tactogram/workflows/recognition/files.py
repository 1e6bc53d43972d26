"""Classification, scores and search of files: the verbs `classify`, `score`, `search` and `data like`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tactogram.parameters import Count, checked, with_further
from tactogram.workflows.data.convert import reading_parameters


@checked
@with_further(reading_parameters)
def classify_files(
    run: Path | str,
    files: Sequence[Path | str],
    **reading: Any,
) -> dict[str, Any]:
    """Classify the material of recordings.

    ``reading`` are the options of `tactogram.convert` on how a file is read, `READING`.

    Parameters
    ----------
    run : Path or str
        Run of a classifier.
    files : sequence of Path or str
        Signals.

    Returns
    -------
    dict
        ``files``: by file the result of `tactogram.classify`.

    Raises
    ------
    DataError
        If a file cannot be read.
    ParameterError
        If the run is no classifier, or a signal cannot be prepared for it.
    """
    from tactogram.signal.io import read_signal
    from tactogram.workflows.recognition.classify import classify
    from tactogram.workflows.training.loaded_run import load_run

    loaded = load_run(run)
    return {"files": {str(file): classify(loaded, read_signal(file, **reading)) for file in files}}


@checked
@with_further(reading_parameters)
def score_files(
    run: Path | str,
    files: Sequence[Path | str],
    **reading: Any,
) -> dict[str, Any]:
    """Predict word scores of recordings, generated signals or images with a rater model.

    ``reading`` is as of `classify_files`.

    Parameters
    ----------
    run : Path or str
        Run of a rater model.
    files : sequence of Path or str
        Signals, or images where the model was trained on images.

    Returns
    -------
    dict
        ``files``: by file the result of `tactogram.workflows.recognition.score.score`.

    Raises
    ------
    DataError
        If a file cannot be read.
    ParameterError
        If the run is no predictor of scores, or a file is not of the kind that it was trained on.
    """
    from tactogram.workflows.recognition.score import score_file
    from tactogram.workflows.training.loaded_run import load_run

    loaded = load_run(run)
    return {"files": {str(file): score_file(loaded, file, **reading) for file in files}}


@checked
@with_further(reading_parameters)
def search_file(
    run: Path | str,
    file: Path | str,
    *,
    data: Path | str | None = None,
    count: Count = 5,
    **reading: Any,
) -> dict[str, Any]:
    """Find the recordings nearest to a file, or report none of these.

    ``reading`` is as of `classify_files`.

    Parameters
    ----------
    run : Path or str
        Run of a classifier.
    file : Path or str
        A signal.
    data : Path or str, optional
        Data set to search, added recordings included; by default the training data.
    count : int
        Number of results.

    Returns
    -------
    dict
        The result of `tactogram.search`.

    Raises
    ------
    DataError
        If the file cannot be read.
    ParameterError
        If the run is no classifier, or the signal cannot be prepared for it.
    """
    from tactogram.signal.io import read_signal
    from tactogram.workflows.recognition.search import search

    return search(run, read_signal(file, **reading), data=data, count=count)


@checked
@with_further(reading_parameters)
def find_similar_to_file(
    path: Path | str,
    file: Path | str,
    *,
    stream: str | None = None,
    count: Count = 5,
    **reading: Any,
) -> dict[str, Any]:
    """Find the recordings of a store whose spectra are nearest to a file's, without a trained run.

    ``reading`` are the options of `tactogram.convert` on how a file is read.

    Parameters
    ----------
    path : Path or str
        A store.
    file : Path or str
        A signal.
    stream : str, optional
        Stream to search (default: as in training).
    count : int
        Number of results.

    Returns
    -------
    dict
        The result of `tactogram.workflows.recognition.spectral_search.find_similar`.

    Raises
    ------
    DataError
        If the file cannot be read.
    ParameterError
        If there is no such stream, or the signal cannot be compared with it.
    """
    from tactogram.signal.io import read_signal
    from tactogram.workflows.recognition.spectral_search import find_similar

    signal = read_signal(file, **reading)
    return find_similar(path, signal, stream=stream, count=count)
