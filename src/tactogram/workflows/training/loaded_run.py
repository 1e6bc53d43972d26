"""Finished runs, loaded for use, and their data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactogram import models
from tactogram.datasets import Split, Store, open_store
from tactogram.errors import ParameterError, Remedy, RunError
from tactogram.model import Condition, ImageKind, Kind, Model, ModelConfig, SignalKind
from tactogram.recipe import Preparation, Recipe
from tactogram.signal import Image, Signal
from tactogram.signal.resampling import resample
from tactogram.training.run import Run, open_run
from tactogram.training.seeds import surface_seed


@dataclass(frozen=True)
class LoadedRun:
    """A finished run, ready for use; what ``model`` does is ``facts.task``."""

    run: Run
    facts: models.ModelInfo
    recipe: Recipe
    any_kind: Kind
    model: Model

    @property
    def kind(self) -> SignalKind:
        """The kind of the run's signals; a `ParameterError` for a run of images."""
        if not isinstance(self.any_kind, SignalKind):
            raise ParameterError(f"{self.run.name}: {self.facts.name} is of images, not of signals")
        return self.any_kind

    @property
    def generator(self) -> Model:
        """The model; a `ParameterError` for one that does not generate."""
        return self._for("generation", "generate")

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal | Image:
        """Return a signal or image for ``condition``, as the model's own ``generate`` with `seed_of`."""
        return self.generator.generate(condition, seconds=seconds, seed=self.seed_of(condition, seed))

    def seed_of(self, condition: Condition, seed: int) -> int:
        """Return `surface_seed`; ``seed`` for images, which share their noise to show what words change."""
        return seed if self.facts.gives == "image" else surface_seed(seed, condition)

    @property
    def classifier(self) -> Model:
        """The model; a `ParameterError` for one that does not classify."""
        return self._for("classification", "classify")

    @property
    def predictor(self) -> Model:
        """The model; a `ParameterError` for one that predicts no scores."""
        return self._for("prediction", "predict scores")

    @property
    def embedder(self) -> Model:
        """The model; a `ParameterError` for one that does not turn signals into vectors."""
        if not self.model.embeds:
            raise ParameterError(f"{self.run.name}: {self.facts.name} has no embedding for a search")
        return self.model

    def _for(self, task: str, job: str) -> Model:
        if self.facts.task != task:
            raise ParameterError(
                f"{self.run.name}: {self.facts.name} does not {job}, it is a model for {self.facts.task}; "
                "`tactogram models` lists those that do"
            )
        return self.model

    @property
    def config(self) -> ModelConfig:
        """The model's own configuration."""
        return self.facts.config(self.recipe.config)

    @property
    def simulated(self) -> bool:
        """Whether any of the training data was simulated."""
        return self.any_kind.simulated

    def facts_on(self, store: Store, split: str, *, simulated: bool | None = None) -> dict[str, Any]:
        """Return the facts of an evaluation on recordings of ``store`` described by ``split``."""
        data = {
            "name": store.name,
            "sha256": store.sha256,
            "split": split,
            "simulated": store.simulated if simulated is None else simulated,
        }
        return {"model": self.facts.name, "run": self.run.data["run_id"], "data": data}

    def prepare(self, signal: Signal) -> Signal:
        """Return ``signal`` as the model was trained on it: axes, band and rate of the recipe."""
        prepared = self.as_trained.apply(signal)
        self.kind.check(prepared)
        return prepared

    def prepare_vibration(self, signal: Signal) -> Signal:
        """Return a recording that describes a surface as the model was trained on it; its unit may be another.

        Where the model has the three axes combined, one axis will do; a slow recording just lacks high frequencies.
        """
        preparation = self.as_trained
        if preparation.band is not None and signal.rate <= 2 * preparation.band[1]:
            signal = resample(signal, self.kind.rate)
        if preparation.axes == "dft321" and len(signal.axes) == 1:
            signal = signal.with_samples(signal.samples, axes=self.kind.axes)
            preparation = preparation.model_copy(update={"axes": "all"})
        return preparation.apply(signal)

    def missing_band(self, signal: Signal) -> list[str]:
        """Return a sentence on a recording, not prepared yet, that ends below the band of the run, or none."""
        band = self.as_trained.band
        ends, top = signal.rate / 2, self.kind.rate / 2 if band is None else band[1]
        if signal.domain != "time" or ends >= top:
            return []
        known = f"above, up to {top:.4g} Hz in the run's band, nothing is known of the surface"
        return [f"the recording ends at {ends:.4g} Hz: {known}"]

    @property
    def as_trained(self) -> Preparation:
        """The recipe's preparation, to the rate of the training signals."""
        return self.recipe.prepare.model_copy(update={"rate": float(self.kind.rate)})


def load_run(folder: Path | str, *, device: str = "cpu", model_folders: Sequence[Path] = ()) -> LoadedRun:
    """Return a finished run, ready for use.

    Parameters
    ----------
    folder : Path or str
        Of the run. The name of a model that comes trained (`tactogram.models.shipped_run`) is its run, unless there is
        such a folder.
    device : str
        Where its networks compute.
    model_folders : sequence of Path
        Further to those recorded in the run.

    Returns
    -------
    LoadedRun
        Its model, recipe and facts.

    Raises
    ------
    RunError
        If there is none, it is not finished, or its files are broken.

    Examples
    --------
    >>> import tactogram
    >>> tactogram.load_run("texture_flow").facts.task
    'generation'
    """
    from tactogram.training.checkpoint import load_state

    run = open_run(models.shipped_run(str(folder)) or folder)
    kind, recipe = run.kind(), run.recipe
    facts = model_of(run, model_folders).of(images=isinstance(kind, ImageKind))
    model = facts.build(facts.config(recipe.config, run=run.folder), kind, seed=recipe.seed, device=device)
    state, _ = load_state(run.folder / "model.safetensors")
    try:
        model.load_state(state)
    except (KeyError, TypeError, ValueError, RuntimeError) as error:
        line = str(error).split("\n")[0]
        raise RunError(f"{run.folder}: the weights do not fit the recipe: {line}") from error
    return LoadedRun(run, facts, recipe, kind, model)


def model_of(run: Run, model_folders: Sequence[Path] = ()) -> models.ModelInfo:
    """Return the model of a run, from ``model_folders`` or the folders recorded in the run.

    Raises
    ------
    ParameterError
        If there is none of its name.
    """
    name, recorded = run.recipe.model, map(Path, run.data.get("model_folders", ()))
    if name not in models.available(model_folders):
        model_folders = (
            *model_folders,
            *(path for path in recorded if path.is_absolute() and path.is_dir()),
        )
    return models.find(name, model_folders)


def test_part(run: Run) -> tuple[Store, Split]:
    """Return the store that ``run`` was trained on and the split it used.

    Raises
    ------
    RunError
        If the store is gone, or recordings of the split are. Recordings added since do no harm: a recording's id
        follows from its samples.
    """
    facts = run.data
    try:
        store = open_store(facts["path"])
    except Exception as error:
        raise RunError(
            run.folder, f"its data is not at {facts['path']} any more", remedy=Remedy("give", "data")
        ) from error
    split = Split.load(run.folder / "split.json")
    if missing := [s.id for part in split.parts.values() for s in part if s.id not in store]:
        raise RunError(
            facts["path"],
            f"{len(missing)} recordings of the run are gone from it (first: {missing[0]})",
            remedy=Remedy("give other recordings as", "data"),
        )
    return store, split
