"""Classification, scores and search of files: the verbs `classify`, `score` and `search`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tactogram.parameters import Count, Positive, checked


@checked
def classify_files(
    run: Path | str,
    files: Sequence[Path | str],
    *,
    unit: str | None = None,
    rate: Positive | None = None,
    axes: tuple[str, ...] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    part: Count | None = None,
) -> dict[str, Any]:
    """Classify the material of recordings.

    Parameters
    ----------
    run : Path or str
        Run of a classifier.
    files : sequence of Path or str
        Signals.
    unit : str, optional
        Unit of the samples, where the file does not state it: m/s^2, g, N, mm, V, 1, …
    rate : float, optional
        Sampling rate, Hz, where the file does not state it.
    axes : tuple of str, optional
        Columns or channels to read, e.g. x,y,z.
    time : str, optional
        Column of the time stamps, e.g. 'ticks [us]'; none to use none.
    sheet : str, optional
        Sheet of a workbook, if it has several.
    part : int, optional
        Part of a table that is interrupted, from 1.

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
    reading = {"unit": unit, "rate": rate, "axes": axes, "time": time, "sheet": sheet, "part": part}
    return {"files": {str(file): classify(loaded, read_signal(file, **reading)) for file in files}}


@checked
def score_files(
    run: Path | str,
    files: Sequence[Path | str],
    *,
    unit: str | None = None,
    rate: Positive | None = None,
    axes: tuple[str, ...] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    part: Count | None = None,
) -> dict[str, Any]:
    """Predict word scores of recordings, generated signals or images with a rater model.

    Parameters
    ----------
    run : Path or str
        Run of a rater model.
    files : sequence of Path or str
        Signals, or images where the model was trained on images.
    unit, rate, axes, time, sheet, part
        As of `classify_files`.

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
    reading = {"unit": unit, "rate": rate, "axes": axes, "time": time, "sheet": sheet, "part": part}
    return {"files": {str(file): score_file(loaded, file, **reading) for file in files}}


@checked
def search_file(
    run: Path | str,
    file: Path | str,
    *,
    data: Path | str | None = None,
    count: Count = 5,
    unit: str | None = None,
    rate: Positive | None = None,
    axes: tuple[str, ...] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    part: Count | None = None,
) -> dict[str, Any]:
    """Find the recordings nearest to a file, or report none of these.

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
    unit, rate, axes, time, sheet, part
        As of `classify_files`.

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

    reading = {"unit": unit, "rate": rate, "axes": axes, "time": time, "sheet": sheet, "part": part}
    return search(run, read_signal(file, **reading), data=data, count=count)
