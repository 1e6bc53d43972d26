"""What a study can show before it is run: exact for independent answers, and with simulated participants who differ.

A table has a row per number of participants and of trials of each. What an exact binomial test promises holds for
independent answers only; people differ, which the columns that are simulated take in.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import special, stats

from tactogram.errors import ParameterError
from tactogram.statistics.equivalence import share_equivalence_power
from tactogram.statistics.shares import exact_power, share_of, smallest_significant
from tactogram.study.power_staircases import simulated_thresholds

Numbers = NDArray[np.float64]
Kind = Literal["share", "votes", "means", "staircases"]
MOST_TRIALS = 10_000


@dataclass(frozen=True)
class Assumed:
    """What a design's table assumes where nothing is said; typical sizes, to be replaced by a pilot's.

    Parameters
    ----------
    kind : {"share", "votes", "means", "staircases"}
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


GEE, EXACT = "GEE by participant", "exact binomial of all answers"
DESIGNS: Mapping[str, Assumed] = {
    "two_area": Assumed(
        "share", 0.6, "share correct of a typical participant (person_sd: of logits)", 0.4, 0.0, 0.1,
        (10, 20), (10, 30, 90), "answers of each participant", GEE, EXACT,
    ),
    "realism": Assumed(
        "means", 5.0, "mm between conditions", 5.0, 15.0, 5.0,
        (10, 20), (10, 90), "marks of each participant and condition", "paired t", "Student's t of all marks", 10.0,
    ),
    "rating": Assumed(
        "means", 0.2, "points of mean absolute error between conditions", 0.2, 0.9, 0.2,
        (10, 20), (12, 120), "scores of each participant and condition", "Wilcoxon signed ranks",
        "Student's t of all scores", 0.3,
    ),
    "evoked": Assumed(
        "votes", 0.7, "share of people in whom it is evoked", 0.5, 0.0, 0.2,
        (10, 20, 30, 60), (1,), "answers of each participant to an image and word", EXACT,
    ),
    "abx": Assumed(
        "share", 0.6, "share correct of a typical participant (person_sd: of logits)", 0.4, 0.0, 0.1,
        (10, 20), (12, 48), "answers of each participant", GEE, "",
    ),
    "staircase": Assumed(
        "staircases", 3.0, "dB between two thresholds", 2.0, 0.5, 3.0,
        (6, 12), (40, 80), "trials of each staircase", "paired t of thresholds by reversals",
    ),
    "magnitude": Assumed(
        "means", 0.1, "of the exponent from 1", 0.15, 0.3, 0.1,
        (8, 16), (3, 6), "estimates of each of five intensities over a factor of 16", "t of slopes",
    ),
    "pairwise": Assumed(
        "share", 0.65, "share preferring one of two (person_sd: of logits)", 0.8, 0.0, 0.1,
        (10, 20), (4, 12), "answers of each participant to the pair", GEE,
    ),
}  # fmt: skip
"""``staircase``: person_sd is of people's differences, trial_sd the slope of their logistic function, per dB."""


