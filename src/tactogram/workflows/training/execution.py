"""Execution of a training plan in the folder of a run, and the loggers of trainings."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any
from uuid import uuid4

import torch.distributed as dist

from tactogram.datasets import part_examples, require_photographs, signal_kind
from tactogram.datasets.scratch import scratch_of
from tactogram.errors import ParameterError, StoppedError
from tactogram.extras import imported
from tactogram.model import Kind, Model, SignalKind
from tactogram.signal.io.atomic import atomic_write, check_writable, write_text
from tactogram.training.device import chosen_precision, make_fabric, memory_checked
from tactogram.training.loop import TrainingLogger, run_training, steps_done
from tactogram.training.run import BEGINNING, Run, TrainingPosition, open_run
from tactogram.workflows.progress import ProgressCallback, never, silent
from tactogram.workflows.training.known_photographs import save_photographs
from tactogram.workflows.training.plan import TrainingPlan, plan_of
from tactogram.workflows.training.run_folder import begin, claim_run, discard_run
from tactogram.workflows.training.run_lock import run_lock


def train_plan(
    plan: TrainingPlan,
    run: Run,
    *,
    resume: bool = False,
    accelerator: str = "auto",
    devices: int = 1,
    logger: str | None = None,
    prepared: Path | None = None,
    progress: ProgressCallback = silent,
    stop: Callable[[], bool] = never,
) -> Run:
    """Carry out a plan in the folder of ``run``, or continue it there, and return the finished run.

    ``prepared`` is a folder for prepared recordings, which trainings share; by default they are prepared anew.

    Of several processes (`tactogram.training.device.make_fabric`) the first one writes the run; for the others it may
    not be finished yet. Errors as of `train`; another process that trains there is an error, too.
    """
    facts, chosen = plan.facts, plan.recipe
    if logger:
        check_logger(logger)
    fabric = make_fabric(chosen.training, accelerator=accelerator, devices=devices)
    first = fabric.is_global_zero
    if first:
        claim_run(run, plan.identity, resume)
    if fabric.broadcast(run.finished):
        run.forget_checkpoint()
        return run
    if first:
        check_writable(run.folder, folder=True)
    else:
        progress = silent
    kind, examples, validation = training_material(plan, fabric, prepared, progress, stop)

    def untrained() -> Model:
        built: Model = facts.build(plan.config, kind, seed=chosen.seed)
        built.setup(fabric)
        return built

    learner = untrained()
    if devices > 1 and not learner.divides_batches:
        raise ParameterError(
            f"{facts.name} cannot divide its batches, or is a closed form: train it in one process, without devices"
        )
    chosen_by = learner.set_validation(validation)
    stages = learner.stages(examples)  # refuses unsuitable examples before anything is written
    updates = [f"{name} {count:,}" for stage in stages for name, count in stage.total_updates.items()]
    plan_note = f"updates in all: {', '.join(updates)}" if updates else ""
    notes = {"choose weights": chosen_by, "plan": plan_note}
    if chosen.training.precision == "auto":
        notes["precision"] = f"precision {chosen_precision('auto', accelerator)}, by processor or GPU"
    notes = {task: note for task, note in notes.items() if note}
    for task, note in notes.items() if first else ():
        progress(task, 1, 1, note)
    if first and not resume:
        begin(run, plan)
    fabric.barrier()
    with run_lock(run.folder) if first else nullcontext():
        start = _restored(run, learner, fabric) if resume else TrainingPosition()
        log = None
        try:
            if logger and first:
                log = make_logger(logger, run.folder, start=steps_done(stages, start))
                log.log_hyperparams(chosen.model_dump(mode="json", exclude_none=True))
            with memory_checked(f"the training of {facts.name}"):
                run_training(
                    learner,
                    examples,
                    chosen,
                    run=run,
                    start=start,
                    fabric=fabric,
                    logger=log,
                    trial=untrained if devices == 1 else None,
                    progress=progress,
                    stop=stop,
                )
        except Exception:  # of any kind: without a first step there is nothing to resume
            if log:
                log.finalize("failed")
            if first and not resume:
                discard_run(run)
            raise
        if devices > 1:  # what follows, such as a validation, the first one does alone
            fabric.barrier()
            dist.destroy_process_group()
        if first:
            measures = _finish(run, learner, kind, plan, examples, validation, notes=list(notes.values()))
        if log:
            values = {f"validation/{name}": value for name, value in measures.items()}
            log.log_metrics(values, step=sum(stage.steps for stage in stages))
            log.finalize("success")
    return run


def resume(
    folder: Path | str,
    *,
    data: Path | str | None = None,
    accelerator: str = "auto",
    devices: int = 1,
    logger: str | None = None,
    model_folders: Sequence[Path] = (),
    progress: ProgressCallback = silent,
    stop: Callable[[], bool] = never,
) -> Run:
    """Continue the run in ``folder`` from its last checkpoint, and return it finished.

    ``data`` is where its data set is now; by default where it was when the run began. ``model_folders`` are further to
    those recorded in the run. The others are as of `tactogram.train`.

    Raises
    ------
    RunError
        If there is no run, its data is gone or has changed, or another process trains it.
    DataError
        If its split is missing.
    StoppedError
        If ``stop`` ended it; the message names the last step.
    """
    run = open_run(folder)
    if run.finished:
        run.forget_checkpoint()
        return run
    return train_plan(
        plan_of(run, data=data, model_folders=model_folders),
        run,
        resume=True,
        accelerator=accelerator,
        devices=devices,
        logger=logger,
        progress=progress,
        stop=stop,
    )


def _restored(run: Run, learner: Model, fabric: Any) -> TrainingPosition:
    """Load the last checkpoint into every process's ``learner``."""
    start: TrainingPosition = fabric.broadcast(run.restore(learner) if fabric.is_global_zero else None)
    if start != BEGINNING and fabric.world_size > 1:
        state = fabric.broadcast(learner.state() if fabric.is_global_zero else None)
        if not fabric.is_global_zero:
            learner.load_state(state)
    return start


