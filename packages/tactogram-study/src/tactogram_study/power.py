"""Power of a study before it is run, by numbers of participants and trials: tables, and the methods behind them.

The power of an exact binomial test holds for independent answers only; the simulated columns include differences
between people.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import special, stats

from tactogram.errors import ParameterError
from tactogram.workflows import ProgressCallback, silent
from tactogram_study.analysis.findings import table_lines
from tactogram_study.planned import ALPHA, PowerAssumptions
from tactogram_study.statistics import exact_ps, share_equivalence_power

MOST_TRIALS = 10_000
MOST_PARTICIPANTS = 10_000
ENOUGH = 0.8
"""Wanted share of studies that show equivalence, in the search for the number of participants."""
TRIED = (6, 8, 10, 15, 20, 30, 40, 60, 80, 120, 160, 240)
TRIED_SIMULATIONS = 200
TAKING, LOOKING = "simulated participants", "how many for equivalence"
"""Tasks of progress reports."""
Numbers = NDArray[np.float64]
Truths = Mapping[str, float]
"""True effect by name of the reported share: ``power``, and ``type_1`` without an effect."""


@dataclass(frozen=True)
class StudyBatch:
    """Simulated studies of one size: a row of a power table."""

    people: int
    trials: int
    assumed: PowerAssumptions
    simulations: int
    alpha: float

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of studies and participants."""
        return self.simulations, self.people


class PowerMethod:
    """Simulation and test of one kind of study."""

    null = 0.0
    """Effect without a difference."""
    of_pairs = False
    """Whether equivalence is that of a pair of items."""

    def shares(self, rng: np.random.Generator, batch: StudyBatch, truths: Truths) -> dict[str, float]:
        """Return, for each of ``truths``, the share of studies in which the test shows a difference.

        With ``type_1`` also ``equivalence``.
        """
        shares: dict[str, float] = {}
        for name, truth in truths.items():
            ps, columns = self.studies(rng, batch, truth)
            shares[name] = float((ps < batch.alpha).mean())
            if name == "type_1":
                shares |= columns
        return shares

    def studies(
        self, rng: np.random.Generator, batch: StudyBatch, truth: float
    ) -> tuple[Numbers, dict[str, float]]:
        """Return p of each simulated study, and the columns of its row, ``equivalence`` first, if nothing differs."""
        raise NotImplementedError

    def check(self, assumed: PowerAssumptions) -> None:
        """Raise `ParameterError` for assumptions that the method cannot simulate."""
        if assumed.items:
            raise ParameterError(f"items: this design compares no items with each other, got {assumed.items}")
        if assumed.trial_sd == 0:
            raise ParameterError.must("trial_sd", "be > 0, got 0")

    def notes(self) -> list[str]:
        """Return sentences on the columns of this method."""
        return []


class Shares(PowerMethod):
    """Shares correct of two alternatives, tested by participant."""

    null = 0.5

    def studies(
        self, rng: np.random.Generator, batch: StudyBatch, truth: float
    ) -> tuple[Numbers, dict[str, float]]:
        """Return p of the share by participant."""
        hits = rng.binomial(batch.trials, _personal_shares(rng, truth, batch))
        ps, equal = clustered_ps(hits, batch.trials, margin=batch.assumed.margin)
        return ps, {"equivalence": float((equal < batch.alpha).mean())}

    def check(self, assumed: PowerAssumptions) -> None:
        """Raise `ParameterError` for an effect that is no share."""
        if assumed.items:
            super().check(assumed)
        if not (0 < assumed.effect < 1 and assumed.margin < 0.5):
            raise ParameterError.must(
                "effect",
                "be a share between 0 and 1 and margin below 0.5, "
                f"got {assumed.effect:g} and {assumed.margin:g}",
            )


class Votes(Shares):
    """One yes or no of each person: the exact binomial test."""

    def studies(
        self, rng: np.random.Generator, batch: StudyBatch, truth: float
    ) -> tuple[Numbers, dict[str, float]]:
        """Return exact p of one answer per person, where people differ in their tendency to say yes.

        Equivalence is exact, too, without simulation.
        """
        yes = rng.binomial(1, _personal_shares(rng, truth, batch)).sum(1)
        equal = share_equivalence_power(batch.people, margin=batch.assumed.margin, alpha=batch.alpha)
        return exact_ps(batch.people)[yes], {"equivalence": equal}


class Means(PowerMethod):
    """Paired differences of means by Student's t."""

    def studies(
        self, rng: np.random.Generator, batch: StudyBatch, truth: float
    ) -> tuple[Numbers, dict[str, float]]:
        """Return p of paired differences."""
        gaps, columns = self.gaps(rng, batch, truth)
        equal = within_ps(gaps, batch.assumed.margin) < batch.alpha
        return self.ps(gaps), {"equivalence": float(equal.mean())} | columns

    def gaps(
        self, rng: np.random.Generator, batch: StudyBatch, truth: float
    ) -> tuple[Numbers, dict[str, float]]:
        """Return estimated differences, shape (study, participant), and further columns of the row."""
        gaps = rng.normal(truth, batch.assumed.person_sd, batch.shape)
        return gaps + rng.normal(0, self.noise(batch), gaps.shape), {}

    def noise(self, batch: StudyBatch) -> float:
        """Return the standard error of a participant's difference from single answers."""
        return float(batch.assumed.trial_sd / np.sqrt(batch.trials) * np.sqrt(2))

    def ps(self, gaps: Numbers) -> Numbers:
        """Return p of each study: float64 array, shape (study,), from gaps of shape (study, participant)."""
        return np.asarray(stats.ttest_1samp(gaps, 0.0, axis=1).pvalue)


