"""Form of the page Make, built from the conditions that a run's model needs and takes."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any, Self

from tactogram.datasets.ratings.ratings import SEVEN_POINT
from tactogram.datasets.ratings.words import JAPANESE
from tactogram.errors import ParameterError
from tactogram.model import CONDITIONS, Kind, SignalKind
from tactogram.models import ModelDescription

MOST_SEED = 2**31 - 1
MOST_COUNT = 8
LONGEST_S = 60.0
"""Longest that this page shows; the verb makes up to an hour."""
DRAWN = ("latent",)
"""Conditions without a field: the seed draws them, whatever the other values are."""
FIELDS: Mapping[str, str] = {
    "material": "materials",
    "image": "photo",
    "words": "words",
    "vibration": "vibration",
    "speed_mm_s": "speed",
    "force_n": "force",
}
"""Which part of a form gives a condition."""
Crop = tuple[float, float, float, float]


@dataclass(frozen=True)
class GenerationForm:
    """Fields that can be requested of a run.

    Parameters
    ----------
    needs, takes : tuple of str
        Parts of the form (values of `FIELDS`) that must and that may be filled in.
    materials, words : tuple of str
        That it knows.
    gives : {"signal", "image"}
    over : {"time", "displacement", "space"}
        What its results run over.
    own_seed : tuple of str
        Conditions that the seed draws.
    """

    needs: tuple[str, ...]
    takes: tuple[str, ...]
    materials: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    gives: str = "signal"
    over: str = "time"
    own_seed: tuple[str, ...] = ()

    def has(self, part: str) -> bool:
        """Tell whether a part stands in the form."""
        return part in (*self.needs, *self.takes)

    @property
    def mixes(self) -> bool:
        """Whether materials are weighed; a photograph's label is one name."""
        return "materials" in self.needs


def form_of(facts: ModelDescription, kind: Kind) -> GenerationForm:
    """Return the form of a run.

    Parameters
    ----------
    facts : Facts
        Of its model.
    kind : SignalKind or ImageKind
        Of the run.

    Raises
    ------
    ParameterError
        If the model generates nothing, or a condition has no part here.
    """
    if facts.task != "generation":
        raise ParameterError(f"a model of {facts.task} makes nothing; choose a run that generates")
    for name in (*facts.needs, *facts.takes):
        if name not in FIELDS and name not in DRAWN:
            raise ParameterError(f"condition {name!r} has no field here: {CONDITIONS[name]}")
    return GenerationForm(
        needs=tuple(FIELDS[name] for name in facts.needs if name in FIELDS),
        takes=tuple(FIELDS[name] for name in facts.takes if name in FIELDS),
        materials=kind.materials if "material" in (*facts.needs, *facts.takes) else (),
        words=kind.words if "words" in (*facts.needs, *facts.takes) else (),
        gives=facts.gives,
        over=kind.domain if isinstance(kind, SignalKind) else "space",
        own_seed=tuple(name for name in (*facts.needs, *facts.takes) if name in DRAWN),
    )


