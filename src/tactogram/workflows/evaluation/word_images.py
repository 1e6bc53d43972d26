"""Evaluation of an image generator conditioned on words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.figures import GeneratorRow, generated_figure
from tactogram.evaluation.ratings.reproduction import label_fidelity
from tactogram.evaluation.report import ReportFigure, ReportSection, ReportTable, ReportText
from tactogram.model import ImageKind, Model
from tactogram.signal import Image
from tactogram.workflows.training.loaded_run import LoadedRun, load_run, test_part
from tactogram.workflows.training.rated_examples import RatingData

LABELS, DRAWS = 12, 8
"""Largest number of labels, that of the paper's plates, and noises of each."""
SHOWN = 2
"""Noises in the figure, as in Fig. 4 of Hatori et al. 2025."""
FEWEST = 3
"""Smallest number of labels of test images, which `label_fidelity` needs; with fewer, training images are used."""
LOSSES = ("generator", "discriminator", "loss")
"""Losses in the figure, of those that a model has."""

Array = NDArray[np.float64]


def generates_images(loaded: LoadedRun) -> bool:
    """Return whether a run generates images from words."""
    return loaded.facts.task == "generation" and loaded.facts.gives == "image"


def evaluate_images(
    loaded: LoadedRun, *, rater: Path | str | LoadedRun | None = None
) -> tuple[dict[str, Any], list[ReportSection]]:
    """Return the spread of a run's images, and with a rater of images their label fidelity.

    The labels are the mean scores of test images; of training images if there are fewer than `FEWEST`, as ``data``
    says. The figures are ``model``, ``run``, ``data``; ``spread`` and ``collapse``
    (`evaluation.pictures.image_spread.ImageSpread`), null of a model that does not measure them; with ``rater`` also
    ``following`` (`tactogram.evaluation.ratings.reproduction.LabelFidelity`, scores 0 to 1) and ``told_by``.

    Raises `ParameterError` if ``rater`` is no rater of images in the run's words.
    """
    scorer = _rater_of(loaded, rater)
    generator = _generator(loaded)
    labels, described, store = _labels(loaded, generator)
    low, high = loaded.any_kind.scale or (0.0, 1.0)
    words = loaded.any_kind.words
    images = [
        [
            _image(generator, dict(zip(words, (low + (high - low) * row).tolist(), strict=True)), seed)
            for seed in range(DRAWS)
        ]
        for row in labels.values()
    ]
    simulated = store.simulated or (scorer is not None and scorer.simulated)
    figures = loaded.facts_on(store, described, simulated=simulated) | {"spread": None, "collapse": None}
    blocks: list[Any] = []
    if (spread := generator.image_spread()) is not None:
        figures |= {"spread": spread.as_dict(), "collapse": spread.collapse}
        rows: list[tuple[Any, ...]] = [
            ("two real images", spread.real),
            ("two of one label, other noise", spread.by_noise),
            ("two of one noise, other label", spread.by_label),
        ]
        blocks += [
            ReportTable(("distance of", ""), rows, "Root mean square over pixels of values in -1 to 1."),
            ReportText(f"Collapsed: {spread.collapse}." if spread.collapse else "No collapse found."),
        ]
    if scorer is not None:
        result = label_fidelity(np.stack(list(labels.values())), _predicted(scorer, images, words))
        told_by = "a rater model" + (" of simulated raters" if scorer.simulated else "")
        figures |= {"following": result.as_dict(), "told_by": told_by, "rater": scorer.run.data["run_id"]}
        text = f"Scores of 0 to 1, {len(labels)} labels, {DRAWS} noises each, rated by {told_by}."
        values = [
            ("error to the label", result.error),
            ("error to the other labels", result.error_of_others),
            ("correlation with the label", result.correlation),
            ("slope", result.slope),
            *((f"correlation, {word}", value) for word, value in zip(words, result.by_word, strict=True)),
        ]
        blocks.append(ReportTable(("follows its label", ""), values, text))
    trials = [[row[trial] for row in images] for trial in range(SHOWN)]
    metrics = loaded.run.metrics()
    losses = {n: curve for n in LOSSES if (curve := [(m["step"], m[n]) for m in metrics if n in m])}
    title = f"{loaded.run.name}{', simulated data' if figures['data']['simulated'] else ''}"
    figure = generated_figure([GeneratorRow("", trials, losses)], list(labels), title=title)
    blocks.append(ReportFigure(figure, "Images of each label from two noises, and the losses."))
    return figures, [ReportSection("Images", blocks)]


def _generator(loaded: LoadedRun) -> Model:
    if not loaded.model.rated_means:
        raise ParameterError(f"{loaded.run.name}: {loaded.facts.name} has no ratings of its training images")
    return loaded.model


def _image(generator: Model, words: dict[str, float], seed: int) -> Image:
    image = generator.generate({"words": words}, seed=seed)
    if not isinstance(image, Image):
        raise ParameterError("a generator of images generated a signal")
    return image


def _rater_of(loaded: LoadedRun, rater: Path | str | LoadedRun | None) -> LoadedRun | None:
    if rater is None:
        return None
    scorer = rater if isinstance(rater, LoadedRun) else load_run(rater)
    if scorer.facts.task != "prediction":
        raise ParameterError(f"{scorer.run.name}: {scorer.facts.name} is not a predictor of scores")
    if not isinstance(scorer.any_kind, ImageKind):
        raise ParameterError(f"{scorer.run.name}: rater is of signals, not of images")
    if set(scorer.any_kind.words) != set(loaded.any_kind.words):
        raise ParameterError(
            f"{scorer.run.name}: must be of the words {', '.join(loaded.any_kind.words)}; "
            f"got {', '.join(scorer.any_kind.words)}"
        )
    return scorer


def _labels(loaded: LoadedRun, generator: Model) -> tuple[dict[str, Array], str, Any]:
    """Return mean scores, 0 to 1, by item; a description of them; and the store."""
    store, split = test_part(loaded.run)
    rated = RatingData(store, loaded.facts.learns_from)
    kept = {
        str(example.item): np.asarray(example.rated.means, np.float64)
        for example in rated.examples(split, "test", loaded.recipe.prepare)
        if example.rated is not None
    }
    kept = {item: means for item, means in kept.items() if np.isfinite(means).all()}
    if len(kept) >= FEWEST:
        some = _some(kept)
        return some, f"scores of {len(some)} images kept for testing", store
    known = {item: means for item, means in generator.rated_means.items() if np.isfinite(means).all()}
    some = _some(known)
    return (
        some,
        f"scores of {len(some)} images that were trained on: fewer than {FEWEST} were kept for testing",
        store,
    )


def _some(means: dict[str, Array]) -> dict[str, Array]:
    """Return `LABELS` of them, evenly spaced."""
    names = sorted(means)
    places = np.linspace(0, len(names) - 1, min(len(names), LABELS)).round().astype(int)
    return {names[index]: means[names[index]] for index in places}


def _predicted(scorer: LoadedRun, images: list[list[Image]], words: tuple[str, ...]) -> Array:
    """Return the rater's scores of each image, 0 to 1, shape (label, draw, word)."""
    low, high = scorer.any_kind.scale or (0.0, 1.0)
    scores = [[scorer.predictor.predict(image) for image in row] for row in images]
    return (np.array([[[one[word] for word in words] for one in row] for row in scores]) - low) / (high - low)
