"""Training of a model on a store, or on given examples."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

from tactogram.datasets import require_photographs, signal_kind
from tactogram.errors import StoppedError
from tactogram.model import (
    CheckpointSelector,
    Classifier,
    Embedder,
    Example,
    FigureReporter,
    Kind,
    Learner,
    OutcomeReporter,
    Stage,
)
from tactogram.recipe import Recipe
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.io.writable import check_writable
from tactogram.training.device import make_fabric, memory_checked
from tactogram.training.loop import BEGINNING, TrainingPosition, fit
from tactogram.training.run import Run
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.request import takes
from tactogram.workflows.training.loaded_run import part_examples
from tactogram.workflows.training.plan import TrainingPlan, planned
from tactogram.workflows.training.requests import TrainingRequest, never
from tactogram.workflows.training.run_folder import begin, claim_run, discard_run
from tactogram.workflows.training.run_lock import run_lock


@takes(TrainingRequest)
def train(request: TrainingRequest) -> Run:
    """Train a model on the training part of a store and return the finished run.

    By default a fifth of the recordings is kept for testing and a tenth for validation, drawn by the recipe's seed.

    Raises
    ------
    ParameterError
        If the folder cannot be written to, or the model cannot learn from the data.
    RunError
        If the folder holds another run, or ``resume`` meets other data or another recipe than it began with.
    StoppedError
        If ``stop`` ended it; the message names the last step.
    """
    plan = planned(request)
    name = f"{request.model}-{Path(request.recipe).stem}-{plan.identity}"
    return train_plan(
        plan,
        Path(request.out) if request.out else Path("runs") / name,
        resume=request.resume,
        accelerator=request.accelerator,
        devices=request.devices,
        progress=request.progress,
        stop=request.stop,
    )


def train_plan(
    plan: TrainingPlan,
    folder: Path,
    *,
    resume: bool = False,
    accelerator: str = "auto",
    devices: int = 1,
    progress: ProgressCallback = silent,
    stop: Callable[[], bool] = never,
) -> Run:
    """Carry out a plan in ``folder``, or continue it there, and return the finished run.

    Errors as of `train`; another process that trains in ``folder`` is an error, too.
    """
    facts, chosen = plan.facts, plan.recipe
    fabric = make_fabric(chosen.training, accelerator=accelerator, devices=devices)
    first = fabric.is_global_zero
    run = claim_run(folder, plan.identity, resume) if first else Run(folder)
    if first and run.finished:
        return run
    check_writable(folder, folder=True)
    kind, examples, validation = training_material(plan, progress, stop)
    learner = facts.build(plan.config, kind, seed=chosen.seed)
    learner.setup(fabric)
    chosen_by = learner.set_validation(validation) if isinstance(learner, CheckpointSelector) else ""
    # `stages` refuses unsuitable examples before anything is written.
    notes = {"choose weights": chosen_by, "plan": update_text(learner.stages(examples))}
    notes = {task: note for task, note in notes.items() if note}
    for task, note in notes.items() if first else ():
        progress(task, 1, 1, note)
    if first and not resume:
        begin(run, plan)
    fabric.barrier()
    with run_lock(folder) if first else nullcontext():
        start = run.restore(learner) if resume else TrainingPosition()
        try:
            with memory_checked(f"the training of {facts.name}"):
                run_training(
                    learner,
                    examples,
                    chosen,
                    run=run,
                    start=start,
                    rank=fabric.global_rank,
                    progress=progress,
                    stop=stop,
                )
        except Exception:  # of any kind: without a first step there is nothing to resume
            if first and not resume:
                discard_run(run)
            raise
        if first:
            _finish(run, learner, kind, plan, examples, validation, notes=list(notes.values()))
    fabric.barrier()
    return run


def update_text(stages: Sequence[Stage]) -> str:
    """Return the number of updates of each network in a training; "" where stages do not state them."""
    totals = [f"{name} {count:,}" for stage in stages for name, count in stage.total_updates.items()]
    return f"updates in all: {', '.join(totals)}" if totals else ""


def training_material(
    plan: TrainingPlan, progress: ProgressCallback, stop: Callable[[], bool]
) -> tuple[Kind, Sequence[Any], Sequence[Any]]:
    """Return the kind of all examples, and those for training and validation."""
    parts, prepare, rated = plan.parts, plan.recipe.prepare, plan.rated
    if rated is not None:
        examples = rated.examples(parts, "train", prepare)
        return rated.kind(examples), examples, rated.examples(parts, "validation", prepare)
    recorded = part_examples(plan.store, parts, "train", prepare, label=plan.label)
    if "image" in plan.facts.needs:
        require_photographs(recorded)
    recorded.prepare_all(progress=_preparing(progress, stop))
    kind = signal_kind(recorded, simulated=plan.store.simulated)
    ratings = plan.store.ratings
    if "words" in plan.facts.instead and ratings is not None:
        kind = replace(kind, words=ratings.words, scale=(ratings.scale.low, ratings.scale.high))
    return kind, recorded, part_examples(plan.store, parts, "validation", prepare, label=plan.label)


def _finish(
    run: Run,
    learner: Learner,
    kind: Kind,
    plan: TrainingPlan,
    examples: Sequence[Any],
    validation: Sequence[Any],
    *,
    notes: Sequence[str],
) -> None:
    """Write the trained learner, its index and figures, and finish the run."""
    if isinstance(learner, Classifier) and isinstance(learner, Embedder):
        from tactogram.workflows.training.surface_index import index_run

        index_run(run, learner, examples, validation)
    outcome = {"outcome": learner.outcome()} if isinstance(learner, OutcomeReporter) else {}
    _draw(run, learner)
    facts = {
        "model": plan.facts.name,
        "label": plan.label,
        **outcome,
        "validation": learner.validate(validation),
        "notes": list(notes),
    }
    # Last: the run counts as finished from here on.
    run.finish(learner, kind, facts)


def run_training(
    learner: Learner,
    examples: Sequence[Example],
    recipe: Recipe,
    *,
    run: Run | None = None,
    start: TrainingPosition = BEGINNING,
    rank: int = 0,
    task: str = "",
    progress: ProgressCallback = silent,
    stop: Callable[[], bool] = never,
) -> None:
    """Fit ``learner``; log and save to ``run`` where there is one, and show progress.

    Raises
    ------
    StoppedError
        If ``stop`` ended it, after the checkpoint of that step.
    """
    every = recipe.training

    def on_step(position: TrainingPosition, stage: Any, losses: dict[str, float]) -> None:
        last = position.step == stage.steps
        if run is not None and rank == 0:
            if position.step % every.log_every == 0 or last:
                run.log(position, losses)
            if position.step % every.checkpoint_every == 0 or last:
                run.save_checkpoint(learner, position)
        note = " ".join(f"{name} {loss:.3g}" for name, loss in losses.items()) if len(losses) < 4 else ""
        progress(f"{task}{stage.name}", position.step, stage.steps, note)
        if run is not None and stop():
            if rank == 0:
                run.save_checkpoint(learner, position)
            raise StoppedError(
                f"stopped after step {position.step} of {stage.steps} of {stage.name}; all of it is in "
                f"{run.folder}: `tactogram train --resume {run.folder}` continues it"
            )

    fit(learner, examples, seed=recipe.seed, start=start, rank=rank, on_step=on_step)


def _preparing(progress: ProgressCallback, stop: Callable[[], bool]) -> Callable[[int, int], None]:
    """Return a callback that shows the preparation's progress, and ends it if ``stop`` is true."""

    def show(done: int, total: int) -> None:
        progress("prepare", done, total)
        if stop():
            raise StoppedError("stopped while recordings were prepared; the run is as it was")

    return show


def _draw(run: Run, learner: Learner) -> None:
    """Write a learner's figures of its training to ``figures/NAME.png``."""
    drawn = learner.figures() if isinstance(learner, FigureReporter) else {}
    for name, figure in drawn.items():
        with atomic_write(run.folder / "figures" / f"{name}.png") as part:
            figure.savefig(part, dpi=120, format="png")
