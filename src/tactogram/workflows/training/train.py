"""Training of a model on a store."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from tactogram.parameters import checked
from tactogram.workflows.progress import ProgressCallback, never, silent

if TYPE_CHECKING:
    from tactogram.datasets import Label
    from tactogram.training.run import Run

LoggerName = Literal["tensorboard", "wandb"]


@checked
def train(
    model: str,
    data: str | Path,
    *,
    recipe: str = "quick",
    changes: Mapping[str, Any] | None = None,
    band: tuple[float, float] | None = None,
    split: str = "",
    by: str = "recording",
    label: Label = "material",
    where: Mapping[str, str] | None = None,
    out: Path | str | None = None,
    accelerator: str = "auto",
    model_folders: Sequence[Path | str] = (),
    devices: int = 1,
    logger: LoggerName | None = None,
    resume: bool = False,
    progress: ProgressCallback = silent,
    stop: Callable[[], bool] = never,
) -> Run:
    """Train a model on the training part of a store and return the finished run.

    By default a fifth of the recordings is kept for testing and a tenth for validation, drawn by the recipe's seed.
    ``where`` keeps recordings whose fields have these values: ``A``, ``A|B`` (either), ``!A|B`` (neither), or none
    where the value is empty. With several ``devices`` Fabric starts this script or command again for each further
    process. ``stop`` is asked after each step: True ends the training after a checkpoint of that step.

    Parameters
    ----------
    model : str
        Name of the model.
    data : str or Path
        Store made by `data import` or `data simulate`.
    recipe : str
        paper, quick, tiny or a TOML file.
    changes : mapping, optional
        Change a value of the recipe; `tactogram models MODEL` lists them.
    band : tuple of float, optional
        Pass band in Hz, as prepare.band of the changes.
    split : str
        For testing: the last N recordings of a class (last=N), the last fifth of every recording (blocks), or none
        (all); by default a fifth of the recordings, and a tenth for validation.
    by : str
        Unit of the split, never on two sides: recording, session, subject, material or condition; for the
        cross-validation of a predictor of ratings: item, rater or both.
    label : str
        Definition of a class: material, material+contactor, or item, what is rated.
    where : mapping, optional
        Use only matching recordings, e.g. material=cork|tile, or material=!cork for all others.
    out : Path or str, optional
        Folder of the result, by default under runs.
    accelerator : str
        auto, cpu, cuda or mps.
    model_folders : sequence of Path or str
        Folder of further models.
    devices : int
        Processes of this machine, each with its own GPU, or on processors; a batch is divided among all.
    logger : str, optional
        Also log losses and validation to it.
    resume : bool
        Continue the run in the folder from its last checkpoint.

    Returns
    -------
    Run
        The finished run; ``run.folder`` holds its weights, recipe, split and metrics.

    Raises
    ------
    ParameterError
        If the folder cannot be written to, or the model cannot learn from the data.
    RunError
        If the folder holds another run, or ``resume`` meets other data or another recipe than it began with.
    StoppedError
        If ``stop`` ended it; the message names the last step.

    Examples
    --------
    >>> import tactogram
    >>> run = tactogram.train("stroke_cnn", "data", recipe="tiny", split="last=2")  # doctest: +SKIP
    >>> accuracy = run.facts()["validation"]["recording_accuracy"]  # doctest: +SKIP
    """
    from tactogram.training.run import run_at
    from tactogram.workflows.training.execution import train_plan
    from tactogram.workflows.training.plan import TrainingRequest, planned

    plan = planned(
        TrainingRequest(
            model, data, recipe=recipe, changes=changes, band=band, split=split, by=by, label=label, where=where,
            model_folders=model_folders,
        )
    )  # fmt: skip
    return train_plan(
        plan,
        run_at(out or Path("runs") / f"{model}-{Path(recipe).stem}-{plan.identity}"),
        resume=resume,
        accelerator=accelerator,
        devices=devices,
        logger=logger,
        progress=progress,
        stop=stop,
    )
