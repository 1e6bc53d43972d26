"""Power of a study, before it is run."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram_study.analysis.findings import finite, table_lines
from tactogram_study.designs.catalogue import power_tables
from tactogram_study.power.methods import PowerMethod
from tactogram_study.power.table import ENOUGH, TRIED, PowerTable, power_table
from tactogram_study.study_file import Study, shipped_studies


def study_power(design: Path | str, **options: Any) -> dict[str, Any]:
    """Return a power table by `power_table`, with a text.

    ``design`` is the name of a power table; or a study, shipped or a file, whose margin and numbers of trials and items
    are the defaults of ``options``.

    Raises `ParameterError` if there is no such table or study, or a number is out of the table's range.
    """
    name, tables = str(design), power_tables()
    if name not in tables and (name in shipped_studies() or Path(name).is_file()):
        study = Study.load(name)
        if not study.design.power:
            raise ParameterError(f"{name}: the design {study.design.kind} has no power table")
        name = next(iter(study.design.power))
        given = {key: value for key, value in options.items() if value is not None and value != ()}
        options = power_options(study) | given
    if name not in tables:
        raise ParameterError(f"design must be one of {', '.join(tables)}, or a study, got {name!r}")
    found = power_table(tables[name], name, **options)
    plain: dict[str, Any] = finite(found.as_dict())
    return plain | {"text": _power_text(found, tables[name].power_method(found.assumed.kind))}


def power_options(study: Study) -> dict[str, Any]:
    """Return the options of `power_table` in a study's file: alpha, margin, and numbers of trials."""
    options: dict[str, Any] = {"alpha": study.planned.alpha}
    name = next(iter(study.design.margins), "")
    if name in study.planned.values:
        options["margin"] = study.planned.values[name]
    return options | study.design.power_options(study.setting)


def _power_text(found: PowerTable, method: PowerMethod) -> str:
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
