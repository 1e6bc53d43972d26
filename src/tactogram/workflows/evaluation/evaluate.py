"""Evaluation of a run, with a report in its folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram.parameters import checked
from tactogram.workflows.progress import ProgressCallback, silent

if TYPE_CHECKING:
    from tactogram.workflows.training.loaded_run import LoadedRun


@checked
def evaluate(
    run: Path | str | LoadedRun,
    *,
    data: str | Path | None = None,
    unknown: bool = False,
    evaluation: Mapping[str, Any] | None = None,
    given: str | None = None,
    rater: Path | str | None = None,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Evaluate a run on recordings that it was not trained on.

    ``evaluation.json``, ``report.html`` and of a classifier ``confusion.png`` are written into the run. Classes of
    other ``data`` are matched by name. A generator of signals conditioned on words needs ``rater``; one of images is
    otherwise only measured by differences of its images.

    Parameters
    ----------
    run : Path, str or LoadedRun
        Run of any model.
    data : str or Path, optional
        Data set to evaluate on, by default the run's own test part.
    unknown : bool
        Also use the materials that were left out of training, to test a classifier's "none of these".
    evaluation : mapping, optional
        For a generator: steps, window_s, longest_s, most or seed of the reference models.
    given : str, optional
        For a generator: the condition that describes surfaces, if it takes several.
    rater : Path or str, optional
        For a generator conditioned on words: the rater model that scores it.

    Returns
    -------
    dict
        ``data`` (name, sha256, split, simulated), ``report``, and: for a classifier ``window_accuracy``,
        ``recording_accuracy`` and the others of `ClassificationResult.as_dict`, with ``none_of_these``; for a
        generator those of `GenerationResult.as_dict`: ``measures`` and ``per_material`` with the columns
        ``model``, ``floor``, ``ceiling``, ``nearest_other``, ``ar_texture``, ``replay``, and what follows from them;
        with photographs also ``nearest_photo`` and ``pictures`` (`evaluate_pictures`), ``as_published`` where the
        publication's own figure is another; for a predictor of ratings ``per_word`` and ``mean`` as in
        `tactogram.evaluation.ratings.prediction.PredictedRatings`; for a generator conditioned on words the result of
        `tactogram.workflows.evaluation.word_signals.evaluate_rated_surfaces` or
        `tactogram.workflows.evaluation.word_images.evaluate_images`.

    Raises
    ------
    LeakError
        If a recording of ``data`` was trained on.
    ParameterError
        If the run's folder cannot be written to, or a parameter is not for its model.

    Examples
    --------
    >>> import tactogram
    >>> figures = tactogram.evaluate("runs/cnn", unknown=True)  # doctest: +SKIP
    >>> accuracy, report = figures["recording_accuracy"], figures["report"]  # doctest: +SKIP
    """
    from tactogram.evaluation.report import write_report
    from tactogram.signal.io.atomic import check_writable
    from tactogram.text_files import finite_json
    from tactogram.workflows.evaluation.run_evaluation import evaluate_run
    from tactogram.workflows.training.loaded_run import LoadedRun, load_run

    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    check_writable(loaded.run.folder, folder=True)
    figures, sections = evaluate_run(
        loaded, data=data, unknown=unknown, evaluation=evaluation, given=given, rater=rater, progress=progress
    )
    facts = figures["data"]
    report = write_report(
        loaded.run.folder / "report.html",
        title=f"{loaded.facts.name}: {loaded.run.name}",
        summary=f"{loaded.facts.title} ({loaded.facts.year}). Evaluated on {facts['name']}, {facts['split']}.",
        sections=sections,
        simulated=facts["simulated"] or loaded.simulated,
    )
    figures["report"] = str(report)
    figures = dict(finite_json(figures))
    loaded.run.write_json("evaluation.json", figures)
    return figures
