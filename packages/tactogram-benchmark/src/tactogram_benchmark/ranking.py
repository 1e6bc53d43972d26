"""Ranking of the models of a task: which are better than which, and which cannot be told apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import false_discovery_control

from tactogram.errors import ParameterError
from tactogram.evaluation import margin_of, mean_interval
from tactogram_benchmark.ignoring import IGNORING
from tactogram_benchmark.result import BenchmarkResult, Entry
from tactogram_benchmark.task_kind import Figure

SIGNIFICANCE = 0.05
FLIPS = 20_000
"""Random sign flips of the permutation test; with at most `EXACT_ITEMS` items all are tried."""
EXACT_ITEMS = 14

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RankedModel:
    """A model on a task, over its seeds."""

    model: str
    entry: Entry
    results: tuple[BenchmarkResult, ...]
    value: float
    """Mean of the main figure over seeds."""
    sd: float | None
    """Standard deviation over seeds; None for one seed."""
    low: float | None
    """95 % interval over what was asked and, of two seeds or more, over trainings."""
    high: float | None
    best_rank: int
    worst_rank: int
    """The rank lies between these, given which models are told apart."""
    not_told_apart: tuple[str, ...]
    """Models from which it is not told apart."""
    informed: bool | None
    """Whether it is better than all rows that ignore what is given; None for these, and where there are none."""

    @property
    def rank_text(self) -> str:
        """The rank, or its range."""
        if self.best_rank == self.worst_rank:
            return str(self.best_rank)
        return f"{self.best_rank}–{self.worst_rank}"


def rank_models(results: Sequence[BenchmarkResult]) -> list[RankedModel]:
    """Return the models of one task, the best mean first.

    Two models are told apart where a paired permutation test over what was asked (each item's mean over seeds, signs
    flipped at random; Pitman 1937) gives p < 0.05, and the difference has the same sign with every seed that both have,
    at least one. p is corrected for all pairs of the task so that of the differences told, one in twenty is expected to
    be false (Benjamini & Hochberg 1995). With a correction that expects none, such as Holm's, models that enter would
    take away the others' differences, since of few items no p is small. Failed results are left out.

    Raises
    ------
    ParameterError
        If results are of other questions or figures than the first, or those of a model were not made alike.
    """
    by_model: dict[str, list[BenchmarkResult]] = {}
    for result in sorted(results, key=lambda r: (r.model, r.seed)):
        if not result.failed:
            by_model.setdefault(result.model, []).append(result)
    if not by_model:
        return []
    _check_comparable(list(by_model.values()))
    sign = 1.0 if next(iter(by_model.values()))[0].main.better == "higher" else -1.0
    better = _comparisons(by_model, sign)
    ignoring = [name for name in IGNORING if name in by_model]
    names = sorted(by_model, key=lambda name: -sign * _mean(by_model[name]))
    ranked = []
    for name in names:
        held = by_model[name]
        above = sum(better.get((other, name), False) for other in names)
        below = sum(better.get((name, other), False) for other in names)
        values = [result.main.value for result in held]
        ranked.append(
            RankedModel(
                name,
                held[0].entry,
                tuple(held),
                float(np.mean(values)),
                float(np.std(values, ddof=1)) if len(values) > 1 else None,
                *_interval([result.main for result in held]),
                1 + above,
                len(names) - below,
                tuple(
                    other
                    for other in names
                    if other != name and not better.get((other, name)) and not better.get((name, other))
                ),
                all(better.get((name, row)) or _surpasses(held, by_model[row], sign) for row in ignoring)
                if ignoring and name not in IGNORING
                else None,
            )
        )
    return ranked


def _check_comparable(by_model: Sequence[Sequence[BenchmarkResult]]) -> None:
    first = by_model[0][0]
    for held in by_model:
        for result in held:
            where = f"{result.task}, {result.model} with seed {result.seed}"
            if (result.main_name, result.main.better) != (first.main_name, first.main.better):
                raise ParameterError(
                    f"{where}: main figure must be {first.main_name}, {first.main.better} is better, as of "
                    f"{first.model}; got {result.main_name}, {result.main.better}"
                )
            if result.main.by_item.keys() != first.main.by_item.keys():
                raise ParameterError(f"{where}: answers other questions than {first.model}; measure it again")
            if (result.entry, result.recipe) != (held[0].entry, held[0].recipe):
                raise ParameterError(
                    f"{where}: made by {result.recipe or result.entry!r}, seed {held[0].seed} by "
                    f"{held[0].recipe or held[0].entry!r}; keep those of one"
                )


def _comparisons(
    by_model: Mapping[str, Sequence[BenchmarkResult]], sign: float
) -> dict[tuple[str, str], bool]:
    """Return for each ordered pair whether the first is better and told apart."""
    pairs = list(combinations(by_model, 2))
    ps, directions, steady = [], [], []
    for one, other in pairs:
        difference = sign * _differences(by_model[one], by_model[other])
        ps.append(sign_flip_p(difference))
        directions.append(difference.mean() > 0)
        per_seed = [
            sign * (a.main.value - b.main.value)
            for a in by_model[one]
            for b in by_model[other]
            if a.seed == b.seed or min(len(by_model[one]), len(by_model[other])) == 1
        ]
        steady.append(bool(per_seed) and (all(d > 0 for d in per_seed) or all(d < 0 for d in per_seed)))
    corrected = false_discovery_control(ps) if ps else []
    surpasses = {}
    for (one, other), p, first, sure in zip(pairs, corrected, directions, steady, strict=True):
        told = bool(p < SIGNIFICANCE and sure)
        surpasses[one, other], surpasses[other, one] = told and bool(first), told and not first
    return surpasses


def _surpasses(one: Sequence[BenchmarkResult], other: Sequence[BenchmarkResult], sign: float) -> bool:
    """Return whether the first is better with every seed, and by Student's 95 % interval over items."""
    interval = mean_interval(sign * _differences(one, other))
    steady = all(sign * (result.main.value - _mean(other)) > 0 for result in one)
    return steady and interval is not None and interval[0] > 0


