"""Evaluation of a run on recordings that it was not trained on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets import (
    Examples,
    Segment,
    Split,
    label_of,
    open_store,
    part_examples,
    whole_photographs,
)
from tactogram.errors import LeakError, ParameterError, Remedy, RunError
from tactogram.evaluation.classification import ClassificationResult, evaluate_classifier
from tactogram.evaluation.figures import confusion_figure, losses_figure
from tactogram.evaluation.report import ReportFigure, ReportSection, ReportTable, ReportText
from tactogram.model import Example, Model
from tactogram.validation import validated
from tactogram.workflows.evaluation.generator import evaluate_generator
from tactogram.workflows.evaluation.picture_report import generates_pictures
from tactogram.workflows.evaluation.pictures import evaluate_run_pictures
from tactogram.workflows.evaluation.ratings import evaluate_predictor
from tactogram.workflows.evaluation.reference_models import EvaluationSettings
from tactogram.workflows.evaluation.word_images import evaluate_images, generates_images
from tactogram.workflows.evaluation.word_signals import evaluate_rated_surfaces
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.loaded_run import LoadedRun, load_run, test_part
from tactogram.workflows.training.surface_index import SurfaceIndex, calibration_text, surface_vector


def evaluate_run(
    run: Path | str | LoadedRun,
    *,
    data: Path | str | None = None,
    unknown: bool = False,
    evaluation: Mapping[str, Any] | None = None,
    given: str | None = None,
    rater: Path | str | None = None,
    progress: ProgressCallback = silent,
) -> tuple[dict[str, Any], list[ReportSection]]:
    """Return the figures of `tactogram.evaluate` and the sections of its report, without writing either."""
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    settings = validated(EvaluationSettings, evaluation or {}, where="evaluation")
    by_ratings = (
        loaded.facts.task == "prediction" or loaded.facts.learns_from == "both" or generates_images(loaded)
    )
    if by_ratings:
        _check_rated(loaded, data, unknown, rater)
    elif rater is not None:
        raise _no_words(loaded)
    if loaded.facts.task == "prediction":
        return evaluate_predictor(loaded, data=data)
    if loaded.facts.learns_from == "both":
        return evaluate_rated_surfaces(loaded, rater=rater)
    if generates_images(loaded):
        return evaluate_images(loaded, rater=rater)
    if data is None and not unknown and (protocol := loaded.model.config.window_protocol):
        return _evaluated_within(loaded, protocol, progress)
    if given is not None:
        loaded = replace(loaded, facts=loaded.facts.given(given))
    return _evaluated_on_recordings(loaded, data, unknown, settings, progress)


def _check_rated(loaded: LoadedRun, data: Path | str | None, unknown: bool, rater: Path | str | None) -> None:
    """Refuse options that make no sense for a model of ratings."""
    predicts = loaded.facts.task == "prediction"
    if unknown:
        problem = "is for models that classify materials; omit it"
        raise ParameterError(loaded.run.name, problem, parameter="unknown")
    if data is not None and not predicts:
        raise ParameterError(
            loaded.run.name,
            f"{loaded.facts.name} is evaluated on the ratings of its own data",
            remedy=Remedy("omit", "data"),
        )
    if rater is not None and predicts:
        raise _no_words(loaded)


def _no_words(loaded: LoadedRun) -> ParameterError:
    return ParameterError(
        loaded.run.name,
        f"scores generators conditioned on words; {loaded.facts.name} is none",
        parameter="rater",
    )


def _evaluated_on_recordings(
    loaded: LoadedRun,
    data: Path | str | None,
    unknown: bool,
    settings: EvaluationSettings,
    progress: ProgressCallback,
) -> tuple[dict[str, Any], list[ReportSection]]:
    """Return the figures and sections of a classifier, or a generator, on recordings that it was not trained on."""
    loaded.run.metrics()  # refuses a damaged log before anything is computed
    examples, described = _test_examples(loaded, data, unknown)
    store = examples.store
    figures = loaded.facts_on(store, described)
    known = [example for example in examples if example.material in loaded.kind.materials]
    others = [example for example in examples if example.material not in loaded.kind.materials]
    if loaded.facts.task == "generation" and not {"material", "words"} & {*loaded.facts.needs}:
        known, others = [*known, *others], []  # it takes photographs or recordings of unknown surfaces
    if not known:
        raise ParameterError(
            f"{store.name}: no recording of a material that the run knows ({', '.join(loaded.kind.materials)})"
        )
    if loaded.facts.task == "generation":
        try:
            for example in known:
                loaded.kind.check(example.signal)
        except ParameterError as error:
            raise ParameterError(
                f"{store.name}: not what {loaded.run.name} was trained on: {error}"
            ) from error
        train = _trained_on(loaded)
        result, draw = evaluate_generator(loaded, known, train, settings=settings, progress=progress)
        results, sections = result.as_dict(), draw()
        if data is None and generates_pictures(loaded):
            results["pictures"], more = evaluate_run_pictures(loaded, progress=progress)
            sections += more
        published, more = _as_published(loaded.model, known)
        results |= published
        sections += more
    else:
        done = iter(range(1, len(known) + 1))
        classified = evaluate_classifier(
            loaded.classifier, known, on_example=lambda: progress("judge", next(done), len(known))
        )
        title = "Simulated data" if figures["data"]["simulated"] or loaded.simulated else ""
        results, sections = classified.as_dict(), [_accuracy(classified, title)]
        if (loaded.run.folder / "search.json").is_file():
            results["none_of_these"] = _evaluated_rejection(loaded, known, others)
            sections.append(_rejection(results["none_of_these"]))
    return figures | results, sections + _training_section(loaded)


def _evaluated_within(
    loaded: LoadedRun, protocol: str, progress: ProgressCallback
) -> tuple[dict[str, Any], list[ReportSection]]:
    """Return figures on other parts of the training recordings: no floor of other recordings, no baselines."""
    store, split = test_part(loaded.run)
    figures = loaded.facts_on(
        store, f"{protocol}: other parts of the {len(split.train)} recordings that were trained on"
    )
    sections: list[ReportSection] = []
    if generates_pictures(loaded):
        figures["pictures"], sections = evaluate_run_pictures(loaded, progress=progress)
    published, more = _as_published(loaded.model, _trained_on(loaded))
    return figures | published, sections + more + _training_section(loaded)


def _training_section(loaded: LoadedRun) -> list[ReportSection]:
    metrics = [m for m in loaded.run.metrics() if "loss" in m]
    if not metrics:
        return []
    return [ReportSection("Training", [ReportFigure(losses_figure(metrics), "Loss over steps.")])]


def _as_published(model: Model, examples: Sequence[Example]) -> tuple[dict[str, Any], list[ReportSection]]:
    """Return ``as_published`` and its section, if there are such figures; or why these recordings do not allow it."""
    try:
        published = model.evaluate_as_published(examples)
    except ParameterError as error:
        why = f"Not evaluated as published: {error}"
        return {"as_published": None, "as_published_missing": why}, [
            ReportSection("As published", [ReportText(why)])
        ]
    return ({"as_published": published}, [_published_section(published)]) if published else ({}, [])


def _published_section(figures: dict[str, Any]) -> ReportSection:
    """Return the figures that a publication reports, with those it omits."""
    names = list(next(iter(figures["per_material"].values())))
    rows = [(material, *row.values()) for material, row in figures["per_material"].items()]
    rows.append(("mean", *(figures["mean"][name] for name in names)))
    text = "Squared errors as published, and distances that are blind to phase. " + ", ".join(
        f"{name} {value:.4g}" for name, value in figures["mean"].items() if name not in names
    )
    return ReportSection("As published", [ReportTable(("material", *names), rows, text)])


def _test_examples(loaded: LoadedRun, data: Path | str | None, unknown: bool) -> tuple[Examples, str]:
    """Return the examples for testing, and a phrase that describes them."""
    label = loaded.run.data["label"]
    if data is None:
        store, split = test_part(loaded.run)
        if not split.test:
            raise ParameterError(
                loaded.run.name, "kept no recordings for testing", remedy=Remedy("give", "data")
            )
        left_out = tuple(
            Segment(info.id)
            for info in store.index
            if unknown and label_of(info, label) not in loaded.kind.materials
        )
        described = f"{len(split.test)} held-out recordings, split by {split.by}"
        if split.photographs:
            described += f"; {split.photograph_note}"
        parts = replace(split, test=(*split.test, *left_out)) if left_out else split
        return part_examples(store, parts, "test", loaded.as_trained, label=label), described
    if unknown:
        raise ParameterError(
            "uses the materials left out of the run's own data",
            parameter="unknown",
            remedy=Remedy("omit", "data"),
        )
    store = open_store(data)
    split = Split.load(loaded.run.folder / "split.json")
    trained = {segment.id for segment in (*split.train, *split.validation)}
    seen = {region.key for part in ("train", "validation") for region in split.photographs.get(part, ())}
    every = whole_photographs(store) if split.photographs else ()
    for description, both in (
        (f"of its {len(store)} recordings", sorted(trained & {info.id for info in store.index})),
        (f"of its {len(every)} photographs", sorted(seen & {region.key for region in every})),
    ):
        if both:
            raise LeakError(
                data,
                f"{len(both)} {description} were trained on (first: {both[0]})",
                remedy=(Remedy("evaluate on others"), Remedy("for the run's own test part omit", "data")),
            )
    segments = [Segment(info.id) for info in store.index]
    photographs = every if split.photographs else None
    examples = Examples(store, segments, loaded.as_trained, label=label, photographs=photographs)
    return examples, f"all {len(store)} recordings"


def _trained_on(loaded: LoadedRun) -> Examples:
    """Return the training examples of a run: a generator's floor and baselines are made of them."""
    try:
        store, split = test_part(loaded.run)
    except RunError as error:
        raise RunError(
            f"{loaded.run.folder}: a generator is compared with the recordings it was trained on, and they are not "
            f"at {loaded.run.data.get('path')} any more: put them back"
        ) from error
    return part_examples(store, split, "train", loaded.as_trained, label=loaded.run.data["label"])