class Ranks(Means):
    """Paired differences of means by Wilcoxon's signed ranks."""

    def ps(self, gaps: Numbers) -> Numbers:
        """Return p of each study."""
        return np.asarray(stats.wilcoxon(gaps, axis=1).pvalue)


class Slopes(Means):
    """Slopes over five intensities that span a factor of 16, by Student's t."""

    def noise(self, batch: StudyBatch) -> float:
        """Return the standard error of a participant's slope."""
        # Sum of squared log distances from their middle.
        spread = float(((np.linspace(0, np.log(16), 5) - np.log(4)) ** 2).sum())
        return float(batch.assumed.trial_sd / np.sqrt(batch.trials) / np.sqrt(spread))


METHODS: Mapping[str, PowerMethod] = {
    "share": Shares(),
    "votes": Votes(),
    "means": Means(),
    "ranks": Ranks(),
    "slopes": Slopes(),
}
"""Methods for any design, by ``kind`` of its assumptions."""


def clustered_ps(hits: NDArray[np.int64], trials: int, *, margin: float) -> tuple[Numbers, Numbers]:
    """Return p against one half and p of equivalence of each study, as `pooled_share`.

    With equal numbers of trials, GEE with independence has a closed form. ``hits`` has shape (study, participant).
    """
    people = hits.shape[1]
    shares = hits / trials
    share = shares.mean(1)
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = share * (1 - share)
        se = np.sqrt(((shares - share[:, None]) ** 2).sum(1)) / ((people - 1) * spread)
        se = np.where(se > 1e-9, se, 1 / np.sqrt(people * trials * spread))
        logit = special.logit(share)
        t = logit / se
        above = (special.logit(0.5 + margin) - np.abs(logit)) / se
    p = 2 * stats.t.sf(np.abs(t), people - 1)
    equal = stats.t.sf(above, people - 1)
    alike = (share == 0) | (share == 1)
    return np.where(alike, 2 * 0.5**people, p), np.where(alike, 1.0, equal)


def within_ps(gaps: Numbers, margin: float) -> Numbers:
    """Return p of equivalence of each study, as `paired_equivalence`, from gaps of shape (study, participant)."""
    people = gaps.shape[1]
    se = gaps.std(1, ddof=1) / np.sqrt(people)
    with np.errstate(divide="ignore"):  # no spread: t is infinite
        return np.asarray(stats.t.sf((margin - np.abs(gaps.mean(1))) / se, people - 1))


def _personal_shares(rng: np.random.Generator, truth: float, batch: StudyBatch) -> Numbers:
    """Return each participant's true share, with normal logits."""
    logits = special.logit(truth) + rng.normal(0, batch.assumed.person_sd, batch.shape)
    return np.asarray(special.expit(logits))


@dataclass(frozen=True)
class PowerTable:
    """Power of a design.

    Parameters
    ----------
    rows : tuple of mapping
        ``participants``, ``trials``, and shares from 0 to 1: ``power`` and ``type_1`` of the confirmatory test,
        ``equivalence`` (shown without a true difference); further ones of the design's power method.
    equivalence_from : mapping from int to int or None
        By trials, the number of `TRIED` participants from which `ENOUGH` of the studies show equivalence without a true
        difference; None if the largest is too small.
    """

    design: str
    assumed: PowerAssumptions
    simulations: int
    seed: int
    alpha: float
    rows: tuple[Mapping[str, Any], ...]
    equivalence_from: Mapping[int, int | None]

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return {
            **asdict(self),
            "simulated": True,
            "equivalence_from": {str(trials): people for trials, people in self.equivalence_from.items()},
        }