@dataclass(frozen=True)
class PowerTable:
    """What a design can show.

    Parameters
    ----------
    design : str
    assumed : Assumed
        With everything that was asked for in place of the typical.
    simulations, seed : int
    alpha : float
    rows : tuple of mapping
        ``participants``, ``trials``, and shares from 0 to 1: ``power`` and ``type_1`` of the confirmatory test,
        ``equivalence`` (how often it is shown where the truth is no difference), ``printed_power`` and
        ``printed_type_1`` of the publication's; of shares also ``exact_…`` of independent answers.
    """

    design: str
    assumed: Assumed
    simulations: int
    seed: int
    alpha: float
    rows: tuple[Mapping[str, Any], ...]

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain values, for JSON."""
        return {
            "design": self.design,
            "assumed": {**vars(self.assumed)},
            "simulations": self.simulations,
            "seed": self.seed,
            "alpha": self.alpha,
            "simulated": True,
            "rows": [dict(row) for row in self.rows],
        }


def power_table(
    design: str,
    *,
    participants: Sequence[int] = (),
    trials: Sequence[int] = (),
    effect: float | None = None,
    person_sd: float | None = None,
    trial_sd: float | None = None,
    margin: float | None = None,
    simulations: int = 2000,
    seed: int = 0,
    alpha: float = 0.05,
) -> PowerTable:
    """Return how often a study of each size shows what is there, and what is not.

    Parameters
    ----------
    design : str
        One of `DESIGNS`; what is not given is as assumed there.
    participants, trials : sequence of int
    effect, person_sd, trial_sd, margin : float, optional
    simulations : int
        Studies of simulated participants per row; a share near .05 is then known to about ± 2 sqrt(.05 .95 / n).
    seed : int
    alpha : float

    Raises
    ------
    ParameterError
        If the design is none, or a number is not one that it can have.
    """
    if design not in DESIGNS:
        raise ParameterError(f"design must be one of {', '.join(DESIGNS)}, got {design!r}")
    assumed = _replaced(DESIGNS[design], participants, trials, effect, person_sd, trial_sd, margin)
    if simulations < 100 or not 0 < alpha < 0.5:
        raise ParameterError(f"simulations must be >= 100 and alpha < 0.5, got {simulations} and {alpha:g}")
    rng = np.random.default_rng(seed)
    rows = []
    for people in assumed.participants:
        for count in assumed.trials:
            row: dict[str, Any] = {"participants": people, "trials": count}
            if assumed.kind == "votes":
                row |= _votes(rng, people, assumed, simulations, alpha)
                row |= {f"exact_{key}": value for key, value in _exact(people, assumed, alpha).items()}
            elif assumed.kind == "share":
                row |= _shares(rng, people, count, assumed, simulations, alpha)
                row |= {
                    f"exact_{key}": value for key, value in _exact(people * count, assumed, alpha).items()
                }
            elif assumed.kind == "means":
                row |= _means(rng, design, people, count, assumed, simulations, alpha)
            else:
                row |= _staircases(rng, people, count, assumed, simulations, alpha)
            rows.append(row)
    return PowerTable(design, assumed, simulations, seed, alpha, tuple(rows))


def _replaced(
    typical: Assumed,
    participants: Sequence[int],
    trials: Sequence[int],
    effect: float | None,
    person_sd: float | None,
    trial_sd: float | None,
    margin: float | None,
) -> Assumed:
    given = {"effect": effect, "person_sd": person_sd, "trial_sd": trial_sd, "margin": margin}
    values = {name: value for name, value in given.items() if value is not None}
    made = Assumed(
        **{
            **vars(typical),
            **values,
            "participants": tuple(participants) or typical.participants,
            "trials": tuple(trials) or typical.trials,
        }
    )
    if min(made.participants) < 2:
        raise ParameterError(f"participants must be 2 or more, got {min(made.participants)}")
    if not 1 <= min(made.trials) <= max(made.trials) <= MOST_TRIALS:
        raise ParameterError(f"trials must be from 1 to {MOST_TRIALS}, got {min(made.trials)}")
    for name in ("effect", "person_sd", "trial_sd", "margin"):
        if not math.isfinite(getattr(made, name)):
            raise ParameterError(f"{name} must be finite, got {getattr(made, name)}")
    if made.person_sd < 0 or made.trial_sd < 0 or not made.margin > 0:
        raise ParameterError(
            "person_sd and trial_sd must be >= 0 and margin > 0, "
            f"got {made.person_sd:g}, {made.trial_sd:g}, {made.margin:g}"
        )
    if made.kind in ("share", "votes") and not (0 < made.effect < 1 and made.margin < 0.5):
        raise ParameterError(
            f"effect must be a share between 0 and 1 and margin below 0.5, got {made.effect:g} and {made.margin:g}"
        )
    if made.kind in ("means", "staircases") and made.trial_sd == 0:
        raise ParameterError("trial_sd must be > 0, got 0")
    return made


def _exact(n: int, assumed: Assumed, alpha: float) -> dict[str, Any]:
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
    rng: np.random.Generator, people: int, trials: int, assumed: Assumed, simulations: int, alpha: float
) -> dict[str, float]:
    """Return power of the share by participant, and of the exact test that takes all answers as independent."""
    found: dict[str, float] = {}
    n = people * trials
    printed = np.array([stats.binomtest(k, n).pvalue for k in range(n + 1)])
    for name, truth in (("power", assumed.effect), ("type_1", 0.5)):
        own = special.expit(special.logit(truth) + rng.normal(0, assumed.person_sd, (simulations, people)))
        hits = rng.binomial(trials, own)
        p, equal = clustered_ps(hits, trials, margin=assumed.margin)
        found[name] = float((p < alpha).mean())
        if truth == 0.5:
            found["equivalence"] = float((equal < alpha).mean())
        if assumed.printed:
            found[f"printed_{name}"] = float((printed[hits.sum(1)] < alpha).mean())
    return found


def _votes(
    rng: np.random.Generator, people: int, assumed: Assumed, simulations: int, alpha: float
) -> dict[str, float]:
    """Return power of the exact test of one answer per person, where people differ in how easily they say yes."""
    ps = np.array([stats.binomtest(k, people).pvalue for k in range(people + 1)])
    found = {}
    for name, truth in (("power", assumed.effect), ("type_1", 0.5)):
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
    design: str,
    people: int,
    trials: int,
    assumed: Assumed,
    simulations: int,
    alpha: float,
) -> dict[str, float]:
    """Return power of paired differences; as printed, of Student's t over all answers."""
    # Five intensities over a factor of 16: sum of squared log distances from their middle.
    spread = float(((np.linspace(0, np.log(16), 5) - np.log(4)) ** 2).sum())
    noise = assumed.trial_sd / np.sqrt(trials)
    noise = noise / np.sqrt(spread) if design == "magnitude" else noise * np.sqrt(2)
    found: dict[str, float] = {}
    for name, truth in (("power", assumed.effect), ("type_1", 0.0)):
        gaps = rng.normal(truth, assumed.person_sd, (simulations, people))
        gaps += rng.normal(0, noise, gaps.shape)
        if design == "rating":
            p = np.asarray(stats.wilcoxon(gaps, axis=1).pvalue)
        else:
            p = np.asarray(stats.ttest_1samp(gaps, 0.0, axis=1).pvalue)
        found[name] = float((p < alpha).mean())
        if truth == 0.0:
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
    rng: np.random.Generator, people: int, trials: int, assumed: Assumed, simulations: int, alpha: float
) -> dict[str, float]:
    """Return power of the paired difference of two thresholds by reversals."""
    found: dict[str, float] = {}
    for name, truth in (("power", assumed.effect), ("type_1", 0.0)):
        level = rng.normal(-20.0, 4.0, (simulations, people))
        gaps = rng.normal(truth, assumed.person_sd, level.shape)
        both = np.stack([level, level + gaps], -1)
        thresholds = simulated_thresholds(both, trials, slope=assumed.trial_sd, rng=rng)
        got = thresholds[..., 1] - thresholds[..., 0]
        p = np.asarray(stats.ttest_1samp(got, 0.0, axis=1).pvalue)
        found[name] = float((p < alpha).mean())
        if truth == 0.0:
            found["equivalence"] = float((_within(got, assumed.margin) < alpha).mean())
            found["threshold_error_db"] = float((thresholds - both).std())
    return found
