"""Generation: signals of a surface that is named, photographed, or known by a single stroke.

Generated signals are compared with recordings by `tactogram.evaluation.generation.protocol`, between a floor, other
recordings, and a ceiling, other materials.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from tactogram.errors import ParameterError
from tactogram.evaluation import (
    CEILING,
    FLOOR,
    MODEL,
    GenerationResult,
    PiecePlan,
    describe_measures,
    evaluate_generation,
    mean_interval,
    plan_pieces,
    signal_measures,
)
from tactogram.model import Condition, Example
from tactogram.models import ModelInfo
from tactogram.signal import Signal, resample
from tactogram.training import child_seed
from tactogram.workflows import (
    EVALUATION_SPEED_MM_S,
    EvaluationSettings,
    LoadedRun,
    ProgressCallback,
    ReferenceModels,
    classifier_of,
    felt,
    tactile_kind,
)
from tactogram_benchmark.data import OpenTask
from tactogram_benchmark.ignoring import IGNORING
from tactogram_benchmark.task import BenchmarkTask, TaskOptions, options_of
from tactogram_benchmark.task_kind import (
    AnswerForm,
    Answers,
    Content,
    Figure,
    Judgement,
    Question,
    TaskKind,
    mean_figure,
)

SHOWN = 3
"""Materials of which one answer is kept for the page."""
SEPARATES = 1.25
"""Ratio of ceiling to floor from which on a measure separates materials: below, its span is mostly chance."""
SPARE_SAMPLES = 2
"""Asked beyond what is compared: resampling may round them away."""


class GenerationOptions(TaskOptions):
    """Options of the kind."""

    given: Literal["material", "image", "text", "image+text", "vibration"] = "material"
    """What describes the surface. ``text`` is the name of one that need not be trained on, ``vibration`` the first
    recording of it in the training part."""
    floor: Literal["train", "held-back"] = "train"
    """Recordings that the floor is made of: the training part, or every second test recording, where training and test
    differ in speed, force or surface."""


@dataclass(frozen=True, eq=False)
class _Compared:
    """Test recordings that generated signals are compared with, and those of the floor, over time."""

    opened: OpenTask

    @cached_property
    def options(self) -> GenerationOptions:
        return options_of(self.opened.task, GenerationOptions)

    @cached_property
    def examples(self) -> dict[str, list[Example]]:
        """Test examples that are asked, by material."""
        step = 2 if self.options.floor == "held-back" else 1
        return {name: held[::step] for name, held in self.opened.by_material("test").items()}

    @cached_property
    def test(self) -> dict[str, list[Signal]]:
        return {name: [felt(e.signal) for e in held] for name, held in self.examples.items()}

    @cached_property
    def train(self) -> dict[str, list[Signal]]:
        held = self.opened.by_material("train")
        return {name: [felt(e.signal) for e in examples] for name, examples in held.items()}

    @cached_property
    def floor(self) -> dict[str, list[Signal]]:
        if self.options.floor == "train":
            return {}
        held = self.opened.by_material("test")
        return {name: [felt(e.signal) for e in examples[1::2]] for name, examples in held.items()}

    @cached_property
    def pieces(self) -> PiecePlan:
        return plan_pieces({**self.train, **self.floor}, self.test)

    @property
    def rate(self) -> float:
        return tactile_kind(self.opened.kind).rate


class Generation(TaskKind):
    """A signal is asked for each test recording that it is compared with, under the conditions of that recording."""

    name, rank, version = "generation", 4, 2
    main = ("distance", "lower")
    baselines = IGNORING
    given = "a material, a photograph, a name or a stroke, at a speed and force"
    asked = "a signal"

    def training_items(self, opened: OpenTask) -> list[tuple[Condition, Content]]:
        """Return the recordings of the training part, as they are compared."""
        return [(example.condition, felt(example.signal)) for example in opened.train]

    def given_in(self, task: BenchmarkTask) -> str:
        """Return what describes the surface."""
        surface = {
            "material": "a material",
            "image": "a photograph",
            "text": "a name",
            "image+text": "a photograph and a name",
            "vibration": "one stroke of the surface",
        }
        return f"{surface[options_of(task, GenerationOptions).given]}, and speed and force where known"

    def check(self, opened: OpenTask) -> None:
        """Refuse test materials without training recordings, or without photographs or a stroke, if these are given."""
        options = options_of(opened.task, GenerationOptions)
        described_by, tested = options.given, opened.counts("test")
        unknown = sorted(tested.keys() - set(opened.materials))
        if unknown and (options.floor == "train" or described_by in ("material", "vibration")):
            raise ParameterError(f"{opened.task.name}: no training recording of {', '.join(unknown)}")
        lone = [name for name, count in tested.items() if count < 2]
        if lone and options.floor == "held-back":
            raise ParameterError(
                f"{opened.task.name}: two test recordings are needed of each material, one for the floor; got one of "
                + ", ".join(lone)
            )
        shown = opened.examples("test")
        blank = [name for name in tested if "image" in described_by and not len(shown.photographs_of(name))]
        if blank:
            raise ParameterError(f"{opened.task.name}: no test photograph of {', '.join(blank)}")

    def fits(self, opened: OpenTask, facts: ModelInfo) -> bool:
        """Return whether the model generates signals from what is given; from a stroke, any that learns a material."""
        if facts.task != "generation" or facts.gives != "signal" or facts.learns_from != "recordings":
            return False
        described_by = options_of(opened.task, GenerationOptions).given
        if opened.kind.domain == "displacement" and facts.needs == ("material",) and described_by != "image":
            return False
        described = {*facts.needs, *facts.instead} & {*described_by.split("+")}
        return bool(described) or (described_by == "vibration" and facts.needs == ("material",))

    def form(self, opened: OpenTask) -> AnswerForm:
        """Return a signal."""
        kind, rate = opened.kind, _Compared(opened).rate
        axes = len(kind.axes)
        return AnswerForm(
            "signal", f"samples at {rate:g} Hz, {kind.unit}, shape ({axes}, time), as long as asked or longer"
        )

    def questions(self, opened: OpenTask) -> list[Question]:
        """Return a question for each signal that is compared."""
        compared, questions = _Compared(opened), []
        strokes = {str(e.material): e for e in reversed(opened.train)}
        for material, examples in sorted(compared.examples.items()):
            number, seconds = compared.pieces.draws(compared.test[material])
            seconds += SPARE_SAMPLES / compared.rate
            for draw in range(number):
                example = examples[draw % len(examples)]
                questions.append(
                    Question(
                        f"{material}/{draw}",
                        _condition(compared, example, strokes.get(material), draw),
                        round(seconds, 6),
                    )
                )
        return questions

    def uses_shipped(self, opened: OpenTask, facts: ModelInfo) -> bool:
        """Return whether the model answers as it comes: given a stroke, without training for the task."""
        return options_of(opened.task, GenerationOptions).given == "vibration" and "vibration" in (
            *facts.needs,
            *facts.instead,
        )

    def answer(self, opened: OpenTask, loaded: LoadedRun, question: Question, seed: int) -> NDArray[Any]:
        """Return generated samples; under unknown speeds or forces, of the surface alone."""
        compared, facts = _Compared(opened), loaded.facts
        named = [name for name in compared.options.given.split("+") if name in facts.conditions]
        surface = {name: question.given[name] for name in named or ["material"]}
        if "vibration" in surface:
            surface["vibration"] = loaded.prepare_vibration(surface["vibration"])
        optional = {
            name: value
            for name, value in question.given.items()
            if name in facts.conditions and name not in ("material", "image", "text", "vibration")
        }
        seconds = question.seconds or 0.0
        over_displacement = loaded.kind.domain == "displacement"
        if over_displacement and "speed_mm_s" not in facts.conditions:
            seconds *= EVALUATION_SPEED_MM_S  # it gives recorded stretches, whose length is in mm
        own = child_seed(seed, "benchmark", question.id)
        generate = loaded.generator.generate
        try:
            signal = generate({**surface, **optional}, seconds=seconds, seed=own)
        except ParameterError:
            if not optional or over_displacement:
                raise
            signal = generate(surface, seconds=seconds, seed=own)
        if not isinstance(signal, Signal):
            raise ParameterError(f"{facts.name} generates images, not signals")
        signal = felt(signal)
        return (signal if signal.rate == compared.rate else resample(signal, compared.rate)).samples

    def judge(self, opened: OpenTask, answers: Answers, progress: ProgressCallback) -> Judgement:
        """Return the distance from recordings, and every measure of the protocol."""
        compared = _Compared(opened)
        kind = tactile_kind(opened.kind)
        signals: dict[str, list[Signal]] = {}
        for id, samples in answers.items():
            signals.setdefault(id.rpartition("/")[0], []).append(kind.signal(np.asarray(samples, np.float32)))
        notes: list[str] = []
        references = ReferenceModels(
            opened.folder / "judges", opened.kind, opened.examples("train"), EvaluationSettings(), progress
        )
        classifier = None
        if compared.options.given == "vibration":
            notes.append(
                "No classifier, and no measures in its embedding: one stroke of each surface is known."
            )
        else:
            classifier = classifier_of(references, compared.pieces, notes)
        with threadpool_limits(1):
            result = evaluate_generation(
                {MODEL: signals},
                train=compared.train,
                test=compared.test,
                floor=compared.floor,
                pieces=compared.pieces,
                embed=classifier.window_embeddings if classifier else None,
                classifier=classifier,
                on_part=progress,
            )
        figures = {"distance": _distance(result)} | _figures(result)
        if opened.kind.unit == "1" and opened.kind.domain == "displacement":
            figures["mean_friction_error"] = _mean_friction_error(compared, signals)
        return Judgement(figures, (*notes, *result.notes), _shown(compared, signals))


def _condition(compared: _Compared, example: Example, stroke: Example | None, draw: int) -> dict[str, Any]:
    """Return what is given of a recording: its surface, and the speed and force of the finger where known."""
    known = {name: example.condition.get(name) for name in ("speed_mm_s", "force_n")}
    condition: dict[str, Any] = {name: value for name, value in known.items() if value is not None}
    described = compared.options.given.split("+")
    if "text" in described:
        condition["text"] = str(example.material)
    if "image" in described:
        condition["image"] = example.photographs[draw % len(example.photographs)]
    if not {"text", "image"} & {*described}:
        condition["material"] = str(example.material)
    if compared.options.given == "vibration" and stroke is not None:
        condition["vibration"] = stroke.signal
        condition |= {
            f"vibration_{name}": value
            for name in ("speed_mm_s", "force_n")
            if (value := stroke.condition.get(name)) is not None
        }
    if compared.opened.kind.domain == "displacement":
        condition["speed_mm_s"] = EVALUATION_SPEED_MM_S
    return condition


def _distance(result: GenerationResult) -> Figure:
    """Return the mean over measures of where signals lie between floor (0) and ceiling (1), by material.

    Each measure of two sets of signals that separates the materials counts in units of its own span, from the mean
    floor to the mean ceiling over materials; nearer than the floor counts as the floor.
    """
    parts: dict[str, list[float]] = {material: [] for material in result.materials}
    for name in signal_measures():
        overall = result.overall.get(name)
        floor, ceiling = (overall.get(FLOOR), overall.get(CEILING)) if overall else (None, None)
        if floor is None or ceiling is None or ceiling <= SEPARATES * floor:
            continue
        for material, row in result.values[name].items():
            value, own = row.get(MODEL), row.get(FLOOR)
            if value is not None and own is not None:
                parts[material].append(max(0.0, (value - own) / (ceiling - floor)))
    by_item = {material: float(np.mean(values)) for material, values in parts.items() if values}
    if not by_item:
        raise ParameterError("no measure separates the materials of the task, so that nothing can be ranked")
    title = "distance from recordings, mean of all signal measures: 0 another recording, 1 another material"
    return mean_figure(by_item, "lower", title, floor=0.0, ceiling=1.0)


def _figures(result: GenerationResult) -> dict[str, Figure]:
    described, figures = describe_measures(), {}
    for name, row in result.overall.items():
        value = row[MODEL]
        if value is None:
            continue
        low, high = result.interval(name) or (None, None)
        about = described[name]
        figures[name] = Figure(
            value, about.better, about.title, about.unit, row.get(FLOOR), row.get(CEILING), low, high
        )
    return figures


def _mean_friction_error(compared: _Compared, generated: Mapping[str, Sequence[Signal]]) -> Figure:
    """Return how far the mean coefficient is off, by material; the floor is that of the floor's recordings."""

    def mean(signals: Sequence[Signal]) -> float:
        return float(np.mean([signal.samples.mean() for signal in signals]))

    real = {name: mean(signals) for name, signals in compared.test.items()}
    other = {name: mean((compared.floor or compared.train)[name]) for name in real}
    errors = np.array([abs(mean(generated[name]) - real[name]) for name in real])
    low, high = mean_interval(errors, least=0.0) or (None, None)
    everything = np.array(list(real.values()))
    floor = float(np.mean([abs(other[name] - real[name]) for name in real]))
    ceiling = float(np.abs(everything[:, None] - everything).sum() / max(1, len(real) * (len(real) - 1)))
    return Figure(
        float(errors.mean()), "lower", "error of the mean friction coefficient", "", floor, ceiling, low, high
    )


def _shown(compared: _Compared, generated: Mapping[str, Sequence[Signal]]) -> dict[str, Signal]:
    names = sorted(generated)
    chosen = [names[index] for index in np.unique(np.linspace(0, len(names) - 1, SHOWN).astype(int))]
    length = round(compared.pieces.seconds * compared.rate)
    stretches = {name: generated[name][0].cut(0, length) for name in chosen}
    return stretches | {f"{name} recorded": compared.test[name][0].cut(0, length) for name in chosen}


KIND = Generation()
