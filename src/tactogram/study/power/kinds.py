"""How the studies of a power table are simulated, by the kind of what they ask: a row for each size."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import special, stats

from tactogram.statistics.equivalence import share_equivalence_power
from tactogram.statistics.shares import exact_power, exact_ps, share_of, smallest_significant
from tactogram.study.designs.pairwise.power import shown_and_equal, simulated_preferences
from tactogram.study.designs.staircase.power import BELOW_START_DB, simulated_thresholds

Numbers = NDArray[np.float64]
Kind = Literal["share", "votes", "means", "slopes", "ranks", "staircases", "strengths"]


@dataclass(frozen=True)
class PowerAssumptions:
    """What a design's table assumes where nothing is said; typical sizes, to be replaced by a pilot's.

    Parameters
    ----------
    kind : str
        How its studies are simulated: ``share`` of two alternatives; ``votes``, one of each person; ``means`` of paired
        differences, which ``slopes`` and, by their signed ranks, ``ranks`` are too; ``staircases``; ``strengths`` of
        items that are compared in pairs.
    effect : float
        The truth that power is of.
    effect_text : str
        What it is, with its unit.
    person_sd, trial_sd : float
        Spread of people's own effects, and of a single answer.
    margin : float
        A margin for equivalence; for the table only, a study gives its own.
    participants, trials : tuple of int
    trials_text : str
        What a trial is.
    test, printed : str
        The confirmatory test, and that of the publication ("" where there is none).
    level_sd : float
        Spread of people's levels, whatever the condition; matters to the publication's test only.
    items : int
        That are compared with each other; of ``strengths`` only.
    """

    kind: Kind
    effect: float
    effect_text: str
    person_sd: float
    trial_sd: float
    margin: float
    participants: tuple[int, ...]
    trials: tuple[int, ...]
    trials_text: str
    test: str
    printed: str = ""
    level_sd: float = 0.0
    items: int = 0


Truths = Mapping[str, float]
"""What is true in the studies of which a share is reported: ``power``, and ``type_1``, where there is no difference."""
Simulated = Callable[[np.random.Generator, int, int, PowerAssumptions, Truths, int, float], Mapping[str, Any]]
"""From participants, trials, what is assumed, truths, studies and alpha to the shares of a row."""


def _exact(n: int, assumed: PowerAssumptions, alpha: float) -> dict[str, Any]:
    """Return what n independent answers can show, without any simulation."""
    low, high = share_of(n // 2, n, confidence=1 - alpha).wilson
    return {
        "answers": n,
        "smallest_significant": smallest_significant(n, alpha=alpha),
        "wilson_half_width": (high - low) / 2,
        "power": exact_power(n, assumed.effect, alpha=alpha),
        "type_1": exact_power(n, 0.5, alpha=alpha),
        "equivalence": share_equivalence_power(n, margin=assumed.margin, alpha=alpha),
    }


def _shares(
    rng: np.random.Generator,
    people: int,
    trials: int,
    assumed: PowerAssumptions,
    truths: Truths,
    simulations: int,
    alpha: float,
) -> dict[str, float]:
    """Return power of the share by participant, and of the exact test that takes all answers as independent."""
    found: dict[str, float] = {}
    n = people * trials
    printed = exact_ps(n) if assumed.printed else np.zeros(0)
    for name, truth in truths.items():
        own = special.expit(special.logit(truth) + rng.normal(0, assumed.person_sd, (simulations, people)))
        hits = rng.binomial(trials, own)
        p, equal = clustered_ps(hits, trials, margin=assumed.margin)
        found[name] = float((p < alpha).mean())
        if name == "type_1":
            found["equivalence"] = float((equal < alpha).mean())
        if assumed.printed:
            found[f"printed_{name}"] = float((printed[hits.sum(1)] < alpha).mean())
    return found


def _votes(
    rng: np.random.Generator,
    people: int,
    trials: int,
    assumed: PowerAssumptions,
    truths: Truths,
    simulations: int,
    alpha: float,
) -> dict[str, float]:
    """Return power of the exact test of one answer per person, where people differ in how easily they say yes."""
    ps = exact_ps(people)
    found = {}
    for name, truth in truths.items():
        own = special.expit(special.logit(truth) + rng.normal(0, assumed.person_sd, (simulations, people)))
        found[name] = float((ps[rng.binomial(1, own).sum(1)] < alpha).mean())
    return found


def clustered_ps(hits: NDArray[np.int64], trials: int, *, margin: float) -> tuple[Numbers, Numbers]:
    """Return p against one half and p of equivalence, as `pooled_share` gives them, for many studies at once.

    Where all participants have as many trials, GEE with independence has a closed form.

    Parameters
    ----------
    hits : int array, shape (study, participant)
    trials : int
        Of each participant.
    margin : float
    """
    people = hits.shape[1]
    own = hits / trials
    share = own.mean(1)
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = share * (1 - share)
        se = np.sqrt(((own - share[:, None]) ** 2).sum(1)) / ((people - 1) * spread)
        se = np.where(se > 1e-9, se, 1 / np.sqrt(people * trials * spread))
        logit = special.logit(share)
        t = logit / se
        above = (special.logit(0.5 + margin) - np.abs(logit)) / se
    p = 2 * stats.t.sf(np.abs(t), people - 1)
    equal = stats.t.sf(above, people - 1)
    alike = (share == 0) | (share == 1)
    return np.where(alike, 2 * 0.5**people, p), np.where(alike, 1.0, equal)


def _means(
    rng: np.random.Generator,
    people: int,
    trials: int,
    assumed: PowerAssumptions,
    truths: Truths,
    simulations: int,
    alpha: float,
) -> dict[str, float]:
    """Return power of paired differences; as printed, of Student's t over all answers."""
    # Five intensities over a factor of 16: sum of squared log distances from their middle.
    spread = float(((np.linspace(0, np.log(16), 5) - np.log(4)) ** 2).sum())
    noise = assumed.trial_sd / np.sqrt(trials)
    noise = noise / np.sqrt(spread) if assumed.kind == "slopes" else noise * np.sqrt(2)
    found: dict[str, float] = {}
    for name, truth in truths.items():
        gaps = rng.normal(truth, assumed.person_sd, (simulations, people))
        gaps += rng.normal(0, noise, gaps.shape)
        if assumed.kind == "ranks":
            p = np.asarray(stats.wilcoxon(gaps, axis=1).pvalue)
        else:
            p = np.asarray(stats.ttest_1samp(gaps, 0.0, axis=1).pvalue)
        found[name] = float((p < alpha).mean())
        if name == "type_1":
            found["equivalence"] = float((_within(gaps, assumed.margin) < alpha).mean())
        if assumed.printed:
            found[f"printed_{name}"] = float(
                (_student(rng, gaps, trials, assumed.trial_sd, assumed.level_sd) < alpha).mean()
            )
    return found


