"""Training of a model on a store or on given examples, and loading of runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from tactogram import models
from tactogram.datasets import (
    Examples,
    Label,
    Split,
    Store,
    open_store,
    require_photographs,
    signal_kind,
)
from tactogram.datasets.splits.split import By
from tactogram.errors import ParameterError, RunError, StoppedError
from tactogram.model import (
    CheckpointSelector,
    Classifier,
    Embedder,
    Example,
    FigureReporter,
    Generator,
    Kind,
    Learner,
    OutcomeReporter,
    Predictor,
    SignalKind,
)
from tactogram.recipe import Preparation, Recipe
from tactogram.signal import Signal
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.io.writable import check_writable
from tactogram.training.device import make_fabric
from tactogram.training.loop import BEGINNING, TrainingPosition, fit
from tactogram.training.run import Run
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.plan import TrainingPlan, TrainingRequest, planned
from tactogram.workflows.training.run_folder import begin, claim_run, discard_run
from tactogram.workflows.training.run_lock import run_lock

Stop = Callable[[], bool]
"""Says whether a training should end where it is; asked after each step."""


def never() -> bool:
    """Return False: nobody asks a training to stop."""
    return False


@dataclass(frozen=True)
class LoadedRun:
    """A finished run, ready for use.

    ``model`` is of the protocol that ``facts.task`` says, and of the optional ones of `tactogram.model` that it keeps.
    """

    run: Run
    facts: models.ModelInfo
    recipe: Recipe
    any_kind: Kind
    model: object

    @property
    def kind(self) -> SignalKind:
        """What every signal of the run has in common; refuses a run of images."""
        if not isinstance(self.any_kind, SignalKind):
            raise ParameterError(f"{self.run.name}: {self.facts.name} is of images, not of signals")
        return self.any_kind

    @property
    def generator(self) -> Generator:
        """The model; refuses one that does not generate."""
        if not isinstance(self.model, Generator):
            raise ParameterError(f"{self.run.name}: {self.facts.name} does not generate")
        return self.model

    @property
    def classifier(self) -> Classifier:
        """The model; refuses one that does not classify."""
        if not isinstance(self.model, Classifier):
            raise ParameterError(f"{self.run.name}: {self.facts.name} is not a classifier")
        return self.model

    @property
    def predictor(self) -> Predictor:
        """The model; refuses one that predicts no scores."""
        if not isinstance(self.model, Predictor):
            raise ParameterError(f"{self.run.name}: {self.facts.name} is not a predictor of scores")
        return self.model

    @property
    def embedder(self) -> Embedder:
        """The model; refuses one that does not turn signals into vectors."""
        if not isinstance(self.model, Embedder):
            raise ParameterError(f"{self.run.name}: {self.facts.name} has no embedding to search by")
        return self.model

    @property
    def config(self) -> BaseModel:
        """The model's own configuration."""
        return self.facts.config(self.recipe.config)

    @property
    def simulated(self) -> bool:
        """Whether any of the training data was simulated."""
        return self.any_kind.simulated

    def prepare(self, signal: Signal) -> Signal:
        """Return ``signal`` as the model was trained on it: axes, band and rate of the recipe."""
        prepared = self.as_trained.apply(signal)
        self.kind.check(prepared)
        return prepared

    @property
    def as_trained(self) -> Preparation:
        """The recipe's preparation, to the rate of the training signals whatever a recording's own is."""
        return self.recipe.prepare.model_copy(update={"rate": float(self.kind.rate)})


def load_run(folder: Path | str, *, device: str = "cpu", model_folders: Sequence[Path] = ()) -> LoadedRun:
    """Return the finished run in ``folder``.

    Raises
    ------
    RunError
        If there is none, it is not finished, or its files are broken.
    """
    from tactogram.training.checkpoint import load_state

    run = Run.open(Path(folder))
    kind, recipe = run.kind(), run.recipe
    facts = models.find(recipe.model, model_folders)
    model = facts.build(facts.config(recipe.config), kind, seed=recipe.seed, device=device)
    state, _ = load_state(run.folder / "model.safetensors")
    try:
        model.load_state(state)
    except (KeyError, TypeError, ValueError, RuntimeError) as error:
        line = str(error).split("\n")[0]
        raise RunError(f"{run.folder}: the weights are not of the recipe beside them: {line}") from error
    return LoadedRun(run, facts, recipe, kind, model)


def train(
    model: str,
    data: Path | str,
    *,
    recipe: str = "quick",
    changes: Mapping[str, Any] | None = None,
    split: str = "",
    by: By = "recording",
    label: Label = "material",
    where: Mapping[str, str] | None = None,
    out: Path | str | None = None,
    resume: bool = False,
    accelerator: str = "auto",
    devices: int = 1,
    model_folders: Sequence[Path] = (),
    progress: ProgressCallback = silent,
    stop: Stop = never,
) -> Run:
    """Train ``model`` on the training part of ``data`` and return the finished run.

    Parameters
    ----------
    model : str
        Name of a model.
    data : path
        A store.
    recipe : str
        Name of one of the model's recipes, or a TOML file.
    changes : mapping, optional
        Values by dotted key that replace the recipe's.
    split : str
        ``last=N`` keeps the last N recordings of each material for testing, ``all`` keeps none apart; by
        default a fifth is kept for testing and a tenth for validation, drawn by the recipe's seed.
    by : str
        What must not stand on both sides: ``recording``, ``session``, ``subject`` or ``condition``.
    label : str
        Fields that make the class, joined by ``+``.
    where : mapping, optional
        Keep only recordings whose fields have these values: ``A``, ``A|B`` (either), ``!A|B`` (neither).
    out : path, optional
        The run's folder; by default ``runs/MODEL-RECIPE-ID``.
    resume : bool
        Go on with the run in ``out`` from its last checkpoint.
    stop : callable
        Says whether to end where it is: a checkpoint of that step is written first.

    Raises
    ------
    ParameterError
        If the folder cannot be written to, or the model cannot learn from what is asked for.
    RunError
        If the folder holds another run, or ``resume`` meets other data or another recipe than it began with.
    StoppedError
        If ``stop`` said so; the message says how much is kept.
    """
    asked = TrainingRequest(
        model,
        data,
        recipe=recipe,
        changes=changes or {},
        split=split,
        by=by,
        label=label,
        where=where or {},
        model_folders=model_folders,
    )
    plan = planned(asked)
    folder = Path(out) if out else Path("runs") / f"{model}-{Path(recipe).stem}-{plan.identity}"
    return train_plan(
        plan,
        folder,
        resume=resume,
        accelerator=accelerator,
        devices=devices,
        progress=progress,
        stop=stop,
    )


