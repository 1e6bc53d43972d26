"""The protocol that every generator is held against: beside its floor, its ceiling and the baselines.

Two recordings of one texture are never sample-equal, and no measure of them is 0. So a generator's figure means
something only between two others: its *floor*, real recordings against other real recordings of the same
material (the training part against the test part), and its *ceiling*, other materials against this one's test
part. Every estimate depends on how much it was made from; so all sets are cut to pieces of one length and to
one number per material, and floor and ceiling are made of the training part, as the baselines are.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets.examples import cores
from tactogram.errors import ParameterError
from tactogram.evaluation.generation.comparison import (
    CEILING,
    FLOOR,
    MODEL,
    NEAREST,
    OTHERS,
    TEST,
    GenerationResult,
    Tables,
)
from tactogram.evaluation.generation.copies import measure_memorisation
from tactogram.evaluation.generation.measures import (
    CLASSIFIER_MEASURES,
    EMBEDDING_MEASURES,
    MEMORY_MEASURES,
)
from tactogram.evaluation.generation.recognition import measure_classification, measure_transfer
from tactogram.evaluation.generation.segments import PiecePlan, PieceSet, plan_pieces
from tactogram.evaluation.measures import (
    SIGNAL_MEASURES,
    Fit,
    frechet_distance,
    linear_discriminant,
    precision_recall_density_coverage,
    two_sample_accuracy,
)
from tactogram.model import Classifier
from tactogram.signal import Signal

T = TypeVar("T")
Figures = Mapping[str, float | None]
BySet = Mapping[str, Sequence[Signal]]
"""Signals by material."""

NEIGHBOURS = 5
"""k of precision, recall, density and coverage: Naeem et al. 2020."""


class PartCallback(Protocol):
    """Called with a task, how much of it is done, and how much there is."""

    def __call__(self, task: str, done: int, total: int, /) -> None:
        """Take note."""
        ...


def evaluate_generation(
    sets: Mapping[str, BySet],
    *,
    train: BySet,
    test: BySet,
    floor: BySet | None = None,
    pieces: PiecePlan | None = None,
    embed: Callable[[Signal], NDArray[np.floating]] | None = None,
    classifier: Classifier | None = None,
    fit: Fit = linear_discriminant,
    workers: int | None = None,
    on_part: PartCallback = lambda task, done, total: None,
) -> GenerationResult:
    """Hold generated signals against recordings that the generator was not trained on.

    The signal measures and those of the embedding compare each set with the test part. For accuracies of a
    classifier the floor is real recordings in the generated ones' place, the ceiling guessing. For memorising,
    the floor is the unseen recordings, the ceiling the training data itself.

    Parameters
    ----------
    sets : mapping name -> material -> signals
        ``"model"`` and the baselines; each with enough of every material of ``test`` for the pieces.
    train, test : mapping material -> signals
        Recordings: what was trained on, and what was not; of one rate, unit and set of axes. Materials of
        ``train`` that are not in ``test`` are only others to compare with.
    floor : mapping material -> signals, optional
        Recordings of materials of ``test`` that were not trained on at all, to stand where the training part of a
        known material does. What asks for a known material has no figure for them.
    pieces : Pieces, optional
        By default what `plan_pieces` says.
    embed : callable, optional
        Gives the points of a signal in an embedding, float, shape (point, feature), as many for signals of
        one length. Without it there are no measures of an embedding.
    classifier : Classifier, optional
        Trained on real recordings; names the generated.
    fit : callable
        Trains a quick classifier on signals and labels: trained on generated and tested on real, and the
        reverse. Only with two materials or more.
    workers : int, optional
        Threads; by default one per core. The figures do not depend on it.
    on_part : callable
        Told how far it is.

    Returns
    -------
    GenerationResult

    Raises
    ------
    ParameterError
        If a set lacks a material or signal, or signals differ in kind.
    """
    beside = {**train, **(floor or {})}
    _check(sets, beside, test)
    pieces = plan_pieces(beside, test) if pieces is None else pieces
    every = {**sets, FLOOR: beside, TEST: test}
    once = {
        id(part): {material: pieces.cut(part[material]) for material in sorted(test)}
        for part in every.values()
    }
    cut = {name: once[id(part)] for name, part in every.items()}
    cut[OTHERS] = cut[FLOOR] | _other_materials(train, test, pieces)
    notes: list[str] = []
    compared = partial(_compared, workers=workers)
    tables = compared(_signal_measures(cut[TEST], notes), cut, on_part=partial(on_part, "compare signals"))
    if embed is not None:
        points = _embedded(embed, cut, partial(on_part, "embed"))
        tables |= compared(_embedding_measures, points, on_part=partial(on_part, "compare embeddings"))
    if classifier is not None:
        tables["recognised_accuracy"] = measure_classification(classifier, cut)
    if len(test) < 2 or pieces.count < 2:
        notes.append("Trained and tested on generated left out: that needs two materials of two pieces each.")
    else:
        try:
            tables |= measure_transfer(fit, cut)
        except ParameterError as error:
            notes.append(f"Trained and tested on generated left out: {error}")
    tables |= measure_memorisation(cut, train, workers, partial(on_part, "look for copies"))
    tables = {name: rows for name, rows in tables.items() if _known(rows)}
    known = {**EMBEDDING_MEASURES, **CLASSIFIER_MEASURES, **MEMORY_MEASURES}
    return GenerationResult(
        materials=tuple(sorted(test)),
        columns=tuple(sets),
        values=tables,
        better={name: known[name].better if name in known else "lower" for name in tables},
        answers=_answers(cut),
        seconds=pieces.seconds,
        count=pieces.count,
        notes=tuple(notes),
        floored=frozenset(MEMORY_MEASURES),
    )


def _compared(
    distances: Callable[[T, T], Figures],
    sets: Mapping[str, Mapping[str, T]],
    *,
    workers: int | None,
    on_part: Callable[[int, int], None],
) -> Tables:
    """Return the tables of ``distances`` from the test part to each set, floor, and the other materials."""
    materials = tuple(sets[TEST])
    columns = [name for name in sets if name not in (TEST, OTHERS)]

    def rows(material: str) -> dict[str, dict[str, float | None]]:
        real = sets[TEST][material]
        known: dict[int, Figures] = {}  # a run that is a baseline itself is compared once
        found = {}
        for column in columns:
            made = sets[column][material]
            found[column] = known.setdefault(id(made), {}) or distances(real, made)
            known[id(made)] = found[column]
        others = [distances(real, made) for other, made in sets[OTHERS].items() if other != material]
        return {
            name: {column: found[column][name] for column in columns}
            | _ceiling([other[name] for other in others], found[FLOOR][name])
            for name in found[FLOOR]
        }

    tables: Tables = {}
    with ThreadPoolExecutor(workers or cores()) as pool:
        for done, (material, row) in enumerate(zip(materials, pool.map(rows, materials), strict=True), 1):
            for name, values in row.items():
                tables.setdefault(name, {})[material] = values
            on_part(done, len(materials))
    return tables


def _ceiling(others: Sequence[float | None], floor: float | None) -> dict[str, float | None]:
    """Return the mean over other materials, and of these the one that is nearest to the floor's side."""
    known = [value for value in others if value is not None]
    if not known or floor is None:
        return {CEILING: None, NEAREST: None}
    mean = float(np.mean(known))
    return {CEILING: mean, NEAREST: min(known) if mean >= floor else max(known)}


