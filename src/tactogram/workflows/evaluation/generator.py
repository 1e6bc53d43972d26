"""Evaluation of a generator: reference models, generated signals, and both against recordings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from tactogram import models
from tactogram.datasets import Examples
from tactogram.errors import ParameterError
from tactogram.evaluation.generation.comparison import MODEL, GenerationResult, PiecePlan, plan_pieces
from tactogram.evaluation.generation.protocol import evaluate_generation
from tactogram.evaluation.generation.report import generation_sections
from tactogram.evaluation.report import ReportSection
from tactogram.model import Example, Model, SignalKind
from tactogram.signal import Signal
from tactogram.signal.resampling import resample
from tactogram.training.seeds import child_seed
from tactogram.workflows.evaluation.reference_models import (
    BASELINES,
    EVALUATION_SPEED_MM_S,
    FELT_RATE,
    HOLDING_RECORDINGS,
    JUDGES,
    NEAREST_PHOTO,
    EvaluationSettings,
    ReferenceModels,
    classifier_of,
    felt,
    kind_in_time,
    tactile_kind,
)
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.loaded_run import LoadedRun


def evaluate_generator(
    loaded: LoadedRun,
    known: Sequence[Example],
    train: Examples,
    *,
    settings: EvaluationSettings | None = None,
    progress: ProgressCallback = silent,
) -> tuple[GenerationResult, Callable[[], list[ReportSection]]]:
    """Return the result of `tactogram.evaluation.generation.protocol` for a generator of signals, and its report.

    The report's sections are drawn when the second value is called.

    ``known`` are recordings that it was not trained on, of materials that it knows; for a generator conditioned on a
    photograph or a recording also of others: half of these then replace the training part.

    Raises `ParameterError` if the generator does not know these materials.
    """
    settings = settings or EvaluationSettings()
    if (loaded.facts.task, loaded.facts.gives) != ("generation", "signal"):
        raise ParameterError(f"{loaded.facts.name} generates no signals to evaluate")
    notes: list[str] = []
    known, held_back = _apart(loaded, known, notes)
    test, trained, floor = _by_material(known), _by_material(train), _by_material(held_back)
    compared = trained | floor
    if missing := sorted(set(test) - set(compared)):
        raise ParameterError(
            f"{loaded.run.name}: no training recording of {', '.join(missing)} to compare with"
        )
    pieces = plan_pieces(compared, test, longest_s=settings.longest_s, most=settings.most)
    if loaded.kind.domain != "time":
        notes.append(f"Signals over displacement were evaluated as met at {EVALUATION_SPEED_MM_S:g} mm/s.")
    rate = tactile_kind(loaded.kind).rate
    if rate < kind_in_time(loaded.kind).rate:
        notes.append(
            f"Everything was evaluated at {FELT_RATE:g} Hz, which holds all perceptible frequencies."
        )
    strokes: dict[str, Example] = {}
    if "vibration" in loaded.facts.needs:
        strokes = {str(e.material): e for e in reversed([*train, *held_back]) if e.material in test}
        notes.append("Baselines were fitted to the one recording of each material that the model was given.")
    judged = _ConditionedGenerator(
        MODEL, loaded.facts, loaded.model, loaded.kind, None, strokes, rate, settings.seed, notes
    )
    for example in known:
        judged.condition(example, 0)  # refuses what it cannot be given before anything is trained
    references = ReferenceModels(loaded.run.folder / JUDGES, loaded.kind, train, settings, progress)
    classifier = classifier_of(references, pieces, notes)
    sets: dict[str, Mapping[str, list[Signal]]] = {}
    generators = _generators(loaded, references, tuple(strokes.values()))
    nearest = generators[NEAREST_PHOTO][1] if NEAREST_PHOTO in generators else None
    for name, (facts, generator) in generators.items():
        same = [other for other in sets if generators[other][1] is generator]
        kind = loaded.kind if generator is loaded.model else kind_in_time(loaded.kind)
        conditioned = _ConditionedGenerator(
            name, facts, generator, kind, nearest, strokes, rate, settings.seed, notes
        )
        sets[name] = sets[same[0]] if same else _generated(conditioned, known, compared, pieces, progress)
    with threadpool_limits(1):
        result = evaluate_generation(
            sets,
            train=trained,
            test=test,
            floor=floor,
            pieces=pieces,
            embed=classifier.window_embeddings if classifier else None,
            classifier=classifier,
            on_part=progress,
        )
    result = replace(result, notes=(*notes, *result.notes))
    return result, partial(generation_sections, result, test, sets)


def _apart(
    loaded: LoadedRun, known: Sequence[Example], notes: list[str]
) -> tuple[list[Example], list[Example]]:
    """Return the recordings for testing, and every second recording of the materials that were not trained on."""
    strange: dict[str, list[Example]] = {}
    for example in known:
        if example.material not in loaded.kind.materials:
            strange.setdefault(str(example.material), []).append(example)
    if lone := sorted(name for name, examples in strange.items() if len(examples) < 2):
        notes.append(f"Left out, one recording of a material that was not trained on: {', '.join(lone)}.")
    strange = {name: examples for name, examples in strange.items() if len(examples) > 1}
    if strange:
        notes.append(
            f"Not trained on: {', '.join(sorted(strange))}. The floor is half of their recordings against the other."
        )
    kept = [e for e in known if e.material in loaded.kind.materials]
    return (
        kept + [e for examples in strange.values() for e in examples[::2]],
        [e for examples in strange.values() for e in examples[1::2]],
    )


def _generators(
    loaded: LoadedRun, references: ReferenceModels, strokes: Sequence[Example]
) -> dict[str, tuple[models.ModelInfo, Any]]:
    names = (*BASELINES, NEAREST_PHOTO) if "image" in loaded.facts.needs else BASELINES
    generators = {MODEL: (loaded.facts, loaded.model)}
    for name in names:
        own = loaded.facts.name == name and loaded.kind.domain == "time"  # baselines are trained over time
        generators[name] = (
            (loaded.facts, loaded.model) if own else (models.find(name), references.baseline(name, strokes))
        )
    return generators


def _by_material(examples: Sequence[Example]) -> dict[str, list[Signal]]:
    signals: dict[str, list[Signal]] = {}
    for example in examples:
        if example.material is not None:
            signals.setdefault(example.material, []).append(felt(example.signal))
    return signals


@dataclass(frozen=True)
class _ConditionedGenerator:
    """A generator conditioned as recordings were made."""

    name: str
    facts: models.ModelInfo
    generator: Any
    kind: SignalKind
    nearest: Model | None
    strokes: Mapping[str, Example]
    """One recording of each material, for a generator that needs it."""
    rate: float
    seed: int
    notes: list[str]

    def drawn(self, example: Example, number: int, seconds: float) -> Signal:
        """Return signal ``number`` for the conditions of ``example``; of its surface alone where they are unknown."""
        condition = self.condition(example, number)
        if self._over_displacement and not self._speed:
            seconds *= EVALUATION_SPEED_MM_S  # it gives recorded stretches, whose length is in mm
        seed = child_seed(self.seed, "judge", str(example.material), number)
        try:
            signal = self._made(condition, seconds, seed)
        except ParameterError:
            plain = {name: condition[name] for name in (*self.facts.needs, *self._speed)}
            if condition == plain:
                raise
            signal = self.generator.generate(plain, seconds=seconds, seed=seed)
            condition_name = {"image": "photographs", "vibration": "recordings", "words": "words"}.get(
                self.facts.needs[0], "materials"
            )
            self._note(
                f"{self.name} was conditioned on {condition_name} alone: it does not know every speed and force of the "
                "recordings."
            )
        if not isinstance(signal, Signal):
            raise ParameterError(f"{self.name} generates images, not signals")
        band_limited = felt(signal)
        return band_limited if band_limited.rate == self.rate else resample(band_limited, self.rate)

    def _made(self, condition: Mapping[str, Any], seconds: float, seed: int) -> Any:
        """Return what is generated, without the contactor if the generator learned no difference of them."""
        bare = {name: value for name, value in condition.items() if not name.endswith("contactor")}
        try:
            return self.generator.generate(condition, seconds=seconds, seed=seed)
        except ParameterError:
            if bare == condition:
                raise
            return self.generator.generate(bare, seconds=seconds, seed=seed)

    def condition(self, example: Example, number: int) -> dict[str, Any]:
        """Return what signal ``number`` of a recording's surface is generated from; refuses a recording without it."""
        stroked = ["speed_mm_s", "force_n", *(["contactor"] if "contactor" in self.facts.takes else [])]
        condition = {name: value for name in stroked if (value := example.condition.get(name)) is not None}
        pictures = example.photographs
        if "image" in self.facts.needs:
            if not len(pictures):
                raise ParameterError(
                    f"{self.name} needs a photograph, and there is none of {example.material}"
                )
            condition = {name: value for name, value in condition.items() if name in self.facts.takes}
            condition["image"] = pictures[number % len(pictures)]
        if "vibration" in self.facts.needs:
            stroke = self.strokes[str(example.material)]
            condition["vibration"] = stroke.signal
            condition |= {
                f"vibration_{name}": value
                for name, value in stroke.condition.items()
                if f"vibration_{name}" in self.facts.takes and value is not None
            }
        if "words" in self.facts.needs:
            condition["words"] = self._words(example)
        if "material" in self.facts.needs:
            condition["material"] = example.material
            if example.material not in self.kind.materials and self.nearest is not None and len(pictures):
                condition["material"] = self.nearest.classify_photograph(pictures[number % len(pictures)])[0]
                self._note(
                    f"{self.name} does not know every material: the one with the nearest photograph was used."
                )
        return condition | self._speed

    def _words(self, example: Example) -> dict[str, float]:
        """Return the mean ratings of the surface, on the run's scale."""
        if example.rated is None or self.kind.scale is None:
            raise ParameterError(f"{self.name} needs ratings, and there are none of {example.material}")
        low, high = self.kind.scale
        means = zip(example.rated.words, example.rated.means, strict=True)
        return {word: low + float(mean) * (high - low) for word, mean in means if np.isfinite(mean)}

    @property
    def _over_displacement(self) -> bool:
        return self.kind.domain != "time"

    @property
    def _speed(self) -> dict[str, float]:
        """Speed condition of a generator over displacement, which is evaluated over time."""
        plays = self._over_displacement and self.facts.name not in HOLDING_RECORDINGS
        return {"speed_mm_s": EVALUATION_SPEED_MM_S} if plays else {}

    def _note(self, text: str) -> None:
        if text not in self.notes:
            self.notes.append(text)


def _generated(
    generator: _ConditionedGenerator,
    known: Sequence[Example],
    compared: Mapping[str, Sequence[Signal]],
    pieces: PiecePlan,
    progress: ProgressCallback,
) -> dict[str, list[Signal]]:
    """Return signals of each material under the conditions of its recordings."""
    by_material: dict[str, list[Example]] = {}
    for example in known:
        by_material.setdefault(str(example.material), []).append(example)
    signals: dict[str, list[Signal]] = {}
    for done, (material, examples) in enumerate(sorted(by_material.items()), 1):
        number, seconds = pieces.draws(compared[material])
        seconds += 2 / FELT_RATE  # resampling may round it away
        signals[material] = [generator.drawn(examples[k % len(examples)], k, seconds) for k in range(number)]
        progress(f"generate {generator.name}", done, len(by_material))
    return signals