@dataclass(frozen=True)
class GenerationRequest:
    """A form that is filled in; JSON types, so that it survives a reload.

    Parameters
    ----------
    run : str
        Folder of the run, relative to the workspace.
    weights : mapping
        By material; 0 is left out.
    to_one : bool
        Whether the weights are divided by their sum.
    words : mapping
        Scores of the words that were set, 1 to 7; the others are the mean over the run's rated items.
    photo, vibration : str
        Files, relative to the workspace; empty where none is chosen.
    crop : tuple of float, optional
        Left, top, right, bottom of the part of the photograph, as shares of its sides.
    speed_mm_s, force_n, seconds : float, optional
    seed, count : int
    """

    run: str = ""
    weights: Mapping[str, float] = field(default_factory=dict)
    to_one: bool = True
    words: Mapping[str, float] = field(default_factory=dict)
    photo: str = ""
    crop: Crop | None = None
    vibration: str = ""
    speed_mm_s: float | None = None
    force_n: float | None = None
    seconds: float | None = None
    seed: int = 0
    count: int = 1

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Return what was stored; what is not understood is left at its default: a form is never lost for one field."""
        known = {f.name: values[f.name] for f in fields(cls) if f.name in values}
        crop = known.get("crop")
        known["crop"] = tuple(map(float, crop)) if isinstance(crop, list | tuple) and len(crop) == 4 else None
        for name in ("weights", "words"):
            held = known.get(name)
            known[name] = (
                {str(key): float(value) for key, value in held.items()} if isinstance(held, dict) else {}
            )
        return cls(**known)

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON types."""
        return asdict(self)

    def with_changes(self, **changes: Any) -> Self:
        """Return it with other values."""
        return replace(self, **changes)

    @property
    def mix(self) -> dict[str, float]:
        """The weights as the model is given them: those above 0, divided by their sum if that is asked."""
        held = {name: weight for name, weight in self.weights.items() if weight > 0}
        total = sum(held.values())
        return {name: weight / total if self.to_one else weight for name, weight in held.items()}

    @property
    def text(self) -> str:
        """What a result of it is called."""
        parts = []
        if self.mix:
            parts.append(
                " + ".join(
                    name if len(self.mix) == 1 and self.to_one else f"{name} {weight:.2g}"
                    for name, weight in sorted(self.mix.items(), key=lambda item: -item[1])[:4]
                )
            )
        if self.photo:
            parts.append(self.photo.rpartition("/")[2].rpartition(".")[0].rpartition("-")[0] or "photograph")
        parts += [f"{word} {score:.2g}" for word, score in list(self.words.items())[:4]]
        if self.speed_mm_s is not None:
            parts.append(f"{self.speed_mm_s:g} mm/s")
        if self.force_n is not None:
            parts.append(f"{self.force_n:g} N")
        return ", ".join(parts) or "words at their means"


def suited(asked: GenerationRequest, form: GenerationForm) -> GenerationRequest:
    """Return ``asked`` without what a form does not have: another run was chosen."""
    weights = {name: weight for name, weight in asked.weights.items() if name in form.materials}
    if not weights and form.mixes:
        weights = {form.materials[0]: 1.0}
    if form.has("materials") and not form.mixes and len(weights) > 1:
        weights = {}
    return asked.with_changes(
        weights=weights if form.has("materials") else {},
        words={word: score for word, score in asked.words.items() if word in form.words},
        photo=asked.photo if form.has("photo") else "",
        crop=asked.crop if form.has("photo") else None,
        vibration=asked.vibration if form.has("vibration") else "",
        speed_mm_s=asked.speed_mm_s if form.has("speed") else None,
        force_n=asked.force_n if form.has("force") else None,
        seconds=asked.seconds if form.over == "time" else None,
    )


def check(asked: GenerationRequest, form: GenerationForm) -> None:
    """Refuse a form that cannot be made of, in a sentence for the person who fills it in.

    Raises
    ------
    ParameterError
        Naming the part.
    """
    if form.mixes and not asked.mix:
        raise ParameterError("Every material is at 0: give at least one a weight.")
    if "photo" in form.needs and not asked.photo:
        raise ParameterError(
            "This model goes by a photograph: drop one, paste one, choose a file or use the camera."
        )
    for name, value in {
        "Speed (mm/s)": asked.speed_mm_s,
        "Force (N)": asked.force_n,
        "Length (s)": asked.seconds,
    }.items():
        if value is not None and not (math.isfinite(value) and value > 0):
            raise ParameterError(
                f"{name} must be greater than 0, got {value:g}; empty leaves it to the model."
            )
    if asked.seconds is not None and asked.seconds > LONGEST_S:
        raise ParameterError(
            f"Length must be at most {LONGEST_S:g} s here, got {asked.seconds:g}; the command line makes longer ones."
        )
    if not 0 <= asked.seed <= MOST_SEED:
        raise ParameterError(f"Seed must be 0 to {MOST_SEED}, got {asked.seed}.")
    if not 1 <= asked.count <= MOST_COUNT:
        raise ParameterError(f"How many must be 1 to {MOST_COUNT}, got {asked.count}.")
    for word, score in asked.words.items():
        if not SEVEN_POINT.low <= score <= SEVEN_POINT.high:
            raise ParameterError(
                f"{word} must be {SEVEN_POINT.low:g} to {SEVEN_POINT.high:g}, got {score:g}."
            )
    if asked.crop is not None and not _is_crop(asked.crop):
        raise ParameterError("The part of the photograph must have a width and a height; drag again.")