def _signal_measures(
    test: Mapping[str, PieceSet], notes: list[str]
) -> Callable[[PieceSet, PieceSet], Figures]:
    """Return the function that gives all signal measures that pieces of this kind and length have."""
    real = next(iter(test.values())).signals
    kept = {}
    for name, measure in SIGNAL_MEASURES.items():
        try:
            if measure.function(real, real) is not None:
                kept[name] = measure.function
        except ParameterError as error:
            notes.append(f"{name} left out: {error}")
    return lambda one, other: {name: f(one.signals, other.signals) for name, f in kept.items()}


@dataclass(frozen=True, eq=False)
class _Points:
    points: NDArray[np.float64]
    groups: tuple[int, ...]


def _embedded(
    embed: Callable[[Signal], NDArray[np.floating]],
    cut: Mapping[str, Mapping[str, PieceSet]],
    on_part: Callable[[int, int], None],
) -> dict[str, dict[str, _Points]]:
    known: dict[int, _Points] = {}
    every = {id(held): held for part in cut.values() for held in part.values()}
    for held in every.values():
        each = [np.atleast_2d(np.asarray(embed(s), dtype=np.float64)) for s in held.signals]
        groups = [group for points, group in zip(each, held.groups, strict=True) for _ in points]
        known[id(held)] = _Points(np.concatenate(each), tuple(groups))
        on_part(len(known), len(every))
    return {
        name: {material: known[id(held)] for material, held in part.items()} for name, part in cut.items()
    }