def power_table(
    name: str,
    assumed: PowerAssumptions,
    method: PowerMethod,
    *,
    simulations: int = 2000,
    seed: int = 0,
    alpha: float = ALPHA,
    progress: ProgressCallback = silent,
) -> PowerTable:
    """Return the power of studies of each size, and their rate of false alarms.

    With n simulations per row a share near .05 is known to about ± 2 sqrt(.05 .95 / n). ``progress`` is called with a
    task, and the numbers of its simulated participants, or sizes, done and in all. Raises `ParameterError` if a number
    is out of range.
    """
    if simulations < 100 or not 0 < alpha < 0.5:
        raise ParameterError.must(
            "simulations", f"be >= 100 and alpha < 0.5, got {simulations} and {alpha:g}"
        )
    _check(assumed)
    method.check(assumed)
    rng = np.random.default_rng(seed)
    rows: list[Mapping[str, Any]] = []
    whole, done = simulations * sum(assumed.participants) * len(assumed.trials), 0
    progress(TAKING, done, whole)
    for people in assumed.participants:
        for count in assumed.trials:
            batch = StudyBatch(people, count, assumed, simulations, alpha)
            shares = method.shares(rng, batch, {"power": assumed.effect, "type_1": method.null})
            rows.append({"participants": people, "trials": count, **shares})
            done += simulations * people
            progress(TAKING, done, whole)
    equivalence_from: dict[
        int, int | None
    ] = {}  # participants from which it is shown often enough, by trials
    for trials in assumed.trials:
        progress(LOOKING, len(equivalence_from), len(assumed.trials))
        rng = np.random.default_rng([seed, trials])
        low, high = 0, len(TRIED)
        while low < high:  # bisection: power grows with participants
            middle = (low + high) // 2
            batch = StudyBatch(TRIED[middle], trials, assumed, TRIED_SIMULATIONS, alpha)
            shown = method.shares(rng, batch, {"type_1": method.null})["equivalence"]
            low, high = (low, middle) if shown >= ENOUGH else (middle + 1, high)
        equivalence_from[trials] = TRIED[low] if low < len(TRIED) else None
    progress(LOOKING, len(equivalence_from), len(assumed.trials))
    return PowerTable(name, assumed, simulations, seed, alpha, tuple(rows), equivalence_from)


def _check(assumed: PowerAssumptions) -> None:
    """Raise `ParameterError` for sizes and spreads out of range."""
    if min(assumed.participants) < 2:
        raise ParameterError.must("participants", "be 2 or more", min(assumed.participants))
    if max(assumed.participants) > MOST_PARTICIPANTS:
        raise ParameterError.must(
            "participants", f"be {MOST_PARTICIPANTS} or fewer", max(assumed.participants)
        )
    if not 1 <= min(assumed.trials) <= max(assumed.trials) <= MOST_TRIALS:
        raise ParameterError.must("trials", f"be from 1 to {MOST_TRIALS}", min(assumed.trials))
    for name in ("effect", "person_sd", "trial_sd", "margin"):
        if not math.isfinite(getattr(assumed, name)):
            raise ParameterError(f"{name} must be finite, got {getattr(assumed, name)}")
    if assumed.person_sd < 0 or assumed.trial_sd < 0 or not assumed.margin > 0:
        raise ParameterError(
            "person_sd and trial_sd must be >= 0 and margin > 0, "
            f"got {assumed.person_sd:g}, {assumed.trial_sd:g}, {assumed.margin:g}"
        )


def power_text(table: PowerTable, method: PowerMethod) -> str:
    """Return a power table as text, with what was assumed."""
    assumed = table.assumed
    error = 2 * math.sqrt(0.05 * 0.95 / table.simulations)
    lines = [
        f"What a study of design {table.design} can show, by {table.simulations} studies of simulated participants per "
        f"row (a share of .05 is known to ±{error:.3f}).",
        f"Effect: {assumed.effect:g} {assumed.effect_text}; person_sd {assumed.person_sd:g}, "
        f"trial_sd {assumed.trial_sd:g}, margin ±{assumed.margin:g}, alpha {table.alpha:g}"
        f"{f', {assumed.items} items' if assumed.items else ''}; a trial: {assumed.trials_text}.",
        f"power, type_1, equivalence: {assumed.test}, the last where there is no difference.",
    ]
    lines += method.notes()
    return "\n".join(
        [*lines, *_errs(table), *_reached(table, of_pairs=method.of_pairs), "", *table_lines(table.rows)]
    )


def _errs(table: PowerTable) -> list[str]:
    """Return the sizes at which the confirmatory test has more false positives than alpha, beyond chance."""
    most = table.alpha + 3 * math.sqrt(table.alpha * (1 - table.alpha) / table.simulations)
    wrong = [f"{row['participants']} x {row['trials']}" for row in table.rows if row["type_1"] > most]
    return (
        [
            f"With {', '.join(wrong)} (participants x trials) the test has false positives more often than "
            f"{table.alpha:g}: take more of either."
        ]
        if wrong
        else []
    )


def _reached(table: PowerTable, *, of_pairs: bool) -> list[str]:
    """Return the number of participants needed to show equivalence, in a sentence for each number of trials."""
    margin = f"{'of a pair ' if of_pairs else ''}within ±{table.assumed.margin:g}"

    def each(trials: int) -> str:
        return f"With {trials} trial{'s' if trials > 1 else ''} each"

    return [
        f"{each(trials)}, equivalence {margin} is not shown in {ENOUGH:.0%} of studies even by {TRIED[-1]} "
        "participants: take more trials or a wider margin."
        if people is None
        else f"{each(trials)} it takes about {people} participants to show equivalence {margin} in "
        f"{ENOUGH:.0%} of studies."
        for trials, people in table.equivalence_from.items()
    ]
