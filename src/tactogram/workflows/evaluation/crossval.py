"""Cross-validation: by recording or block, by item or rater, never by window."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from annotated_types import Ge

from tactogram.errors import ParameterError
from tactogram.parameters import Count, checked
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.train import train  # noqa: F401  (its parameters are referred to)

if TYPE_CHECKING:
    from tactogram.datasets import Label


@checked
def crossval(
    model: str,
    data: str | Path,
    *,
    recipe: str = "quick",
    changes: Mapping[str, Any] | None = None,
    band: tuple[float, float] | None = None,
    split: str = "",
    by: str = "recording",
    label: Label = "material",
    where: Mapping[str, str] | None = None,
    out: Path | str | None = None,
    accelerator: str = "auto",
    model_folders: Sequence[Path | str] = (),
    folds: Annotated[int, Ge(2)] = 10,
    only_folds: Count | None = None,
    repeats: Count = 3,
    on: str = "",
    processes: Count | None = None,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Cross-validate a classifier, by recording, or a predictor of ratings, by item or rater.

    How folds are drawn is said by `tactogram.workflows.evaluation.classifier_crossval.crossval_classifier` and
    `tactogram.workflows.evaluation.rating_crossval.crossval_ratings`. One that was killed goes on when it is started
    again.

    Parameters
    ----------
    model, data, recipe, changes, band, split, by, label, where, out, accelerator, model_folders
        As of `train`.
    folds : int
        Number of folds.
    only_folds : int, optional
        Run only the first of them.
    repeats : int
        For a predictor of ratings: how often folds are redrawn.
    on : str
        Engine: ray starts Ray on this machine, ray:ADDRESS takes a cluster.
    processes : int, optional
        Processes of this machine, by default one per core; on a GPU one.

    Returns
    -------
    dict
        The split, recipe and data, ``folds`` and ``report``, and of a classifier ``window_accuracy``,
        ``recording_accuracy``, ``per_fold`` and the others of
        `tactogram.evaluation.classification.ClassificationResult.as_dict`; of a predictor ``per_word`` and ``mean`` as
        of `tactogram.evaluation.ratings.prediction.PredictedRatings.as_dict`.

    Raises
    ------
    ParameterError
        If the model neither classifies nor predicts ratings, there are too few recordings, items or raters for the
        folds, or ``out`` cannot be written to.

    Examples
    --------
    >>> import tactogram
    >>> result = tactogram.crossval("stroke_cnn", "data", recipe="tiny", folds=5)  # doctest: +SKIP
    >>> accuracy = result["recording_accuracy"]  # doctest: +SKIP
    """
    from tactogram import models
    from tactogram.workflows.evaluation.classifier_crossval import CrossvalRequest, crossval_classifier
    from tactogram.workflows.evaluation.rating_crossval import crossval_ratings

    request = CrossvalRequest(
        model, data, recipe=recipe, changes=changes, band=band, split=split, by=by, label=label, where=where, out=out,
        accelerator=accelerator, model_folders=model_folders, folds=folds, only_folds=only_folds, repeats=repeats,
        on=on, processes=processes,
    )  # fmt: skip
    task = models.find(model, model_folders).task
    if task == "prediction":
        return crossval_ratings(request, progress)
    if task != "classification":
        raise ParameterError(
            f"crossval is for classifiers and predictors of ratings; {model} is for {task}: train and evaluate it"
        )
    return crossval_classifier(request, progress)