def _embedding_measures(real: _Points, made: _Points) -> Figures:
    """Return the measures that so many points have."""
    a, b = real.points, made.points
    figures: dict[str, float | None] = dict.fromkeys(EMBEDDING_MEASURES)
    if len(a) >= 3:
        figures["frechet_distance"] = frechet_distance(a, b)
        manifold = precision_recall_density_coverage(a, b, k=min(NEIGHBOURS, len(a) // 2))
        figures |= {name: float(value) for name, value in manifold._asdict().items()}
        figures["two_sample_accuracy"] = _told_apart(real, made)
    return figures


def _told_apart(real: _Points, made: _Points) -> float:
    """Return the two-sample accuracy with as many points of every signal.

    Neighbours from a point's own signal are left out where both sets have several signals: they are near
    whatever the sets are.
    """
    sets = (real, made)
    if min(len(set(s.groups)) for s in sets) < 2:
        return two_sample_accuracy(real.points, made.points).accuracy
    each = [[np.flatnonzero(np.equal(s.groups, group)) for group in sorted(set(s.groups))] for s in sets]
    fewest = min(len(places) for groups in each for places in groups)
    thin = [[places[np.arange(fewest) * len(places) // fewest] for places in groups] for groups in each]
    numbers = [np.repeat(np.arange(len(groups)), fewest) for groups in thin]
    return two_sample_accuracy(
        real.points[np.concatenate(thin[0])],
        made.points[np.concatenate(thin[1])],
        one_groups=numbers[0].tolist(),
        other_groups=numbers[1].tolist(),
    ).accuracy


def _answers(cut: Mapping[str, Mapping[str, PieceSet]]) -> dict[str, int]:
    """Return how many independent answers an accuracy is the mean of: recordings, not their pieces."""
    real, made = (sum(len(set(held.groups)) for held in cut[name].values()) for name in (TEST, MODEL))
    return {
        "two_sample_accuracy": real + made,
        "recognised_accuracy": made,
        "tested_on_generated_accuracy": made,
        "trained_on_generated_accuracy": real,
    }


def _other_materials(train: BySet, test: BySet, pieces: PiecePlan) -> dict[str, PieceSet]:
    """Return the pieces of materials that are not tested, where there are enough."""
    found = {}
    for material in sorted(set(train) - set(test)):
        try:
            found[material] = pieces.cut(train[material])
        except ParameterError:
            continue
    return found


def _known(rows: Mapping[str, Mapping[str, float | None]]) -> bool:
    return any(row.get(MODEL) is not None for row in rows.values())


def _check(sets: Mapping[str, BySet], train: BySet, test: BySet) -> None:
    if MODEL not in sets:
        raise ParameterError(f"sets must hold {MODEL!r}, got {', '.join(sets) or 'none'}")
    if not test:
        raise ParameterError("test must hold a recording to judge by, got none")
    for name, part in {TEST: test, "train": train, **sets}.items():
        for material in test:
            if not part.get(material):
                raise ParameterError(f"{name} must hold a signal of {material}, got none")
    kinds = {
        (s.rate, s.unit, s.axes, s.domain)
        for part in (test, train, *sets.values())
        for material in test
        for s in part[material]
    }
    if len(kinds) != 1:
        raise ParameterError(f"signals must have one rate, unit and set of axes, got {len(kinds)} kinds")
