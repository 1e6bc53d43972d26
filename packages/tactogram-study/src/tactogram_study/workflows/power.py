"""Power of a study, before it is run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.parameters import checked
from tactogram.workflows import ProgressCallback, silent
from tactogram_study.designs.catalogue import power_tables
from tactogram_study.planned import ALPHA
from tactogram_study.study_file import Study, shipped_studies


@checked
def study_power(
    design: Path | str,
    *,
    participants: tuple[int, ...] | None = None,
    trials: tuple[int, ...] | None = None,
    effect: float | None = None,
    person_sd: float | None = None,
    trial_sd: float | None = None,
    margin: float | None = None,
    items: int | None = None,
    simulations: int = 2000,
    seed: int = 0,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Compute the power of a study before it is run: exactly, and with simulated participants.

    ``progress`` is called as by `tactogram_study.power.power_table`.

    Parameters
    ----------
    design : Path or str
        A power table, see `study designs`; or a study, whose margin, alpha and trials are used.
    participants : tuple of int, optional
        Numbers of participants.
    trials : tuple of int, optional
        Trials per participant.
    effect : float, optional
        True effect.
    person_sd : float, optional
        Standard deviation of effects between people.
    trial_sd : float, optional
        Standard deviation of single answers.
    margin : float, optional
        Margin of equivalence.
    items : int, optional
        Number of items compared with each other.
    simulations : int
        Studies of simulated participants per row.
    seed : int
        Seed of the simulations.

    Returns
    -------
    dict
        The values of a `tactogram_study.power.PowerTable`, and its ``text``.

    Raises
    ------
    ParameterError
        If there is no such table or study, or a number is out of the table's range.
    """
    from tactogram.text_files import finite_json
    from tactogram_study.power import power_table, power_text

    name, tables, options = str(design), power_tables(), dict[str, Any]()
    if name not in tables and (name in shipped_studies() or Path(name).is_file()):
        study = Study.load(name)
        if not study.design.power:
            raise ParameterError(f"{name}: the design {study.design.kind} has no power table")
        name, options = next(iter(study.design.power)), power_options(study)
    if name not in tables:
        raise ParameterError.must("design", f"be one of {', '.join(tables)}, or a study", name)
    overrides = {
        "participants": participants,
        "trials": trials,
        "effect": effect,
        "person_sd": person_sd,
        "trial_sd": trial_sd,
        "margin": margin,
        "items": items,
    }
    options |= {key: value for key, value in overrides.items() if value is not None and value != ()}
    alpha = options.pop("alpha", ALPHA)
    assumed = replace(tables[name].power[name], **options)
    method = tables[name].power_method(assumed.kind)
    table = power_table(
        name, assumed, method, simulations=simulations, seed=seed, alpha=alpha, progress=progress
    )
    plain: dict[str, Any] = finite_json(table.as_dict())
    return plain | {"text": power_text(table, method)}


def power_options(study: Study) -> dict[str, Any]:
    """Return the options of `power_table` in a study's file: alpha, margin, and numbers of trials."""
    options: dict[str, Any] = {"alpha": study.planned.alpha}
    name = next(iter(study.design.margins), "")
    if name in study.planned.values:
        options["margin"] = study.planned.values[name]
    return options | study.design.power_options(study.setting)
