"""Judge a generator: train what it is judged with, let it generate, and hold both against recordings."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field
from threadpoolctl import threadpool_limits

from tactogram import models
from tactogram.datasets import Examples
from tactogram.errors import ParameterError, RunError
from tactogram.evaluation.generation import judge
from tactogram.evaluation.generation_report import generation_sections
from tactogram.evaluation.pieces import LONGEST_S, MOST_PIECES, Pieces, plan_pieces
from tactogram.evaluation.report import Section
from tactogram.evaluation.standing import MODEL, GenerationResult
from tactogram.jobs.progress import Progress, silent
from tactogram.jobs.training import LoadedRun, run_training
from tactogram.model import Condition, Example, Generator, Learner, SignalKind
from tactogram.recipe import Recipe
from tactogram.signal import Signal
from tactogram.signal.filters import resample
from tactogram.training.checkpoint import load_state, save_state
from tactogram.training.seeds import child_seed

BASELINES = ("ar_texture", "replay")
JUDGES = "judges"
"""Folder in the run where what it is judged with is kept. Never `replay`, which holds recordings."""
FELT_RATE = 2500.0
"""Faster signals are judged at this rate, Hz: nothing is felt above 1000 Hz, and sound would cost 20 times as much."""
LARGEST_WINDOW = 384
SMALLEST_WINDOW = 8
"""Samples; the largest as in the quick recipe of stroke_cnn, the smallest what its poolings leave something of."""


class Judging(BaseModel):
    """How much is spent on judging."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    steps: int = Field(default=700, gt=0)
    """Of training the classifier whose embedding is used."""
    window_s: float = Field(default=0.2, gt=0)
    """Its window, s, up to `LARGEST_WINDOW` samples."""
    longest_s: float = Field(default=LONGEST_S, gt=0)
    """Longest pieces that are compared, s: see `plan_pieces`."""
    most: int = Field(default=MOST_PIECES, gt=0)
    """Pieces per material."""
    seed: int = Field(default=0, ge=0)
    """Decides what is generated, and the classifier."""

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


def judge_generator(
    loaded: LoadedRun,
    known: Sequence[Example],
    train: Examples,
    *,
    judging: Judging | None = None,
    progress: Progress = silent,
) -> tuple[GenerationResult, list[Section]]:
    """Return what the protocol of `tactogram.evaluation.generation` finds of ``loaded``, and its report.

    Parameters
    ----------
    loaded : LoadedRun
        A generator of signals.
    known : sequence of Example
        Recordings that it was not trained on, of materials that it knows.
    train : Examples
        What it was trained on.
    judging : Judging, optional
    progress : Progress

    Raises
    ------
    ParameterError
        If the generator cannot be asked for these materials.
    """
    judging = judging or Judging()
    if loaded.facts.gives != "signal" or not isinstance(loaded.model, Generator):
        raise ParameterError(f"{loaded.facts.name} gives no signals: there is nothing to judge them by")
    test, trained = _by_material(known), _by_material(train)
    if missing := sorted(set(test) - set(trained)):
        raise ParameterError(
            f"{loaded.run.name}: no training recording of {', '.join(missing)} to compare with"
        )
    pieces = plan_pieces(trained, test, longest_s=judging.longest_s, most=judging.most)
    notes: list[str] = []
    if loaded.kind.rate > FELT_RATE:
        notes.append(f"Everything was judged at {FELT_RATE:g} Hz, which holds what is felt.")
    bench = _Bench(loaded, train, judging, progress)
    classifier = _classifier(bench, pieces, notes)
    generators: dict[str, Any] = {MODEL: loaded.model}
    for name in BASELINES:
        generators[name] = loaded.model if loaded.facts.name == name else bench.baseline(name)
    sets: dict[str, Mapping[str, list[Signal]]] = {}
    for name, generator in generators.items():
        same = [other for other in sets if generators[other] is generator]
        sets[name] = (
            sets[same[0]]
            if same
            else _generated(name, generator, known, trained, pieces, judging.seed, notes, progress)
        )
    with threadpool_limits(1):
        result = judge(
            sets,
            train=trained,
            test=test,
            pieces=pieces,
            embed=classifier.window_embeddings if classifier else None,
            classifier=classifier,
            on_part=progress,
        )
    result = replace(result, notes=(*notes, *result.notes))
    return result, generation_sections(result, test, sets)


def _by_material(examples: Sequence[Example]) -> dict[str, list[Signal]]:
    found: dict[str, list[Signal]] = {}
    for example in examples:
        if example.material is not None:
            found.setdefault(example.material, []).append(_felt(example.signal))
    return found


def _felt(signal: Signal) -> Signal:
    return resample(signal, FELT_RATE) if signal.rate > FELT_RATE else signal


