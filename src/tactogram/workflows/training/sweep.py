"""Sweep over a recipe's values, ranges and choices of a search space, by Ray Tune; weak trials are stopped early."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from tactogram.errors import ParameterError, TactogramError
from tactogram.evaluation.report import ReportSection, ReportTable, ReportText, write_report
from tactogram.extras import imported
from tactogram.model import Stage
from tactogram.recipe import run_id
from tactogram.signal.io.atomic import check_writable, write_text
from tactogram.text_files import read_toml
from tactogram.training.device import make_fabric
from tactogram.training.loop import fit, steps_done
from tactogram.training.run import TrainingPosition, run_at
from tactogram.validation import validated
from tactogram.workflows.progress import ProgressCallback, never, silent
from tactogram.workflows.training.execution import train_plan, training_material
from tactogram.workflows.training.plan import TrainingRequest, planned
from tactogram.workflows.workers.one_task import one_thread
from tactogram.workflows.workers.ray_cluster import connected

NINTHS, FACTOR = 9, 3
"""A trial is validated after 1/9, 1/3 and all of its steps, and the best third goes on (Li et al. 2020, ASHA)."""


def sweep(
    request: TrainingRequest,
    space_file: Path | str,
    *,
    out: Path | str | None,
    on: str = "ray",
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Train a model with drawn values of its recipe, and keep the best run.

    A sweep that was killed goes on when it is started again with the same ``out``.

    Parameters
    ----------
    request : TrainingRequest
        What all trials share.
    space_file : path
        A `SearchSpace`.
    out : path
        Folder of the sweep.
    on : str
        ``ray`` or ``ray:ADDRESS``.

    Returns
    -------
    dict
        ``run`` (of the best values), ``best`` (values by key), ``measure``, ``goal``, ``validation`` (of that run),
        ``report``, and ``trials``, best first: ``changes``, ``value``, ``ninths`` (of the steps), ``seconds``,
        ``error``. The folder has ``sweep.json``, ``sweep.html`` and the run, ``best``.

    Raises
    ------
    ParameterError
        If the space is wrong, no trial has a value of its measure, or ``out`` is missing or cannot be written to.
    MissingExtraError
        If Ray is not installed.
    """
    engine, _, address = on.partition(":")
    if engine != "ray":
        raise ParameterError.must("on", "be ray or ray:ADDRESS for a sweep", on)
    if out is None:
        raise ParameterError.must("out", "be a folder for a sweep, got none")
    space, folder = SearchSpace.load(Path(space_file)), Path(out).absolute()
    check_writable(folder, folder=True)
    plan = planned(request)  # refuses what no trial could do
    simulated = plan.store.simulated
    trials_of = run_id({"space": space.model_dump(), "plan": plan.identity}, plan.store.sha256)
    trials = _trials(request.for_workers(), space, folder / f"trials-{trials_of}", address)
    progress("trials", len(trials), space.trials)
    if not trials or not math.isfinite(trials[0]["value"]):
        errors = [trial["error"] for trial in trials if trial["error"]]
        raise ParameterError(
            f"no trial has a value of {space.measure}: {errors[0] if errors else 'none ran'}"
        )
    best = trials[0]["changes"]
    run = train_plan(
        planned(replace(request, changes=dict(request.changes or {}) | best)),
        run_at(folder / "best"),
        resume=(folder / "best" / "recipe.toml").exists(),
        accelerator=request.accelerator,
        devices=request.devices,
        logger=request.logger,
        progress=progress,
    )
    result: dict[str, Any] = {
        "run": str(run.folder),
        "best": best,
        "measure": space.measure,
        "goal": space.goal,
        "validation": run.facts()["validation"],
        "trials": [row | {"value": row["value"] if math.isfinite(row["value"]) else None} for row in trials],
    }
    result["report"] = str(_report(folder / "sweep.html", request.model, result, simulated=simulated))
    write_text(folder / "sweep.json", json.dumps(result, indent=1) + "\n")
    return result


def drop_torn_states(place: Path) -> None:
    """Delete states of a sweep that a kill cut short; Ray would end a sweep that it restores from one."""
    for file in place.glob("experiment_state-*.json"):
        try:
            json.loads(file.read_text(encoding="utf-8"))
        except ValueError:
            file.unlink()


def _trials(request: TrainingRequest, space: SearchSpace, folder: Path, address: str) -> list[dict[str, Any]]:
    """Return the trials of a sweep, best first."""
    os.environ.setdefault("RAY_AIR_NEW_OUTPUT", "0")
    with connected(address):
        tune: Any = imported("ray.tune", extra="ray", what="a sweep")
        schedulers: Any = imported("ray.tune.schedulers", extra="ray", what="a sweep")
        search: Any = imported("ray.tune.search", extra="ray", what="a sweep")
        trainable = tune.with_resources(
            tune.with_parameters(_trial, request=request, measure=space.measure, goal=space.goal), {"cpu": 1}
        )
        drop_torn_states(folder)
        if tune.Tuner.can_restore(str(folder)):
            tuner = tune.Tuner.restore(str(folder), trainable=trainable, resume_unfinished=True)
        else:
            tuner = tune.Tuner(
                trainable,
                param_space={key: _domain(tune, distribution) for key, distribution in space.vary.items()},
                tune_config=tune.TuneConfig(
                    metric=space.measure,
                    mode=space.goal,
                    num_samples=space.trials,
                    reuse_actors=True,  # a process imports torch for longer than a small trial trains
                    search_alg=search.BasicVariantGenerator(random_state=space.seed),
                    scheduler=schedulers.ASHAScheduler(
                        time_attr="ninths", max_t=NINTHS, grace_period=1, reduction_factor=FACTOR
                    ),
                ),
                run_config=tune.RunConfig(
                    name=folder.name,
                    storage_path=str(folder.parent),
                    failure_config=tune.FailureConfig(max_failures=3),  # of workers and nodes
                    verbose=0,
                ),
            )
        trials = [
            {
                "changes": dict(result.config or {}),
                "value": float((result.metrics or {}).get(space.measure, _worst(space.goal))),
                "ninths": int((result.metrics or {}).get("ninths", 0)),
                "seconds": round(float((result.metrics or {}).get("time_total_s", 0.0)), 2),
                "error": (result.metrics or {}).get("error") or (str(result.error) if result.error else None),
            }
            for result in tuner.fit()
        ]
    sign = -1 if space.goal == "max" else 1
    # Those that ran to the end first: a trial that was stopped was behind the others of its age.
    return sorted(trials, key=lambda trial: (trial["ninths"] < NINTHS, sign * trial["value"]))


