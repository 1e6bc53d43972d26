"""What a study of some size could show, before it is run."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from tactogram.study.analysis.findings import finite, table_lines
from tactogram.study.designs.staircase import Staircase
from tactogram.study.designs.staircase.power import typical_trials
from tactogram.study.planned import MARGINS
from tactogram.study.power.table import DESIGNS, ENOUGH, TRIED, PowerTable, power_table
from tactogram.study.study_file import Study, shipped_studies


def study_power(design: Path | str, **options: Any) -> dict[str, Any]:
    """Return what a study can show, with a text.

    Parameters
    ----------
    design : str or Path
        One of `tactogram.study.power.table.DESIGNS`; or a study, shipped or a file, whose design, margin and numbers of
        trials and items are taken where nothing else is given.
    **options
        Those of `power_table`.
    """
    name = str(design)
    if name not in DESIGNS and (name in shipped_studies() or Path(name).is_file()):
        study = Study.load(name)
        name = study.design.model_dump()["kind"]
        given = {key: value for key, value in options.items() if value is not None and value != ()}
        options = power_options(study) | given
    found = power_table(name, **options)
    plain: dict[str, Any] = finite(found.as_dict())
    return plain | {"text": _power_text(found)}


def power_options(study: Study) -> dict[str, Any]:
    """Return what a study's file says of the options of `power_table`: its margin, alpha, and number of trials."""
    kind = study.design.model_dump()["kind"]
    options: dict[str, Any] = {"alpha": study.planned.alpha}
    if margins := [study.planned.values[name] for name in MARGINS[kind] if name in study.planned.values]:
        options["margin"] = margins[0]
    if kind in ("two_area", "abx", "pairwise"):
        options["trials"] = (study.trials,)
    if isinstance(study.design, Staircase):
        options["trials"] = (typical_trials(study.design),)
    if kind == "pairwise":
        options["items"] = len(study.all_stimuli)
    return options


def _power_text(found: PowerTable) -> str:
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
    if assumed.printed:
        lines.append(f"printed_…: {assumed.printed}, which takes answers as independent.")
    if assumed.kind in ("share", "votes"):
        lines.append(
            "exact_…: exact binomial if answers were independent; equivalence 0.000 where it is impossible."
        )
    if assumed.kind == "strengths":
        lines.append(
            "power: of a pair that differs; type_1: that any pair is shown where none differs; equivalence: of a pair, "
            "all_equivalent: of all pairs at once."
        )
    return "\n".join([*lines, *_errs(found), *_reached(found), "", *table_lines(found.rows)])


def _errs(found: PowerTable) -> list[str]:
    """Return where the confirmatory test shows what is not there more often than alpha says, beyond chance."""
    most = found.alpha + 3 * math.sqrt(found.alpha * (1 - found.alpha) / found.simulations)
    wrong = [f"{row['participants']} x {row['trials']}" for row in found.rows if row["type_1"] > most]
    return (
        [
            f"With {', '.join(wrong)} (participants x trials) the test shows what is not there more often than "
            f"{found.alpha:g}: take more of either."
        ]
        if wrong
        else []
    )


def _reached(found: PowerTable) -> list[str]:
    """Return how many participants it takes to show equivalence, in a sentence for each number of trials."""
    margin = f"{'of a pair ' if found.assumed.kind == 'strengths' else ''}within ±{found.assumed.margin:g}"

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
