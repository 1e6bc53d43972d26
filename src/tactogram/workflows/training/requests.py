"""Requests of trainings and cross-validations."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.request import ON, PROCESSES, Argument, Option, Request

if TYPE_CHECKING:
    from tactogram.datasets import Label

LoggerName = Literal["tensorboard", "wandb"]
Purpose = Literal["generate", "photograph", "words"]


def never() -> bool:
    """Return False: nothing stops the training."""
    return False


@dataclass(frozen=True, kw_only=True)
class TrainingOptions(Request):
    """Recipe, recordings and split of a training.

    ``where`` keeps recordings whose fields have these values: ``A``, ``A|B`` (either), ``!A|B`` (neither), or
    none where the value is empty.
    """

    recipe: Annotated[str, Option("paper, quick, tiny or a TOML file", "NAME|FILE")] = "quick"
    changes: Annotated[
        Mapping[str, Any] | None,
        Option("change a value of the recipe; `tactogram models MODEL` lists them", "KEY=VALUE", "--set"),
    ] = None
    band: Annotated[
        tuple[float, float] | None, Option("pass band in Hz; as --set prepare.band=…", ("LO", "HI"))
    ] = None
    split: Annotated[
        str,
        Option(
            "for testing: the last N recordings of a class, the last fifth of every recording, or none (default: a "
            "fifth of the recordings, and a tenth for validation)",
            "last=N|blocks|all",
        ),
    ] = ""
    by: Annotated[
        str,
        Option(
            "unit of the split, never on two sides: recording, session, subject, material or condition; for the "
            "cross-validation of a predictor of ratings: item, rater or both"
        ),
    ] = "recording"
    label: Annotated[
        "Label", Option("definition of a class: material, material+contactor, or item, what is rated")
    ] = "material"
    where: Annotated[
        Mapping[str, str] | None,
        Option(
            "use only matching recordings, e.g. material=cork|tile, or material=!cork for all others",
            "KEY=VALUE",
        ),
    ] = None
    out: Annotated[Path | str | None, Option("folder of the result (default under runs)", "DIR")] = None
    accelerator: Annotated[str, Option("auto, cpu, cuda or mps")] = "auto"
    model_folders: Annotated[Sequence[Path | str], Option("folder of further models", "DIR", "--models")] = ()
    progress: ProgressCallback = silent

    @property
    def recipe_changes(self) -> dict[str, Any]:
        """Values of the recipe to change, by dotted key."""
        band = {} if self.band is None else {"prepare.band": list(self.band)}
        return dict(self.changes or {}) | band


@dataclass(frozen=True, kw_only=True)
class ProcessOptions(TrainingOptions):
    """`TrainingOptions`, and the processes and the log of one training."""

    devices: Annotated[
        int,
        Option(
            "processes of this machine, each with its own GPU, or on processors; a batch is divided among all"
        ),
    ] = 1
    logger: Annotated[LoggerName | None, Option("also log losses and validation to it")] = None


@dataclass(frozen=True)
class TrainingRequest(ProcessOptions):
    """A model to train on a store, in ``out``; ``resume`` continues the run there from its last checkpoint."""

    model: Annotated[str, Argument(metavar="MODEL")]
    data: Annotated[Path | str, Option("store made by `data import` or `data simulate`", "DIR")]
    _: KW_ONLY
    resume: bool = False
    stop: Callable[[], bool] = never
    """Asked after each step: True ends the training after a checkpoint of that step."""


@dataclass(frozen=True)
class CrossvalRequest(TrainingOptions):
    """A model to cross-validate on a store."""

    model: Annotated[str, Argument(metavar="MODEL")]
    data: Annotated[Path | str, Option("store made by `data import` or `data simulate`", "DIR")]
    _: KW_ONLY
    folds: Annotated[int, Option(least=2)] = 10
    only_folds: Annotated[int | None, Option("run only the first N of them", "N", least=1)] = None
    repeats: Annotated[int, Option("for a predictor of ratings: how often folds are redrawn", least=1)] = 3
    on: Annotated[str, ON] = ""
    processes: Annotated[int | None, PROCESSES] = None


@dataclass(frozen=True)
class ExportRequest(Request):
    """A finished run to write in another form, which does not need this package."""

    run: Annotated[Path | str, Argument(metavar="RUN")]
    _: KW_ONLY
    out: Annotated[Path | str, Option("zip file, header file, or new folder", "PATH")]
    to: Annotated[
        Literal["zip", "onnx", "c", "hub"],
        Option(
            "zip: one file to import again; onnx: the network for onnxruntime; c: a texture for a microcontroller; "
            "hub: a folder in the layout of the Hugging Face Hub"
        ),
    ] = "zip"
    material: Annotated[str | None, Option("c: the material", "NAME")] = None
    speed: Annotated[float | None, Option("c: mm/s (default: the median recorded)", "MM_S", least=0)] = None
    force: Annotated[float | None, Option("c: N (default: the median recorded)", "N", least=0)] = None
    push: Annotated[str | None, Option("hub: also upload it, e.g. as lab/cork", "REPO")] = None
    axis: Annotated[str, Option("c: an axis by name, dft321 (all in one) or all")] = "dft321"
    progress: ProgressCallback = silent
