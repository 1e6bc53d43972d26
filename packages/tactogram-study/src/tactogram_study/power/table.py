"""Power table: power of a study before it is run, by numbers of participants and trials.

The power of an exact binomial test holds for independent answers only; the simulated columns include differences
between people.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.workflows import ProgressCallback, silent
from tactogram_study.analysis.findings import ALPHA, table_lines
from tactogram_study.power.assumptions import PowerAssumptions
from tactogram_study.power.methods import PowerMethod, StudyBatch

if TYPE_CHECKING:
    from tactogram_study.designs.design import Design

MOST_TRIALS = 10_000
MOST_PARTICIPANTS = 10_000
ENOUGH = 0.8
"""Wanted share of studies that show equivalence, in the search for the number of participants."""
TRIED = (6, 8, 10, 15, 20, 30, 40, 60, 80, 120, 160, 240)
TRIED_SIMULATIONS = 200
TAKING, LOOKING = "simulated participants", "how many for equivalence"
"""Tasks of progress reports."""


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
    design: type[Design],
    name: str,
    *,
    simulations: int = 2000,
    seed: int = 0,
    alpha: float = ALPHA,
    progress: ProgressCallback = silent,
    **assumptions: Any,
) -> PowerTable:
    """Return the power of studies of each size, and their rate of false alarms.

    ``assumptions`` replace values of one of the design's ``power`` tables, by ``name``. With n simulations per row a
    share near .05 is known to about ± 2 sqrt(.05 .95 / n). ``progress`` is called with a task, and the numbers of its
    simulated participants, or sizes, done and in all. Raises `ParameterError` if a number is out of range.
    """
    if simulations < 100 or not 0 < alpha < 0.5:
        raise ParameterError(f"simulations must be >= 100 and alpha < 0.5, got {simulations} and {alpha:g}")
    assumed = replace(design.power[name], **assumptions)
    method = design.power_method(assumed.kind)
    _check(assumed)
    method.check(assumed)
    rng = np.random.default_rng(seed)
    rows: list[Mapping[str, Any]] = []
    whole, done = simulations * sum(assumed.participants) * len(assumed.trials), 0
    progress(TAKING, done, whole)
    for people in assumed.participants:
        for count in assumed.trials:
            batch = StudyBatch(people, count, assumed, simulations, alpha)
            found = method.shares(rng, batch, {"power": assumed.effect, "type_1": method.null})
            rows.append({"participants": people, "trials": count, **found})
            done += simulations * people
            progress(TAKING, done, whole)
    equivalence_from = _equivalence_from(method, assumed, alpha, seed, progress)
    return PowerTable(name, assumed, simulations, seed, alpha, tuple(rows), equivalence_from)


def _equivalence_from(
    method: PowerMethod,
    assumed: PowerAssumptions,
    alpha: float,
    seed: int,
    progress: ProgressCallback,
) -> dict[int, int | None]:
    """Return the number of participants from which equivalence is shown often enough, by trials of each."""
    found: dict[int, int | None] = {}
    for trials in assumed.trials:
        progress(LOOKING, len(found), len(assumed.trials))
        rng = np.random.default_rng([seed, trials])
        low, high = 0, len(TRIED)
        while low < high:  # bisection: power grows with participants
            middle = (low + high) // 2
            batch = StudyBatch(TRIED[middle], trials, assumed, TRIED_SIMULATIONS, alpha)
            shown = method.equivalence(rng, batch)
            low, high = (low, middle) if shown >= ENOUGH else (middle + 1, high)
        found[trials] = TRIED[low] if low < len(TRIED) else None
    progress(LOOKING, len(found), len(assumed.trials))
    return found


def _check(assumed: PowerAssumptions) -> None:
    """Raise `ParameterError` for sizes and spreads out of range."""
    if min(assumed.participants) < 2:
        raise ParameterError(f"participants must be 2 or more, got {min(assumed.participants)}")
    if max(assumed.participants) > MOST_PARTICIPANTS:
        raise ParameterError(
            f"participants must be {MOST_PARTICIPANTS} or fewer, got {max(assumed.participants)}"
        )
    if not 1 <= min(assumed.trials) <= max(assumed.trials) <= MOST_TRIALS:
        raise ParameterError(f"trials must be from 1 to {MOST_TRIALS}, got {min(assumed.trials)}")
    for name in ("effect", "person_sd", "trial_sd", "margin"):
        if not math.isfinite(getattr(assumed, name)):
            raise ParameterError(f"{name} must be finite, got {getattr(assumed, name)}")
    if assumed.person_sd < 0 or assumed.trial_sd < 0 or not assumed.margin > 0:
        raise ParameterError(
            "person_sd and trial_sd must be >= 0 and margin > 0, "
            f"got {assumed.person_sd:g}, {assumed.trial_sd:g}, {assumed.margin:g}"
        )


def power_text(found: PowerTable, method: PowerMethod) -> str:
    """Return a power table as text, with what was assumed."""
    assumed = found.assumed
    error = 2 * math.sqrt(0.05 * 0.95 / found.simulations)
    lines = [
        f"What a study of design {found.design} can show, by {found.simulations} studies of simulated participants per "
        f"row (a share of .05 is known to ±{error:.3f}).",
        f"Effect: {assumed.effect:g} {assumed.effect_text}; person_sd {assumed.person_sd:g}, "
        f"trial_sd {assumed.trial_sd:g}, margin ±{assumed.margin:g}, alpha {found.alpha:g}"
        f"{f', {assumed.items} items' if assumed.items else ''}; a trial: {assumed.trials_text}.",
        f"power, type_1, equivalence: {assumed.test}, the last where there is no difference.",
    ]
    lines += method.notes()
    return "\n".join(
        [*lines, *_errs(found), *_reached(found, of_pairs=method.of_pairs), "", *table_lines(found.rows)]
    )


def _errs(found: PowerTable) -> list[str]:
    """Return the sizes at which the confirmatory test has more false positives than alpha, beyond chance."""
    most = found.alpha + 3 * math.sqrt(found.alpha * (1 - found.alpha) / found.simulations)
    wrong = [f"{row['participants']} x {row['trials']}" for row in found.rows if row["type_1"] > most]
    return (
        [
            f"With {', '.join(wrong)} (participants x trials) the test has false positives more often than "
            f"{found.alpha:g}: take more of either."
        ]
        if wrong
        else []
    )


def _reached(found: PowerTable, *, of_pairs: bool) -> list[str]:
    """Return the number of participants needed to show equivalence, in a sentence for each number of trials."""
    margin = f"{'of a pair ' if of_pairs else ''}within ±{found.assumed.margin:g}"

    def each(trials: int) -> str:
        return f"With {trials} trial{'s' if trials > 1 else ''} each"

    return [
        f"{each(trials)}, equivalence {margin} is not shown in {ENOUGH:.0%} of studies even by {TRIED[-1]} "
        "participants: take more trials or a wider margin."
        if people is None
        else f"{each(trials)} it takes about {people} participants to show equivalence {margin} in "
        f"{ENOUGH:.0%} of studies."
        for trials, people in found.equivalence_from.items()
    ]
