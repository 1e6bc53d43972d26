"""Evaluation of a run's pictures: distances of pictures, and of the signals inverted from them."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from tactogram.datasets import Examples
from tactogram.evaluation.pictures.distances import PictureEvaluator, PictureWeights
from tactogram.evaluation.pictures.inversion import InversionLoss, inversion_loss, mean_loss
from tactogram.evaluation.report import ReportSection
from tactogram.features.pair_leak import pair_leak
from tactogram.workflows.evaluation.picture_report import (
    MOST_PAIRS,
    PicturePairs,
    generated_pairs,
    pairs_of_test,
    picture_generator,
    picture_sections,
    training_and_test,
)
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.loaded_run import LoadedRun, load_run

MOST_INVERTED = 12
"""Pictures of each material whose signals are evaluated."""


def evaluate_pictures(
    run: Path | str | LoadedRun,
    *,
    weights: PictureWeights | None = None,
    most: int = MOST_PAIRS,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Return the distances of a run's pictures from those of recordings that it was not trained on.

    ``run``: of a model that generates spectrogram pictures from photographs. ``weights``: files of the networks of
    LPIPS and FID; by default in torch's cache. ``most``: largest number of pairs.

    Raises `ParameterError` if the model generates no pictures, or no photograph or recording of the test part is large
    enough.

    Returns
    -------
    dict
        Fields of `PictureResult`; ``per_material`` the log-spectral distance of each; ``label_accuracy`` if the model
        predicts a label; ``leak``, the share of the test part that was trained on (`PairLeak`); ``inversion``, the
        parts of the loss of the inverted signals (`InversionLoss`, with ``network`` and ``share_of_inversion``);
        ``split`` and ``simulated``.
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    return _evaluated(loaded, weights, most, progress)[0]


def evaluate_run_pictures(
    loaded: LoadedRun, *, most: int = MOST_PAIRS, progress: ProgressCallback = silent
) -> tuple[dict[str, Any], list[ReportSection]]:
    """Return the figures of `evaluate_pictures` and the sections of a report on them."""
    figures, pairs, losses = _evaluated(loaded, None, most, progress)
    return figures, picture_sections(loaded, figures, pairs, losses)


def _evaluated(
    loaded: LoadedRun, weights: PictureWeights | None, most: int, progress: ProgressCallback
) -> tuple[dict[str, Any], PicturePairs, dict[str, InversionLoss]]:
    translation = picture_generator(loaded).translation
    picture = translation.picture
    train, test = training_and_test(loaded)
    tested = pairs_of_test(loaded, test)
    pairs = generated_pairs(loaded, tested, most, progress)
    figures = asdict(PictureEvaluator(picture, weights=weights)(pairs.real, pairs.made))
    plain = PictureEvaluator(picture, networks=False)
    figures["per_material"] = {
        name: plain(pairs.real[places], pairs.made[places]).values["log_spectral_distance_db"]
        for name, places in pairs.by_material().items()
        if len(places) > 1
    }
    if pairs.label_accuracy is not None:
        figures["label_accuracy"] = pairs.label_accuracy
    leak = pair_leak(translation.pairs(train), tested)
    figures["leak"] = asdict(leak) | {"leaks": leak.leaks}
    losses = _inversion(loaded, pairs, train, test, progress)
    figures["inversion"] = {
        name: asdict(loss) | {"network": loss.network, "share_of_inversion": loss.share_of_inversion}
        for name, loss in losses.items()
    }
    figures |= {"split": loaded.run.data["split"], "simulated": loaded.simulated}
    return figures, pairs, losses


def _inversion(
    loaded: LoadedRun, pairs: PicturePairs, train: Examples, test: Examples, progress: ProgressCallback
) -> dict[str, InversionLoss]:
    """Return the loss of the inverted signals, the mean over materials."""
    translation = picture_generator(loaded).translation
    picture, places = translation.picture, pairs.by_material()
    held: dict[str, list[list[Any]]] = {name: [[], []] for name in places}
    # Crops of the same recordings have no floor: that needs other recordings.
    parts = (test,) if translation.config.window_protocol else (test, train)
    for side, part in enumerate(parts):
        for example in part:
            if example.material in held and len(example.signal) >= picture.length:
                held[example.material][side].append(example.signal)
    losses = []
    for done, (name, (real, others)) in enumerate(held.items(), 1):
        if real:
            generated = pairs.made[places[name][:MOST_INVERTED]]
            losses.append(inversion_loss(real, generated, picture, others=others, seed=loaded.recipe.seed))
        progress("invert pictures", done, len(held))
    return mean_loss(losses) if losses else {}