def _student(
    rng: np.random.Generator, gaps: Numbers, trials: int, trial_sd: float, level_sd: float
) -> Numbers:
    """Return p of Student's t over all answers of two conditions; people's levels differ by ``level_sd``.

    The less they differ, the more often the test shows what is not there; the more, the less it shows at all.
    """
    n = gaps.shape[1] * trials
    middle = rng.normal(0, np.sqrt(level_sd**2 + trial_sd**2 / (2 * trials)), gaps.shape)
    between = trials * (_squares(middle + gaps / 2) + _squares(middle - gaps / 2))
    within = trial_sd**2 * rng.chisquare(max(1, 2 * (n - gaps.shape[1])), len(gaps))
    variance = (between + within) / (2 * n - 2)
    return np.asarray(2 * stats.t.sf(np.abs(gaps.mean(1)) / np.sqrt(2 * variance / n), 2 * n - 2))


def _squares(values: Numbers) -> Numbers:
    """Return the summed squares around each row's mean."""
    return np.asarray(((values - values.mean(1, keepdims=True)) ** 2).sum(1))


def _within(gaps: Numbers, margin: float) -> Numbers:
    """Return p of equivalence, as `paired_equivalence` gives it, for many studies at once."""
    people = gaps.shape[1]
    se = gaps.std(1, ddof=1) / np.sqrt(people)
    return np.asarray(stats.t.sf((margin - np.abs(gaps.mean(1))) / se, people - 1))