def _evaluated_rejection(
    loaded: LoadedRun, known: Sequence[Example], unknown: Sequence[Example]
) -> dict[str, Any]:
    """Return how many recordings of known and of unknown materials are classified as "none of these"."""
    index = SurfaceIndex.load(loaded.run)
    far = {
        name: np.array([index.novelty(surface_vector(loaded.embedder, e.signal)) for e in part])
        for name, part in (("known", known), ("unknown", unknown))
    }
    facts: dict[str, Any] = {
        "calibrated_on": index.calibrated_on,
        "known": len(known),
        "known_kept": float(np.mean(far["known"] <= 1)),
        "unknown": len(unknown),
        "unknown_rejected": None,
        "auroc": None,
    }
    if unknown:
        facts["unknown_rejected"] = float(np.mean(far["unknown"] > 1))
        pairs = far["unknown"][:, None] - far["known"][None]
        facts["auroc"] = float(np.mean(pairs > 0) + np.mean(pairs == 0) / 2)
        facts["unknown_materials"] = sorted({str(e.material) for e in unknown})
    return facts


def _accuracy(result: ClassificationResult, title: str) -> ReportSection:
    low, high = result.recording_interval
    rows = [
        ("recordings", result.recording_accuracy, f"{low:.3f} – {high:.3f}", int(result.recordings.sum())),
        ("windows", result.window_accuracy, "–", int(result.windows.sum())),
        ("chance", 1 / len(result.materials), "–", "–"),
    ]
    note = "Recordings are classified by the mean log probability of their windows. Interval: Wilson."
    if facts := result.candidate_facts:
        right, number = 100 * facts["right_among"], facts["mean_number"]
        note += f" Of {right:.1f} % of the recordings the right class is a candidate (95 %), of {number:.1f} each."
    table = ReportTable(("classified correctly", "share", "95 % interval", "of"), rows, note)
    picture = ReportFigure(
        confusion_figure(result.windows, result.materials, title=title),
        "Share of the windows of each true class (row) that were answered so (column).",
        file="confusion.png",
    )
    return ReportSection("Classification", [table, picture])


def _rejection(facts: dict[str, Any]) -> ReportSection:
    rows = [
        ("recordings of known materials that pass", facts["known_kept"], facts["known"]),
        ("recordings of unknown materials that are refused", facts["unknown_rejected"], facts["unknown"]),
        ("area under the ROC curve, unknown against known", facts["auroc"], "–"),
    ]
    text = (
        "A recording too far from the nearest known one for that one's material is “none of these”. "
        + calibration_text(facts["calibrated_on"])
    )
    return ReportSection("None of these", [ReportText(text), ReportTable(("outcome", "share", "of"), rows)])