def training_material(
    plan: TrainingPlan,
    fabric: Any,
    prepared: Path | None,
    progress: ProgressCallback,
    stop: Callable[[], bool],
) -> tuple[Kind, Sequence[Any], Sequence[Any]]:
    """Return the kind of all examples, and those for training and validation."""
    parts, prepare, rated = plan.parts, plan.recipe.prepare, plan.rated
    if rated is not None:
        examples = rated.examples(parts, "train", prepare)
        return rated.kind(examples), examples, rated.examples(parts, "validation", prepare)
    cache = prepared
    if fabric.world_size > 1:
        cache = fabric.broadcast(scratch_of(fabric) if fabric.is_global_zero else None)
    recorded = part_examples(plan.store, parts, "train", prepare, label=plan.label, cache_dir=cache)
    if "image" in plan.facts.needs:
        require_photographs(recorded)
    if fabric.is_global_zero:
        recorded.prepare_all(progress=_preparing(progress, stop))
    fabric.barrier()
    kind = signal_kind(recorded, simulated=plan.store.simulated)
    ratings = plan.store.ratings
    if "words" in plan.facts.instead and ratings is not None:
        kind = replace(kind, words=ratings.words, scale=(ratings.scale.low, ratings.scale.high))
    unseen = part_examples(plan.store, parts, "validation", prepare, label=plan.label, cache_dir=cache)
    return kind, recorded, unseen


def _finish(
    run: Run,
    learner: Model,
    kind: Kind,
    plan: TrainingPlan,
    examples: Sequence[Any],
    validation: Sequence[Any],
    *,
    notes: Sequence[str],
) -> dict[str, float]:
    """Write the trained learner, its index and figures, finish the run, and return its validation."""
    if learner.embeds and plan.facts.task == "classification":
        from tactogram.workflows.training.surface_index import build_index

        build_index(learner, examples, validation).save(run)
    if isinstance(kind, SignalKind) and "image" in (*plan.facts.needs, *plan.facts.instead):
        save_photographs(run, examples)
    outcome = learner.outcome()
    for name, figure in learner.figures().items():
        with atomic_write(run.folder / "figures" / f"{name}.png") as part:
            figure.savefig(part, dpi=120, format="png")
    measures = learner.validate(validation)
    facts = {
        "model": plan.facts.name,
        "label": plan.label,
        **({"outcome": outcome} if outcome else {}),
        "validation": measures,
        "notes": list(notes),
    }
    # Last: the run counts as finished from here on.
    run.finish(learner, kind, facts)
    return measures


def _preparing(progress: ProgressCallback, stop: Callable[[], bool]) -> Callable[[int, int], None]:
    """Return a callback that shows the preparation's progress, and ends it if ``stop`` is true."""

    def show(done: int, total: int) -> None:
        progress("prepare", done, total)
        if stop():
            raise StoppedError("stopped while recordings were prepared; the run is as it was")

    return show


def make_logger(name: str, folder: Path, *, start: int) -> TrainingLogger:
    """Return the logger ``tensorboard`` or ``wandb`` for the run in ``folder``.

    TensorBoard's events are in the folder ``tensorboard`` of the run; Weights & Biases receives the run under the
    folder's name, in the project ``tactogram`` or that of its variable ``WANDB_PROJECT``.

    ``start``: finished steps of all stages; what a killed training logged after them is replaced.

    Raises `MissingExtraError` if its package is not installed.
    """
    check_logger(name)
    if name == "tensorboard":
        from lightning_fabric.loggers.tensorboard import TensorBoardLogger

        return TensorBoardLogger(folder, name="", version="tensorboard", purge_step=start or None)
    return WandbLogger(folder)


def check_logger(name: str) -> None:
    """Raise a `MissingExtraError` if a logger's package is not installed."""
    package = {"tensorboard": "tensorboardX", "wandb": "wandb"}[name]
    imported(package, extra="loggers", what=f"the logger {name}")


class WandbLogger:
    """Weights & Biases, which Fabric has no logger for; its variables, such as ``WANDB_MODE=offline``, hold."""

    def __init__(self, folder: Path) -> None:
        wandb = imported("wandb", extra="loggers", what="the logger wandb")
        known = folder / "wandb-id.txt"
        id = known.read_text() if known.exists() else uuid4().hex
        self._run: Any = wandb.init(
            project=os.environ.get("WANDB_PROJECT", "tactogram"),
            name=folder.resolve().name,
            id=id,
            dir=folder,
            resume="allow",
        )
        write_text(known, id)

    def log_hyperparams(self, params: dict[str, Any]) -> None:
        """Log the recipe."""
        self._run.config.update(params, allow_val_change=True)

    def log_metrics(self, metrics: Mapping[str, float], step: int) -> None:
        """Log values after a number of steps."""
        self._run.log(dict(metrics), step=step)

    def finalize(self, status: str) -> None:
        """End."""
        self._run.finish(exit_code=0 if status == "success" else 1)