def train_plan(
    plan: TrainingPlan,
    folder: Path,
    *,
    resume: bool = False,
    accelerator: str = "auto",
    devices: int = 1,
    progress: ProgressCallback = silent,
    stop: Stop = never,
) -> Run:
    """Train what is planned in ``folder``, or go on with it there, and return the finished run.

    Parameters and errors as of `train`; another process that trains in ``folder`` is an error, too.
    """
    facts, chosen = plan.facts, plan.recipe
    fabric = make_fabric(chosen.training, accelerator=accelerator, devices=devices)
    first = fabric.is_global_zero
    run = claim_run(folder, plan.identity, resume) if first else Run(folder)
    if first and run.finished:
        return run
    check_writable(folder, folder=True)
    kind, examples, validation = _material(plan, progress, stop)
    learner = facts.build(plan.config, kind, seed=chosen.seed)
    learner.setup(fabric)
    note = learner.set_validation(validation) if isinstance(learner, CheckpointSelector) else ""
    if note and first:
        progress("choose weights", 1, 1, note)
    learner.stages(examples)  # refuses what it cannot learn from, before anything is written
    if first and not resume:
        begin(run, plan)
    fabric.barrier()
    with run_lock(folder) if first else nullcontext():
        start = run.restore(learner) if resume else TrainingPosition()
        try:
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
        except ParameterError:
            if first and not resume:
                discard_run(run)
            raise
        if first:
            _finish(run, learner, kind, plan, examples, validation, notes=[note] if note else [])
    fabric.barrier()
    return run


def _material(
    plan: TrainingPlan, progress: ProgressCallback, stop: Stop
) -> tuple[Kind, Sequence[Any], Sequence[Any]]:
    """Return what all examples have in common, those that are learned from, and those that validate."""
    parts, prepare, rated = plan.parts, plan.recipe.prepare, plan.rated
    if rated is not None:
        examples = rated.examples(parts, "train", prepare)
        return rated.kind(examples), examples, rated.examples(parts, "validation", prepare)
    recorded = part_examples(plan.store, parts, "train", prepare, label=plan.label)
    if "image" in plan.facts.needs:
        require_photographs(recorded)
    recorded.prepare_all(progress=_preparing(progress, stop))
    kind = signal_kind(recorded, simulated=plan.store.simulated)
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
    """Write what a learner leaves behind."""
    if isinstance(learner, Classifier) and isinstance(learner, Embedder):
        from tactogram.workflows.recognition.search import index_run

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
    stop: Stop = never,
) -> None:
    """Fit ``learner``; log and save to ``run`` where there is one, and show progress.

    Raises
    ------
    StoppedError
        If ``stop`` said so, after the checkpoint of that step.
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
                f"stopped after step {position.step} of {stage.steps} of {stage.name}; all of it is kept in "
                f"{run.folder}: `tactogram train --resume {run.folder}` goes on"
            )

    fit(learner, examples, seed=recipe.seed, start=start, rank=rank, on_step=on_step)


def part_examples(store: Store, split: Split, part: str, prepare: Preparation, *, label: Label) -> Examples:
    """Return one part of ``split``, with the photographs it may use where they were split too."""
    photographs = split.photographs.get(part, ()) if split.photographs else None
    return Examples(store, split.parts[part], prepare, label=label, photographs=photographs)


def _preparing(progress: ProgressCallback, stop: Stop) -> Callable[[int, int], None]:
    """Return what shows how far the preparation is, and ends it where ``stop`` says so."""

    def show(done: int, total: int) -> None:
        progress("prepare", done, total)
        if stop():
            raise StoppedError("stopped while recordings were prepared; the run is as it was")

    return show


def _draw(run: Run, learner: Learner) -> None:
    """Write what a learner draws of its training to ``figures/NAME.png``."""
    drawn = learner.figures() if isinstance(learner, FigureReporter) else {}
    for name, figure in drawn.items():
        with atomic_write(run.folder / "figures" / f"{name}.png") as part:
            figure.savefig(part, dpi=120, format="png")


def test_part(run: Run) -> tuple[Store, Split]:
    """Return the store that ``run`` was trained on and the split it used.

    Raises
    ------
    RunError
        If the store is gone, or recordings of the split are. What was added to it since does no harm: a
        recording's id follows from its samples.
    """
    facts = run.data
    try:
        store = open_store(facts["path"])
    except Exception as error:
        raise RunError(f"{run.folder}: its data is not at {facts['path']} any more; give --data") from error
    split = Split.load(run.folder / "split.json")
    if missing := [s.id for part in split.parts.values() for s in part if s.id not in store]:
        raise RunError(
            f"{facts['path']}: {len(missing)} recordings of the run are gone from it (first: {missing[0]}); "
            "give --data for recordings kept apart"
        )
    return store, split
