"""Reference models of an evaluation: a classifier and baselines, trained on the run's own data."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pydantic import Field
from threadpoolctl import threadpool_limits

from tactogram import models
from tactogram.datasets import Examples
from tactogram.errors import ParameterError, RunError
from tactogram.evaluation.generation.comparison import LONGEST_S, MOST_PIECES, PiecePlan
from tactogram.model import Example, Model, SignalKind
from tactogram.recipe import Recipe
from tactogram.signal import Signal
from tactogram.signal.displacement import played
from tactogram.signal.resampling import resample
from tactogram.training.checkpoint import load_state, save_state
from tactogram.training.loop import run_training
from tactogram.validation import FrozenModel
from tactogram.workflows.progress import ProgressCallback

BASELINES = ("ar_texture", "replay")
NEAREST_PHOTO = "nearest_photo"
"""Baseline of generators conditioned on a photograph."""
EVALUATION_SPEED_MM_S = 50.0
"""Speed at which signals over displacement are evaluated, mm/s: our choice, a slow stroke."""
JUDGES = "judges"
"""Folder of the reference models in the run."""
HOLDING_RECORDINGS = ("replay", NEAREST_PHOTO)
"""Baselines that hold recordings: never written to the run."""
FELT_RATE = 2500.0
"""Faster signals are evaluated at this rate, Hz: above 1000 Hz nothing is felt, and 44.1 kHz costs 20 times as much."""
LARGEST_WINDOW = 384
SMALLEST_WINDOW = 8
"""Samples: the largest as in the quick recipe of stroke_cnn; smaller ones vanish in its poolings."""


class EvaluationSettings(FrozenModel):
    """Effort spent on an evaluation."""

    steps: int = Field(default=700, gt=0)
    """Training steps of the classifier whose embedding is used."""
    window_s: float = Field(default=0.2, gt=0)
    """Its window, s, up to `LARGEST_WINDOW` samples."""
    longest_s: float = Field(default=LONGEST_S, gt=0)
    """Longest pieces that are compared, s: see `plan_pieces`."""
    most: int = Field(default=MOST_PIECES, gt=0)
    """Pieces per material."""
    seed: int = Field(default=0, ge=0)
    """Seed of the generated signals and the classifier."""

    def classifier_config(self, rate: float, shortest: int) -> dict[str, Any]:
        """Return the configuration of a small stroke_cnn for signals of ``rate`` with ``shortest`` samples."""
        return {
            "window": min(round(self.window_s * rate), LARGEST_WINDOW, shortest),
            "filters": [16, 16, 32, 32, 64, 64],
            "dense": [128, 64],
            "batch_size": 32,
            "steps": self.steps,
            "learning_rate": 3e-3,
            "schedule": "one-cycle",
            "hop": 1.0,
        }


def felt(signal: Signal) -> Signal:
    """Return ``signal`` over time, at most at `FELT_RATE`."""
    if signal.domain != "time":
        signal = played(signal, EVALUATION_SPEED_MM_S, signal.rate * EVALUATION_SPEED_MM_S)
    return resample(signal, FELT_RATE) if signal.rate > FELT_RATE else signal


def kind_in_time(kind: SignalKind) -> SignalKind:
    """Return ``kind`` over time, met at `EVALUATION_SPEED_MM_S` if it is over displacement."""
    return (
        kind
        if kind.domain == "time"
        else replace(kind, rate=kind.rate * EVALUATION_SPEED_MM_S, domain="time")
    )


def tactile_kind(kind: SignalKind) -> SignalKind:
    """Return the kind of the signals of `felt`."""
    kind = kind_in_time(kind)
    return replace(kind, rate=min(kind.rate, FELT_RATE))


class ReferenceModels:
    """Models trained on one training part, kept in ``folder`` under a hash of their settings.

    ``kind`` is that of the examples of ``train``.
    """

    def __init__(
        self,
        folder: Path,
        kind: SignalKind,
        train: Examples,
        settings: EvaluationSettings,
        progress: ProgressCallback,
    ) -> None:
        self.folder, self.kind, self.train = folder, kind, train
        self.settings, self.progress = settings, progress

    def baseline(self, name: str, strokes: Sequence[Example] = ()) -> Model:
        """Return a trained baseline, as its quick recipe configures it; of ``strokes`` alone, if there are any."""
        config = Recipe.load(models.find(name).recipe("quick")).config
        kind = kind_in_time(self.kind)
        examples: Sequence[Example] = strokes or self.train
        if strokes:
            kind = replace(kind, materials=tuple(sorted({str(e.material) for e in strokes})))
        if kind.domain != self.kind.domain:
            examples = [replace(e, signal=felt(e.signal)) for e in examples]
            kind = tactile_kind(kind)
        keep = name not in HOLDING_RECORDINGS and not strokes
        return self.trained(name, config, examples, kind, keep=keep)

    def trained(
        self,
        name: str,
        config: Mapping[str, Any],
        examples: Sequence[Example],
        kind: SignalKind,
        *,
        keep: bool,
    ) -> Model:
        """Return a model trained on ``examples``, from its file where there is one."""
        facts = models.find(name)
        chosen = facts.config(config)
        recipe = Recipe(model=name, seed=self.settings.seed)
        learner = facts.build(chosen, kind, seed=recipe.seed)
        file = self._file(name, chosen.model_dump(mode="json"), kind)
        if keep and file.exists():
            try:
                learner.load_state(load_state(file)[0])
            except (RunError, KeyError, TypeError, ValueError, RuntimeError):
                learner = facts.build(chosen, kind, seed=recipe.seed)  # a broken file is made again
            else:
                return learner
        # Small steps: threads would mostly wait for each other.
        with threadpool_limits(1):
            run_training(learner, examples, recipe, task=f"{name}: ", progress=self.progress)
        if keep:
            file.parent.mkdir(exist_ok=True)
            state = {key: value for key, value in learner.state().items() if key != "optimisers"}
            save_state(file, state, {"model": name, "simulated": kind.simulated})
        return learner

    def _file(self, name: str, config: Mapping[str, Any], kind: SignalKind) -> Path:
        facts = {
            "version": version("tactogram"),
            "model": name,
            "config": config,
            "seed": self.settings.seed,
            "data": self.train.store.sha256,
            "segments": [[s.id, s.start_s, s.stop_s] for s in self.train.segments],
            "prepare": self.train.prepare.model_dump(mode="json"),
            "label": str(self.train.label),
            "kind": [kind.rate, kind.unit, kind.axes, kind.materials],
        }
        digest = hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:16]
        return self.folder / f"{name}-{digest}.safetensors"


def classifier_of(references: ReferenceModels, pieces: PiecePlan, notes: list[str]) -> Any | None:
    """Return a stroke_cnn of the training part, or None with a note if it cannot be trained."""
    kind = tactile_kind(references.kind)
    shortest = int(pieces.seconds * kind.rate)
    if len(kind.materials) < 2:
        notes.append("No classifier, and no measures in its embedding: there is one material.")
        return None
    if shortest < SMALLEST_WINDOW:
        notes.append(f"No classifier: pieces of {pieces.seconds:.3g} s have too few samples.")
        return None
    config = references.settings.classifier_config(kind.rate, shortest)
    examples = [replace(e, signal=felt(e.signal)) for e in references.train]
    examples = [e for e in examples if len(e.signal) >= config["window"]]
    try:
        return references.trained("stroke_cnn", config, examples, kind, keep=True)
    except ParameterError as error:
        notes.append(f"No classifier, and no measures in its embedding: {error}")
        return None