def _staircases(
    rng: np.random.Generator,
    people: int,
    trials: int,
    assumed: PowerAssumptions,
    truths: Truths,
    simulations: int,
    alpha: float,
) -> dict[str, float]:
    """Return power of the paired difference of two thresholds by reversals."""
    found: dict[str, float] = {}
    for name, truth in truths.items():
        level = rng.normal(-BELOW_START_DB, 4.0, (simulations, people))
        gaps = rng.normal(truth, assumed.person_sd, level.shape)
        both = np.stack([level, level + gaps], -1)
        thresholds = simulated_thresholds(both, trials, slope=assumed.trial_sd, rng=rng)
        got = thresholds[..., 1] - thresholds[..., 0]
        p = np.asarray(stats.ttest_1samp(got, 0.0, axis=1).pvalue)
        found[name] = float((p < alpha).mean())
        if name == "type_1":
            found["equivalence"] = float((_within(got, assumed.margin) < alpha).mean())
            found["threshold_error_db"] = float((thresholds - both).std())
    return found


def _strengths(
    rng: np.random.Generator,
    people: int,
    trials: int,
    assumed: PowerAssumptions,
    truths: Truths,
    simulations: int,
    alpha: float,
) -> dict[str, float]:
    """Return power of pairwise preferences: of pairs that differ, and of all pairs where none does."""
    found: dict[str, float] = {}
    for name, truth in truths.items():
        parts = [
            shown_and_equal(gaps, errors, people=people, margin=assumed.margin, alpha=alpha)
            for gaps, errors in simulated_preferences(
                people,
                trials,
                items=assumed.items,
                effect=truth,
                person_sd=assumed.person_sd,
                studies=simulations,
                rng=rng,
            )
        ]
        shown, equal = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
        if name == "power":
            found[name] = float(shown[:, : assumed.items - 1].mean())
        else:
            found[name] = float(shown.any(1).mean())
            found["equivalence"] = float(equal.mean())
            found["all_equivalent"] = float(equal.all(1).mean())
    return found


def row_of(
    rng: np.random.Generator,
    people: int,
    trials: int,
    assumed: PowerAssumptions,
    simulations: int,
    alpha: float,
) -> dict[str, Any]:
    """Return what studies of one size show, as shares of them; of shares with what independent answers could."""
    truths = {"power": assumed.effect, "type_1": _null(assumed)}
    found = {**SIMULATED[assumed.kind](rng, people, trials, assumed, truths, simulations, alpha)}
    if assumed.kind in ("share", "votes"):
        answers = people if assumed.kind == "votes" else people * trials
        found |= {f"exact_{key}": value for key, value in _exact(answers, assumed, alpha).items()}
    return found


def equivalence_of(
    rng: np.random.Generator,
    people: int,
    trials: int,
    assumed: PowerAssumptions,
    simulations: int,
    alpha: float,
) -> float:
    """Return how often studies of one size show equivalence where the truth is no difference."""
    if assumed.kind == "votes":
        return share_equivalence_power(people, margin=assumed.margin, alpha=alpha)
    alone = replace(assumed, printed="")
    truths = {"type_1": _null(assumed)}
    return float(
        SIMULATED[assumed.kind](rng, people, trials, alone, truths, simulations, alpha)["equivalence"]
    )


def _null(assumed: PowerAssumptions) -> float:
    """Return what is true where there is no difference."""
    return 0.5 if assumed.kind in ("share", "votes") else 0.0


SIMULATED: Mapping[Kind, Simulated] = {
    "share": _shares,
    "votes": _votes,
    "means": _means,
    "slopes": _means,
    "ranks": _means,
    "staircases": _staircases,
    "strengths": _strengths,
}