def _domain(tune: Any, dimension: Dimension) -> Any:
    if dimension.choices:
        return tune.choice(list(dimension.choices))
    low, high = dimension.low, dimension.high
    if dimension.integer and low is not None and high is not None:
        draw = tune.lograndint if dimension.log else tune.randint
        return draw(int(low), int(high) + 1)
    return (tune.loguniform if dimension.log else tune.uniform)(low, high)


def _worst(goal: str) -> float:
    return -math.inf if goal == "max" else math.inf


def _trial(changes: Mapping[str, Any], *, request: TrainingRequest, measure: str, goal: str) -> None:
    """Train with some values, and report the validation; a `TactogramError` is reported as the worst value."""
    from ray import tune

    with one_thread():
        try:
            _train_and_report(
                replace(request, changes=dict(request.changes or {}) | dict(changes)), measure, tune
            )
        except TactogramError as error:
            tune.report({measure: _worst(goal), "ninths": NINTHS, "error": str(error)})


def _train_and_report(request: TrainingRequest, measure: str, tune: Any) -> None:
    plan = planned(request)
    fabric = make_fabric(plan.recipe.training, accelerator=request.accelerator)
    kind, examples, validation = training_material(plan, fabric, None, silent, never)
    learner = plan.facts.build(plan.config, kind, seed=plan.recipe.seed)
    learner.setup(make_fabric(plan.recipe.training, accelerator=request.accelerator))
    learner.set_validation(validation)
    stages = learner.stages(examples)
    total = sum(stage.steps for stage in stages)
    due = {math.ceil(total * ninths / NINTHS): ninths for ninths in (1, FACTOR, NINTHS)}

    def report(ninths: int) -> None:
        measures = learner.validate(validation)
        if measure not in measures:
            raise ParameterError.must("measure", f"be one of {', '.join(measures) or 'none'}", measure)
        tune.report({measure: measures[measure], "ninths": ninths})

    def on_step(position: TrainingPosition, stage: Stage, losses: dict[str, float]) -> None:
        if ninths := due.pop(steps_done(stages, position), None):
            report(ninths)

    fit(learner, examples, seed=plan.recipe.seed, on_step=on_step)
    if due:  # a stage was not needed
        report(NINTHS)


def _report(path: Path, model: str, result: Mapping[str, Any], *, simulated: bool) -> Path:
    keys = list(result["best"])
    rows = [
        (
            *(trial["changes"].get(key) for key in keys),
            trial["value"],
            f"{trial['ninths']}/{NINTHS}",
            trial["seconds"],
            trial["error"],
        )
        for trial in result["trials"]
    ]
    header = (*keys, result["measure"], "of the steps", "seconds", "error")
    kept = ", ".join(
        f"{key} = {value:.4g}" if isinstance(value, float) else f"{key} = {value}"
        for key, value in result["best"].items()
    )
    return write_report(
        path,
        title=f"Sweep: {model}",
        summary=f"{len(rows)} trials; the best run, {result['run']}, has {kept}.",
        simulated=simulated,
        sections=[
            ReportSection("Trials", [ReportTable(header, rows, "Best first; early stopping by ASHA.")]),
            ReportSection("Validation of the best run", [ReportText(json.dumps(result["validation"]))]),
        ],
    )


class Dimension(BaseModel):
    """Values of one key: ``choices``, or the range from ``low`` to ``high``, both included."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    choices: tuple[Any, ...] = ()
    low: float | None = None
    high: float | None = None
    log: bool = False
    """Draw the logarithm evenly."""
    integer: bool = False

    @model_validator(mode="after")
    def _choices_or_range(self) -> Self:
        ranged = self.low is not None and self.high is not None
        if bool(self.choices) == ranged or (self.low is None) != (self.high is None):
            raise ValueError("must have choices, or low and high")
        if self.low is not None and self.high is not None:
            if not self.low < self.high:
                raise ValueError(f"low must be < high, got {self.low:g} and {self.high:g}")
            if self.log and self.low <= 0:
                raise ValueError(f"low must be > 0 with log, got {self.low:g}")
            if self.integer and not (self.low.is_integer() and self.high.is_integer()):
                raise ValueError(
                    f"low and high must be whole with integer, got {self.low:g} and {self.high:g}"
                )
        return self


class SearchSpace(BaseModel):
    """A sweep: what is varied, and by which figure of the validation trials are compared."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    measure: str
    """A key of the model's validation, such as ``recording_accuracy``."""
    goal: Literal["max", "min"]
    trials: int = Field(default=16, ge=1)
    seed: int = Field(default=0, ge=0)
    vary: dict[str, Dimension] = Field(min_length=1)
    """By dotted key of the recipe."""

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a TOML file; a `ParameterError` names the key that is wrong."""
        return validated(cls, read_toml(path), where=str(path))
