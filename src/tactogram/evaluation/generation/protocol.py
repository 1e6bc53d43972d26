"""Evaluation protocol of generators: comparison with a floor, a ceiling and the baselines.

Two recordings of one texture never have equal samples, so no measure between them is 0. A generator's value is
meaningful only between two others: its *floor*, real recordings against other real recordings of the same
material (the training part against the test part), and its *ceiling*, other materials against this one's test
part. Every estimate depends on the amount of data, so all sets are cut to equally many pieces of one length per
material, and floor, ceiling and baselines all use the training part.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.evaluation.generation.comparison import (
    CEILING,
    EMBEDDING_MEASURES,
    FLOOR,
    MEMORY_MEASURES,
    MODEL,
    NEAREST,
    OTHERS,
    TEST,
    GenerationResult,
    PiecePlan,
    PieceSet,
    Tables,
    describe_measures,
    plan_pieces,
)
from tactogram.evaluation.generation.recognition import (
    measure_classification,
    measure_memorisation,
    measure_transfer,
    tables_of,
)
from tactogram.evaluation.measures import (
    Fit,
    frechet_distance,
    linear_discriminant,
    precision_recall_density_coverage,
    signal_measures,
    two_sample_accuracy,
)
from tactogram.model import Model
from tactogram.signal import Signal

T = TypeVar("T")
Values = Mapping[str, float | None]
BySet = Mapping[str, Sequence[Signal]]
"""Signals by material."""

NEIGHBOURS = 5
"""k of precision, recall, density and coverage: Naeem et al. 2020."""


PartCallback = Callable[[str, int, int], None]
"""Callback for progress: a task, the number of finished parts, and their total."""


def evaluate_generation(
    sets: Mapping[str, BySet],
    *,
    train: BySet,
    test: BySet,
    floor: BySet | None = None,
    pieces: PiecePlan | None = None,
    embed: Callable[[Signal], NDArray[np.floating]] | None = None,
    classifier: Model | None = None,
    fit: Fit = linear_discriminant,
    workers: int | None = None,
    on_part: PartCallback = lambda task, done, total: None,
) -> GenerationResult:
    """Compare generated signals with recordings that were absent from the generator's training.

    Signal and embedding measures compare each set with the test part. For classifier accuracies, the floor uses
    real recordings in place of generated ones, and the ceiling is chance. For memorisation, the floor is the unseen
    recordings, the ceiling the training data itself. Raises `ParameterError` if a set lacks a material or signal, or
    signals differ in kind.

    Pieces are by default those of `plan_pieces`. The threads, by default one per core, do not affect the result.

    Parameters
    ----------
    sets : mapping name -> material -> signals
        ``"model"`` and the baselines; each with enough of every material of ``test`` for the pieces.
    train, test : mapping material -> signals
        Of one rate, unit and set of axes. Materials absent from ``test`` serve only as other materials.
    floor : mapping material -> signals, optional
        Recordings for the floor of materials absent from ``train``; measures that need training data are then None.
    embed : callable, optional
        Returns the points of a signal in an embedding, float, shape (point, feature), equally many for signals of
        one length. Without it, embedding measures are left out.
    classifier : Model, optional
        Trained on real recordings; classifies the generated signals.
    fit : callable
        Trains a quick classifier on signals and labels of at least two materials.
    """
    real = {**train, **(floor or {})}
    _check(sets, real, test)
    pieces = plan_pieces(real, test) if pieces is None else pieces
    every = {**sets, FLOOR: real, TEST: test}
    once = {
        id(part): {material: pieces.cut(part[material]) for material in sorted(test)}
        for part in every.values()
    }
    cut = {name: once[id(part)] for name, part in every.items()}
    cut[OTHERS] = cut[FLOOR] | _other_materials(train, test, pieces)
    notes: list[str] = []
    compared = partial(_compared, workers=workers)
    tables = compared(_signal_distances(cut[TEST], notes), cut, on_part=partial(on_part, "compare signals"))
    if embed is not None:
        points = _embedded(embed, cut, partial(on_part, "embed"))
        tables |= compared(_embedding_distances, points, on_part=partial(on_part, "compare embeddings"))
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
    tables = {
        name: rows
        for name, rows in tables.items()
        if any(row.get(MODEL) is not None for row in rows.values())
    }
    measures = describe_measures()
    return GenerationResult(
        materials=tuple(sorted(test)),
        columns=tuple(sets),
        values=tables,
        better={name: measures[name].better for name in tables},
        answers=_answers(cut),
        seconds=pieces.seconds,
        count=pieces.count,
        notes=tuple(notes),
        floored=frozenset(MEMORY_MEASURES),
    )


def _compared(
    distances: Callable[[T, T], Values],
    sets: Mapping[str, Mapping[str, T]],
    *,
    workers: int | None,
    on_part: Callable[[int, int], None],
) -> Tables:
    """Return the tables of ``distances`` from the test part to each set, the floor and the other materials."""
    materials = tuple(sets[TEST])
    columns = [name for name in sets if name not in (TEST, OTHERS)]

    def rows(material: str) -> dict[str, dict[str, float | None]]:
        real = sets[TEST][material]
        generated = {column: sets[column][material] for column in columns}
        # Keyed by identity: a run that is a baseline itself is compared once.
        unique = {id(pieces): pieces for pieces in generated.values()}
        compared = {key: distances(real, pieces) for key, pieces in unique.items()}
        values = {column: compared[id(pieces)] for column, pieces in generated.items()}
        others = [distances(real, pieces) for other, pieces in sets[OTHERS].items() if other != material]
        return {
            name: {column: values[column][name] for column in columns}
            | _ceiling([other[name] for other in others], floor)
            for name, floor in values[FLOOR].items()
        }

    return tables_of(rows, materials, workers, on_part)


def _ceiling(others: Sequence[float | None], floor: float | None) -> dict[str, float | None]:
    """Return the mean over other materials, and the value among them nearest to the floor."""
    defined = [value for value in others if value is not None]
    if not defined or floor is None:
        return {CEILING: None, NEAREST: None}
    mean = float(np.mean(defined))
    return {CEILING: mean, NEAREST: min(defined) if mean >= floor else max(defined)}


def _signal_distances(
    test: Mapping[str, PieceSet], notes: list[str]
) -> Callable[[PieceSet, PieceSet], Values]:
    """Return a function that computes all signal measures that are defined for pieces of this kind and length."""
    real = next(iter(test.values())).signals
    defined = {}
    for name, measure in signal_measures().items():
        try:
            if measure.function(real, real) is not None:
                defined[name] = measure.function
        except ParameterError as error:
            notes.append(f"{name} left out: {error}")
    return lambda one, other: {name: f(one.signals, other.signals) for name, f in defined.items()}


@dataclass(frozen=True, eq=False)
class _Points:
    points: NDArray[np.float64]
    groups: tuple[int, ...]


def _embedded(
    embed: Callable[[Signal], NDArray[np.floating]],
    cut: Mapping[str, Mapping[str, PieceSet]],
    on_part: Callable[[int, int], None],
) -> dict[str, dict[str, _Points]]:
    embedded: dict[int, _Points] = {}
    every = {id(pieces): pieces for part in cut.values() for pieces in part.values()}
    for pieces in every.values():
        each = [np.atleast_2d(np.asarray(embed(s), dtype=np.float64)) for s in pieces.signals]
        groups = [group for points, group in zip(each, pieces.groups, strict=True) for _ in points]
        embedded[id(pieces)] = _Points(np.concatenate(each), tuple(groups))
        on_part(len(embedded), len(every))
    return {
        name: {material: embedded[id(pieces)] for material, pieces in part.items()}
        for name, part in cut.items()
    }


def _embedding_distances(real: _Points, generated: _Points) -> Values:
    a, b = real.points, generated.points
    if len(a) < 3:
        return dict.fromkeys(EMBEDDING_MEASURES)
    manifold = precision_recall_density_coverage(a, b, k=min(NEIGHBOURS, len(a) // 2))
    return {
        "frechet_distance": frechet_distance(a, b),
        **{name: float(value) for name, value in manifold._asdict().items()},
        "two_sample_accuracy": _two_sample_accuracy(real, generated),
    }


def _two_sample_accuracy(real: _Points, generated: _Points) -> float:
    """Return the two-sample accuracy with equally many points of every signal.

    Where both sets have several signals, neighbours from a point's own signal are excluded: they are always near.
    """
    sets = (real, generated)
    if min(len(set(s.groups)) for s in sets) < 2:
        return two_sample_accuracy(real.points, generated.points).accuracy
    each = [[np.flatnonzero(np.equal(s.groups, group)) for group in sorted(set(s.groups))] for s in sets]
    fewest = min(len(places) for groups in each for places in groups)
    thin = [[places[np.arange(fewest) * len(places) // fewest] for places in groups] for groups in each]
    numbers = [np.repeat(np.arange(len(groups)), fewest) for groups in thin]
    return two_sample_accuracy(
        real.points[np.concatenate(thin[0])],
        generated.points[np.concatenate(thin[1])],
        one_groups=numbers[0].tolist(),
        other_groups=numbers[1].tolist(),
    ).accuracy


def _answers(cut: Mapping[str, Mapping[str, PieceSet]]) -> dict[str, int]:
    """Return the number of independent answers in each accuracy: recordings, not their pieces."""
    real, made = (sum(len(set(pieces.groups)) for pieces in cut[name].values()) for name in (TEST, MODEL))
    return {
        "two_sample_accuracy": real + made,
        "recognised_accuracy": made,
        "tested_on_generated_accuracy": made,
        "trained_on_generated_accuracy": real,
    }


def _other_materials(train: BySet, test: BySet, pieces: PiecePlan) -> dict[str, PieceSet]:
    """Return the pieces of untested materials with enough of them."""
    others = {}
    for material in sorted(set(train) - set(test)):
        try:
            others[material] = pieces.cut(train[material])
        except ParameterError:
            continue
    return others


def _check(sets: Mapping[str, BySet], train: BySet, test: BySet) -> None:
    if MODEL not in sets:
        raise ParameterError.must("sets", f"hold {MODEL!r}", ", ".join(sets) or "none")
    if not test:
        raise ParameterError.must("test", "hold a recording, got none")
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
        raise ParameterError.must("signals", f"have one rate, unit and set of axes, got {len(kinds)} kinds")