def command(asked: GenerationRequest, form: GenerationForm, *, photo: str = "", out: str = "") -> str:
    """Return the command line, run in the workspace, that makes the same.

    Parameters
    ----------
    photo : str
        The file of the cropped photograph; by default the whole.
    out : str
        By default ``made.wav`` or ``made.png``.
    """
    words = ["tactogram", "generate", asked.run]
    if asked.mix:
        if form.mixes:
            words += ["--mix", ",".join(f"{name}={_exact(weight)}" for name, weight in asked.mix.items())]
        else:
            words += ["--material", next(iter(asked.mix))]
    if asked.photo:
        words += ["--image", photo or asked.photo]
    if form.has("words"):
        if asked.words:
            words += ["--words", ",".join(f"{word}={_exact(score)}" for word, score in asked.words.items())]
        if set(form.words) - set(asked.words):
            words += ["--rest", "mean"]
    if asked.vibration:
        words += ["--vibration", asked.vibration]
    for option, value in {
        "--speed": asked.speed_mm_s,
        "--force": asked.force_n,
        "--seconds": asked.seconds,
    }.items():
        if value is not None:
            words += [option, _exact(value)]
    words += ["--seed", str(asked.seed)]
    if asked.count > 1:
        words += ["--count", str(asked.count)]
    words += ["--out", out or ("made.png" if form.gives == "image" else "made.wav")]
    return shlex.join(words)


def word_label(word: str) -> str:
    """Return a word as the form shows it: English, and Japanese where it is one of the ten."""
    return f"{word}  {JAPANESE[word]}" if word in JAPANESE else word


def _is_crop(crop: Crop) -> bool:
    left, top, right, bottom = crop
    return all(map(math.isfinite, crop)) and 0 <= left < right <= 1 and 0 <= top < bottom <= 1


def _exact(value: float) -> str:
    """Return a number that reads back as itself."""
    return f"{value:g}" if float(f"{value:g}") == value else repr(float(value))


@dataclass(frozen=True)
class FormHistory:
    """States of a form to go back and forth between.

    Parameters
    ----------
    past, future : tuple of mapping
        As of `GenerationRequest.as_dict`; the nearest last.
    """

    past: tuple[Mapping[str, Any], ...] = ()
    future: tuple[Mapping[str, Any], ...] = ()

    MOST = 50

    def after(self, state: Mapping[str, Any]) -> FormHistory:
        """Return the history after ``state`` was left for a new one: what was undone is gone."""
        return FormHistory((*self.past, state)[-self.MOST :], ())

    def undone(self, present: Mapping[str, Any]) -> tuple[FormHistory, Mapping[str, Any]]:
        """Return the history and the state before ``present``.

        Raises
        ------
        ParameterError
            If there is none.
        """
        if not self.past:
            raise ParameterError("Nothing to undo.")
        return FormHistory(self.past[:-1], (*self.future, present)), self.past[-1]

    def redone(self, present: Mapping[str, Any]) -> tuple[FormHistory, Mapping[str, Any]]:
        """Return the history and the state after ``present``.

        Raises
        ------
        ParameterError
            If there is none.
        """
        if not self.future:
            raise ParameterError("Nothing to redo.")
        return FormHistory((*self.past, present), self.future[:-1]), self.future[-1]