def _differences(one: Sequence[BenchmarkResult], other: Sequence[BenchmarkResult]) -> Floats:
    """Return the difference of two models for each item that both have, means over seeds."""
    items = sorted(set(one[0].main.by_item) & set(other[0].main.by_item))
    means = [
        np.mean([[result.main.by_item[item] for item in items] for result in held], axis=0)
        for held in (one, other)
    ]
    return np.asarray(means[0] - means[1])


def sign_flip_p(differences: Floats) -> float:
    """Return the two-sided p of a paired permutation test that the mean difference is 0.

    Parameters
    ----------
    differences : float array, shape (item,)
        Paired differences. Up to `EXACT_ITEMS` items, every pattern of signs is tried.

    References
    ----------
    E. J. G. Pitman, J. R. Stat. Soc. Suppl. 4 (1937) 119-130.
    """
    count = len(differences)
    if not count or not np.any(differences):
        return 1.0
    if count <= EXACT_ITEMS:
        signs = 1 - 2.0 * ((np.arange(2**count)[:, None] >> np.arange(count)) & 1)
        extra = 0
    else:
        signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(FLIPS, count))
        extra = 1
    sums = np.abs(signs @ differences)
    observed = abs(float(differences.sum()))
    return float((np.sum(sums >= observed * (1 - 1e-9)) + extra) / (len(signs) + extra))


def _mean(results: Sequence[BenchmarkResult]) -> float:
    return float(np.mean([result.main.value for result in results]))


def _interval(seeds: Sequence[Figure]) -> tuple[float | None, float | None]:
    """Return the mean of the seeds' intervals over questions, with Student's margin over seeds added in quadrature.

    An error is at least 0, and what is better if higher, such as an accuracy, at most 1.

    References
    ----------
    G. Y. Zou and A. Donner, Stat. Med. 27 (2008) 1693-1702.
    """
    ends = [
        (figure.low, figure.high) for figure in seeds if figure.low is not None and figure.high is not None
    ]
    if len(ends) < len(seeds):
        return None, None
    value = float(np.mean([figure.value for figure in seeds]))
    margin = margin_of(np.array([figure.value for figure in seeds])) if len(seeds) > 1 else 0.0
    below, above = np.abs(np.mean(ends, axis=0) - value)
    low, high = float(value - np.hypot(below, margin)), float(value + np.hypot(above, margin))
    return (max(low, 0.0), high) if seeds[0].better == "lower" else (low, min(high, 1.0))
