"""Models: one folder each. A folder with a ``model.toml`` is a model; there is no other list."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from importlib.machinery import PathFinder
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field, field_validator

from tactogram.errors import ParameterError, Remedy, RunError, shown
from tactogram.model import Kind, Model, ModelConfig, condition_types
from tactogram.plugins import entry_point_modules, further_folders, import_path
from tactogram.text_files import read_toml
from tactogram.validation import FrozenModel, validated

if TYPE_CHECKING:
    import torch

ENTRY_POINTS = "tactogram.models"
"""Entry points of installed packages with models: ``my_model = "my_package.my_model"``."""

FOLDERS_VARIABLE = "TACTOGRAM_MODELS"
"""Environment variable with further folders of models, separated as in PATH."""

SHIPPED = "trained"
"""Folder in that of a model, with a run of it for immediate use."""

MOST_COUNT = 10_000_000
"""Largest integer of a configuration: weeks of steps, and far more than any network's width."""

LearnsFrom = Literal["recordings", "ratings", "images", "both"]
"""Recordings of materials; rated signals or images; rated images; or both rated surfaces and rated signals."""


class ModelConditions(FrozenModel):
    """Conditions that a model is given, of `tactogram.model.condition_types`. Unknown keys are errors."""

    needs: tuple[str, ...] = ()
    """Required conditions; of words, all."""
    instead: tuple[str, ...] = ()
    """Conditions that may each be given in place of those needed; of words, any."""
    takes: tuple[str, ...] = ()
    """Optional conditions; of words, any."""

    @property
    def conditions(self) -> tuple[str, ...]:
        """All conditions that it can be given."""
        return (*self.needs, *self.instead, *self.takes)

    @field_validator("needs", "instead", "takes")
    @classmethod
    def _are_conditions(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for name in names:
            if name not in condition_types():
                raise ValueError(f"conditions are {', '.join(condition_types())}; unknown {name!r}")
        return names


class ModelDescription(ModelConditions):
    """Content of a ``model.toml``."""

    title: str = Field(min_length=1)
    """Title of the publication."""
    authors: tuple[str, ...] = Field(min_length=1)
    """Family name and initials, in the order of the publication."""
    year: int = Field(ge=1900, le=2100)
    doi: str = ""
    """Without resolver, e.g. ``10.1109/HAPTICS.2014.6775475``; empty if there is none."""
    task: Literal["classification", "generation", "prediction"]
    gives: Literal["signal", "image", "probabilities", "scores"]
    """Kind of output."""
    learns_from: LearnsFrom = "recordings"
    """Kind of training data."""
    images: ModelConditions | None = None
    """Conditions of a model that learns from a store of rated images alone, too, and then gives images."""


class ModelInfo(ModelDescription):
    """A model and its folder. Its code, and torch with it, is imported on demand."""

    name: str
    """Name of the folder, in recipes and on the command line."""
    folder: Path
    package: str
    """Import name of the folder."""

    def of(self, *, images: bool) -> ModelInfo:
        """Return the model as it is when trained on rated images, if it can be and ``images``; else itself."""
        if self.images is None or not images:
            return self
        return self.model_copy(
            update={**dict(self.images), "gives": "image", "learns_from": "images", "images": None}
        )

    @property
    def faces(self) -> tuple[ModelInfo, ...]:
        """The model as it is when trained on each kind of data that it learns from."""
        return (self,) if self.images is None else (self, self.of(images=True))

    def given(self, condition: str) -> ModelInfo:
        """Return the model with ``condition`` as the one that it needs.

        Raises `ParameterError` if the model needs another, and takes none instead.
        """
        if condition in self.instead:
            return self.model_copy(update={"needs": (condition,), "instead": ()})
        if condition not in self.needs:
            raise ParameterError(
                f"{self.name} is given {', '.join((*self.needs, *self.instead)) or 'nothing'}, got {condition!r}"
            )
        return self

    def recipes(self) -> tuple[str, ...]:
        """Return the names of the recipes in the folder, sorted."""
        return tuple(sorted(file.stem for file in (self.folder / "recipes").glob("*.toml")))

    def recipe(self, name: str) -> Path:
        """Return the file of the recipe ``name``, or ``name`` itself if it is the path of a TOML file."""
        if name in self.recipes():
            return self.folder / "recipes" / f"{name}.toml"
        if name.endswith(".toml") and Path(name).is_file():
            return Path(name)
        raise ParameterError.one_of(
            f"recipe of {self.name}", self.recipes(), name, remedy="or give a TOML file"
        )

    def config_class(self) -> type[ModelConfig]:
        """Import the folder and return its ``Config``."""
        config: type = self._module().Config
        if not issubclass(config, ModelConfig):
            raise ParameterError(f"{self.folder}: Config must be a subclass of tactogram.model.ModelConfig")
        return config

    def config(self, values: Mapping[str, Any] | None = None, *, run: Path | None = None) -> ModelConfig:
        """Return the model's configuration, in which ``values``, maybe a ``run``'s, replace the published ones."""
        try:
            config = validated(self.config_class(), values or {}, where=f"config of {self.name}")
        except ParameterError as error:
            if run is None:
                raise
            problem = str(error).partition("; known here")[0]
            raise RunError(
                run, problem, remedy="train it again, or use the tactogram that trained it"
            ) from None
        for key, value in config.model_dump().items():
            for number in value if isinstance(value, list | tuple) else [value]:
                if isinstance(number, int) and number > MOST_COUNT:
                    raise ParameterError(
                        f"config of {self.name}: {key}: must be at most {MOST_COUNT}, got {shown(number)}"
                    )
        return config

    def build(
        self, config: ModelConfig, kind: Kind, *, seed: int, device: str | torch.device = "cpu"
    ) -> Model:
        """Import the folder and return an untrained model for signals or images of ``kind``.

        ``config`` is of this model's `config_class`; ``seed`` decides the initial weights.
        """
        from tactogram.training.device import memory_checked

        with memory_checked(f"model {self.name}"):
            model: object = self._module().build(config, kind, seed=seed, device=device)
        if not isinstance(model, Model):
            raise ParameterError(
                f"{self.folder}: build must return a tactogram.model.Model, got {type(model).__name__}"
            )
        return model

    def _module(self) -> ModuleType:
        if "." not in self.package:
            if not (self.folder / "__init__.py").is_file():
                raise ParameterError(
                    f"{self.folder}: expected an __init__.py with Config and build, found none"
                )
            return import_path(self.folder)
        module = import_module(self.package)  # waits while another thread imports it
        if Path(str(module.__file__)).parent.resolve() != self.folder.resolve():
            raise ParameterError(f"{self.folder}: rename it, {self.package!r} is the name of another module")
        return module


def available(folders: Iterable[Path | str] = ()) -> dict[str, ModelInfo]:
    """Return every model by name: those of this package, installed ones, and those in further folders.

    Only ``model.toml`` files are read; no model is imported.

    ``folders``: folders of models, or of folders of models; those in ``TACTOGRAM_MODELS`` are added.

    Raises `ParameterError` if a ``model.toml`` is invalid, a folder contains no model, or two models have one name.
    """
    models: dict[str, ModelInfo] = {}
    for folder, package in _places(folders):
        if folder.name in models:
            if models[folder.name].folder.resolve() == folder.resolve():
                continue
            raise ParameterError(
                f"two models are called {folder.name!r}: {models[folder.name].folder}, {folder}"
            )
        models[folder.name] = _read(folder, package)
    return dict(sorted(models.items()))


def find(name: str, folders: Iterable[Path | str] = ()) -> ModelInfo:
    """Return the model called ``name``, of those `available` in ``folders``."""
    models = available(folders)
    if name not in models:
        remedy = Remedy("name the folder of another with", "model_folders")
        raise ParameterError.one_of("model", models, name, remedy=remedy)
    return models[name]


def shipped_run(name: str) -> Path | None:
    """Return the run that the model ``name`` comes with, trained by its authors; None if a folder has that name."""
    if not name.isidentifier() or Path(name).exists():
        return None
    model = available().get(name)
    run = model and model.folder / SHIPPED
    return run if run and run.is_dir() else None


def _places(folders: Iterable[Path | str]) -> Iterator[tuple[Path, str]]:
    for file in sorted(Path(__file__).parent.glob("*/model.toml")):
        yield file.parent, f"{__name__}.{file.parent.name}"
    for package in entry_point_modules(ENTRY_POINTS):
        yield _folder_of(package), package
    for folder in further_folders(FOLDERS_VARIABLE, folders):
        file = folder / "model.toml"
        files = [file] if file.is_file() else sorted(folder.glob("*/model.toml"))
        if not files:
            raise ParameterError(f"{folder}: expected a folder of models, found no model.toml in it")
        for file in files:
            yield file.parent.resolve(), file.parent.resolve().name


def _folder_of(package: str) -> Path:
    """Return the folder of an installed package, without importing it or its parents."""
    places: list[str] | None = None
    for depth in range(package.count(".") + 1):
        spec = PathFinder.find_spec(".".join(package.split(".")[: depth + 1]), places)
        places = list(spec.submodule_search_locations or ()) if spec else None
        if not places:
            raise ParameterError(f"entry point {package!r} of {ENTRY_POINTS}: no such package")
    return Path(places[0]) if places else Path()


def _read(folder: Path, package: str) -> ModelInfo:
    file = folder / "model.toml"
    if not folder.name.isidentifier():
        raise ParameterError(f"{folder}: a model's folder must be named like a module, got {folder.name!r}")
    facts = validated(ModelDescription, read_toml(file), where=str(file))
    return ModelInfo(**facts.model_dump(), name=folder.name, folder=folder, package=package)
