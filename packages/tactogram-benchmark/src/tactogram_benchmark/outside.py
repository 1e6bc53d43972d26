"""Tasks for models in any framework: training data and questions as files, and answers scored."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from tactogram.errors import DataError, ParameterError
from tactogram.model import ImageExample
from tactogram.models import available
from tactogram.signal import Image, Signal
from tactogram.signal.io import atomic_write, check_writable, load_arrays, write_text
from tactogram.text_files import read_json
from tactogram.validation import FrozenModel, validated
from tactogram.workflows import ProgressCallback, silent
from tactogram_benchmark.data import OpenTask, rated_examples, ratings_of
from tactogram_benchmark.result import BenchmarkResult, result_of, save_shown
from tactogram_benchmark.task import BenchmarkTask
from tactogram_benchmark.task_kind import Question, check_answers, kind_of

ABOUT = "about.json"


class AboutModel(FrozenModel):
    """Content of ``about.json`` beside answers. Unknown keys are errors."""

    model: str = Field(pattern=r"^[\w.-]+$")
    how: str = Field(min_length=1)
    """How it was made and trained, in a sentence."""
    code: str = ""
    """Address of its source."""


def write_questions(opened: OpenTask, out: Path) -> dict[str, Any]:
    """Write a task as files: ``task.json``, ``train.npz``, ``validation.npz`` and ``questions.npz``.

    ``task.json`` says what is asked, and lists the examples of each part and the questions: the facts of each, and the
    name of its arrays in the part's ``.npz``: samples, float32, shape (axis, time), or pixels, uint8, shape (row,
    column, 3). Questions are called by hashes, since names of materials would tell what is on a photograph. The
    validation part is left out where it trains the judge.

    Returns
    -------
    dict
        ``task``, ``out``, and the number of examples and ``questions``.

    Raises
    ------
    ParameterError
        If ``out`` cannot be written to.
    """
    check_writable(out, folder=True)
    kind, task = kind_of(opened.task.kind), opened.task
    # In the order of the hashes: that of the store would tell which recordings are of one material.
    form, questions = kind.form(opened), sorted(_hashed(task, kind.questions(opened)), key=lambda q: q.id)
    parts: dict[str, list[dict[str, Any]]] = {}
    for part in ("train",) if kind.validation_judges else ("train", "validation"):
        arrays: dict[str, NDArray[Any]] = {}
        parts[part] = [_example(opened, example, arrays) for example in _examples(opened, part)]
        _save(out / f"{part}.npz", arrays)
    arrays = {}
    listed = [
        {"id": question.id, "seconds": question.seconds, "given": _given(question.id, question.given, arrays)}
        for question in questions
    ]
    _save(out / "questions.npz", arrays)
    signal = None
    if len(opened.store):
        held = opened.kind
        signal = {"rate": held.rate, "unit": held.unit, "axes": list(held.axes), "domain": held.domain}
    facts = {
        "task": task.name,
        "task_sha256": task.sha256,
        "title": task.title,
        "simulated": opened.store.simulated,
        "given": kind.given,
        "asked": kind.asked,
        "answer": {"what": form.what, "form": form.text, "names": list(form.names)},
        "signal": signal,
        "choose_on": task.choose_on,
        **parts,
        "questions": listed,
    }
    write_text(out / "task.json", json.dumps(facts, indent=1, ensure_ascii=False) + "\n")
    return {
        "task": task.name,
        "out": str(out),
        **{part: len(held) for part, held in parts.items()},
        "questions": len(questions),
    }


def score_answers(
    opened: OpenTask, folder: Path, out: Path, *, progress: ProgressCallback = silent
) -> list[BenchmarkResult]:
    """Judge the answers in a folder, one file ``SEED.npz`` per seed beside ``about.json``, and write their results.

    Raises
    ------
    DataError
        If there are no answers, or a file is damaged.
    ParameterError
        If answers are incomplete or of another shape, or ``about.json`` is invalid.
    """
    values = read_json(folder / ABOUT)
    if not isinstance(values, dict):
        raise DataError(folder / ABOUT, f"must hold model and how, got {type(values).__name__}")
    about = validated(AboutModel, values, where=str(folder / ABOUT))
    kind = kind_of(opened.task.kind)
    if about.model in available() or about.model in kind.baselines:
        raise ParameterError(
            f"{folder / ABOUT}: model {about.model} is one of this package; choose another name"
        )
    files = {int(file.stem): file for file in sorted(folder.glob("*.npz")) if file.stem.isdecimal()}
    if not files:
        raise DataError(folder, "expected answers as 0.npz, 1.npz, … by seed, found none")
    own, form = kind.questions(opened), kind.form(opened)
    questions = _hashed(opened.task, own)
    results = []
    for seed, file in sorted(files.items()):
        answers = load_arrays(file)
        check_answers(form, questions, answers, where=str(file))
        by_id = {question.id: answers[hashed.id] for question, hashed in zip(own, questions, strict=True)}
        judgement = kind.judged(opened, by_id, progress)
        how = f"{about.how} {about.code}".strip()
        result = result_of(opened, about.model, "outside", seed, judgement, recipe=how)
        results.append(result)
        if seed == min(files):
            save_shown(out, opened.task.name, about.model, judgement.shown, simulated=opened.store.simulated)
    for result in results:
        result.save(out)
    return results


def _hashed(task: BenchmarkTask, questions: Sequence[Question]) -> list[Question]:
    """Return the questions with ids that tell nothing."""

    def hashed(id: str) -> str:
        return hashlib.sha256(f"{task.sha256} {id}".encode()).hexdigest()[:16]

    return [replace(question, id=hashed(question.id)) for question in questions]


def _examples(opened: OpenTask, part: str) -> Any:
    return opened.examples(part) if len(opened.store) else rated_examples(opened, part)


def _example(opened: OpenTask, example: Any, arrays: dict[str, NDArray[Any]]) -> dict[str, Any]:
    facts: dict[str, Any] = {"id": example.id, "item": example.item}
    if isinstance(example, ImageExample):
        arrays[example.id] = example.image.pixels
    else:
        arrays[example.id] = example.signal.samples
        facts["material"] = example.material
        facts |= {
            name: example.condition[name]
            for name in ("speed_mm_s", "force_n")
            if example.condition.get(name) is not None
        }
        facts["photographs"] = [f"{example.material}/photograph/{n}" for n in range(len(example.photographs))]
        for number, name in enumerate(facts["photographs"]):
            if name not in arrays:
                arrays[name] = example.photographs[number].pixels
    if example.rated is not None:
        means = ratings_of(opened).scale.from_unit(example.rated.means)
        words = zip(example.rated.words, means.tolist(), strict=True)
        facts["words"] = {word: score for word, score in words if np.isfinite(score)}
    return facts


def _given(id: str, given: Mapping[str, Any], arrays: dict[str, NDArray[Any]]) -> dict[str, Any]:
    """Return the given conditions as JSON types; signals and images are named, and added to ``arrays``."""
    described: dict[str, Any] = {}
    for name, value in given.items():
        if isinstance(value, Signal | Image):
            described[name] = f"{id}/{name}"
            arrays[described[name]] = value.samples if isinstance(value, Signal) else value.pixels
        else:
            described[name] = dict(value) if isinstance(value, Mapping) else value
    return described


def _save(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    named: dict[str, Any] = {name: np.asarray(value) for name, value in arrays.items()}
    with atomic_write(path) as part:
        np.savez(part, **named)
