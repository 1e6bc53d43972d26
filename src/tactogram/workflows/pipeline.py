"""Pipelines: a task by its name, with a model that is loaded once and inputs as people have them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.model.conditions import some_of
from tactogram.rendering.files.analysis import carrier
from tactogram.rendering.ready_effects import effect
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_image, read_signal
from tactogram.signal.motion import Motion
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.generation.text_understanding import Understanding, understand
from tactogram.workflows.recognition.classify import classify
from tactogram.workflows.training.loaded_run import LoadedRun, load_run


@dataclass(frozen=True)
class Generation:
    """A task that makes a signal or an image; call it with an input, as often as you like."""

    task: str
    run: LoadedRun

    def __call__(
        self,
        given: Any,
        *,
        speed_mm_s: float | None = None,
        force_n: float | None = None,
        motion: Motion | None = None,
        given_speed_mm_s: float | None = None,
        seconds: float | None = None,
        seed: int = 0,
    ) -> Signal | Image:
        """Return what is made of ``given``.

        Parameters
        ----------
        given : str, dict, Signal, Image or path
            A text in English, of a material or of a ready effect (`tactogram.effects`); scores by word, ``{"rough":
            6}``; a material or weights of several; a recorded stroke, a photograph, or the path of one.
        speed_mm_s, force_n, motion : float, float, Motion, optional
            How the surface is stroked: constant speed in mm/s and force in N, or both over time.
        given_speed_mm_s : float, optional
            Speed of a given stroke, mm/s.
        seconds, seed : float, int
            Length in s, by default the model's own, and seed of what is drawn.

        Raises
        ------
        ParameterError
            If the run does not take such an input, or knows no such material or word; of a text, if it names none.
        """
        name = _TASKS[self.task].given
        if name == "text" and isinstance(given, str) and (ready := self.understood(given).effect):
            if any(value is not None for value in (speed_mm_s, force_n, motion)):
                raise ParameterError(
                    f"{ready} is an effect, which is not stroked: omit speed, force and motion"
                )
            return carrier(effect(ready, seconds=seconds, seed=seed))
        condition = {
            name: _READERS[name](self.run, given) if name in _READERS else given,
            "speed_mm_s": speed_mm_s,
            "force_n": force_n,
            "motion": motion,
            "vibration_speed_mm_s": given_speed_mm_s,
        }
        (result,) = generate(self.run, condition, seconds=seconds, seed=seed)
        return result

    def understood(self, text: str) -> Understanding:
        """Return what a text in English names: a ready effect or materials, and words that name neither."""
        return understand(text, self.run.any_kind.materials)


@dataclass(frozen=True)
class Recognition:
    """A task that names the material of a signal; call it with a signal or its file, as often as you like."""

    task: str
    run: LoadedRun

    def __call__(self, given: Signal | Path | str) -> dict[str, Any]:
        """Return what `tactogram.classify` does of ``given``."""
        return classify(self.run, _signal(given))


@dataclass(frozen=True)
class _Task:
    given: str
    gives: str
    shipped: str | None = None
    purpose: str = ""
    """That of `tactogram train --for`, if no run comes with the package."""


_TASKS: Mapping[str, _Task] = {
    "text-to-touch": _Task("text", "signal", "texture_flow"),
    "words-to-touch": _Task("words", "signal", "texture_flow"),
    "material-to-touch": _Task("material", "signal", "texture_flow"),
    "stroke-to-touch": _Task("vibration", "signal", "texture_flow"),
    "photo-to-touch": _Task("image", "signal", purpose="photograph"),
    "words-to-image": _Task("words", "image", purpose="words"),
    "touch-to-material": _Task("vibration", "probabilities"),
}


def pipeline(task: str, run: Path | str | LoadedRun | None = None) -> Generation | Recognition:
    """Return a function for a task, with its model loaded.

    ``task`` is one of ``text-to-touch``, ``words-to-touch``, ``material-to-touch``, ``stroke-to-touch``,
    ``photo-to-touch``, ``words-to-image`` and ``touch-to-material``. ``run`` is a trained run; for the first four it is
    by default ``texture_flow``, which comes trained on *simulated* surfaces; of recorded materials a run of
    ``texture_var`` is the closest. The function takes a text, scores by word,
    weights by material, a signal, an image, or the path of one of the two; and the keywords of `Generation`.

    >>> rough = tactogram.pipeline("words-to-touch")({"rough": 6, "sticky": 2}, speed_mm_s=150)   # doctest: +SKIP

    Raises
    ------
    ParameterError
        For an unknown task, a task that needs a run of your own, or a run that does something else.
    """
    if not isinstance(task, str) or task not in _TASKS:
        raise ParameterError.must(
            "task", f"be {some_of(tuple(_TASKS), like=str(task))}", task, choices=_TASKS
        )
    entry = _TASKS[task]
    chosen = entry.shipped if run is None else run
    if chosen is None:
        how = f" (tactogram train --for {entry.purpose} --data STORE)" if entry.purpose else ""
        other = "; tactogram.convert draws a photograph as a relief" if task == "photo-to-touch" else ""
        raise ParameterError(
            f"no run for {task} comes with the package: train one on your recordings{how}, "
            f"and give it: pipeline({task!r}, 'runs/NAME'){other}"
        )
    loaded = chosen if isinstance(chosen, LoadedRun) else load_run(chosen)
    if loaded.facts.gives != entry.gives:
        raise ParameterError(
            f"{task} needs a run that gives {entry.gives}, got {loaded.facts.name}, which gives {loaded.facts.gives}"
        )
    return Recognition(task, loaded) if entry.gives == "probabilities" else Generation(task, loaded)


def _signal(source: Signal | Path | str) -> Signal:
    return source if isinstance(source, Signal) else read_signal(source)


_READERS: Mapping[str, Callable[[LoadedRun, Any], Any]] = {
    "vibration": lambda run, source: run.prepare_vibration(_signal(source)),
    "image": lambda _, source: source if isinstance(source, Image) else read_image(source),
}
"""How an input is read that may be the path of a file."""