def _generated(
    name: str,
    generator: Any,
    known: Sequence[Example],
    trained: Mapping[str, Sequence[Signal]],
    pieces: Pieces,
    seed: int,
    notes: list[str],
    progress: Progress,
) -> dict[str, list[Signal]]:
    """Return signals of each material under the conditions of the recordings it is judged by."""
    asked: dict[str, list[Example]] = {}
    for example in known:
        asked.setdefault(str(example.material), []).append(example)
    made: dict[str, list[Signal]] = {}
    for done, (material, examples) in enumerate(sorted(asked.items()), 1):
        number, seconds = pieces.draws(trained[material])
        seconds += 2 / FELT_RATE  # what resampling may round away
        made[material] = []
        for k in range(number):
            condition = {"material": material, **_condition(examples[k % len(examples)])}
            drawn = child_seed(seed, "judge", material, k)
            made[material].append(_drawn(name, generator, condition, seconds, drawn, notes))
        progress(f"generate {name}", done, len(asked))
    return made


def _drawn(
    name: str, generator: Any, condition: Condition, seconds: float, seed: int, notes: list[str]
) -> Signal:
    """Return a signal, of the material alone where the model was not trained with speed and force."""
    try:
        signal = generator.generate(condition, seconds=seconds, seed=seed)
    except ParameterError:
        plain = {"material": condition["material"]}
        if condition == plain:
            raise
        signal = generator.generate(plain, seconds=seconds, seed=seed)
        note = (
            f"{name} was asked for materials alone: it does not know every speed and force of the recordings."
        )
        if note not in notes:
            notes.append(note)
    if not isinstance(signal, Signal):
        raise ParameterError(f"{name} generates images, not signals")
    return _felt(signal)


def _condition(example: Example) -> dict[str, Any]:
    given = {name: example.condition.get(name) for name in ("speed_mm_s", "force_n")}
    return {name: value for name, value in given.items() if value is not None}


# -- what it is judged with -----------------------------------------------------------------------------------


class _Bench:
    """Trains models on what the run was trained on; keeps them in the run, named by all that decides them."""

    def __init__(self, loaded: LoadedRun, train: Examples, judging: Judging, progress: Progress) -> None:
        self.loaded, self.train, self.judging, self.progress = loaded, train, judging, progress

    def baseline(self, name: str) -> Learner:
        """Return a trained baseline, as its quick recipe configures it."""
        config = Recipe.load(models.find(name).recipe("quick")).config
        return self.trained(name, config, self.train, self.loaded.kind, keep=name != "replay")

    def trained(
        self,
        name: str,
        config: Mapping[str, Any],
        examples: Sequence[Example],
        kind: SignalKind,
        *,
        keep: bool,
    ) -> Learner:
        """Return a model trained on ``examples``, from its file where there is one."""
        facts = models.find(name)
        chosen = facts.config(config)
        recipe = Recipe(model=name, seed=self.judging.seed)
        learner = facts.build(chosen, kind, seed=recipe.seed)
        file = self._file(name, chosen.model_dump(mode="json"), kind)
        if keep and file.exists():
            try:
                learner.load_state(load_state(file)[0])
            except (RunError, KeyError, TypeError, ValueError, RuntimeError):
                learner = facts.build(chosen, kind, seed=recipe.seed)  # a broken file is made again
            else:
                return learner
        # Small steps: threads would wait for each other, above all on a machine that does something else too.
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
            "seed": self.judging.seed,
            "data": self.train.store.sha256,
            "segments": [[s.id, s.start_s, s.stop_s] for s in self.train.segments],
            "prepare": self.train.prepare.model_dump(mode="json"),
            "label": str(self.train.label),
            "kind": [kind.rate, kind.unit, kind.axes, kind.materials],
        }
        digest = hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:16]
        return self.loaded.run.folder / JUDGES / f"{name}-{digest}.safetensors"


def _classifier(bench: _Bench, pieces: Pieces, notes: list[str]) -> Any | None:
    """Return a stroke_cnn of the training part, or None, and a note, where there can be none."""
    kind, judging = bench.loaded.kind, bench.judging
    kind = replace(kind, rate=min(kind.rate, FELT_RATE))
    shortest = int(pieces.seconds * kind.rate)
    if len(kind.materials) < 2:
        notes.append("No classifier, and no measures in its embedding: there is one material.")
        return None
    if shortest < SMALLEST_WINDOW:
        notes.append(f"No classifier: pieces of {pieces.seconds:.3g} s have too few samples.")
        return None
    config = judging.classifier_config(kind.rate, shortest)
    examples = [replace(e, signal=_felt(e.signal)) for e in bench.train]
    examples = [e for e in examples if len(e.signal) >= config["window"]]
    try:
        return bench.trained("stroke_cnn", config, examples, kind, keep=True)
    except ParameterError as error:
        notes.append(f"No classifier, and no measures in its embedding: {error}")
        return None
