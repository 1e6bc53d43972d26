"""Form of the page Make: its parts by the conditions of a run's model, and a filled-in form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Self

from tactogram.datasets import JAPANESE
from tactogram.errors import ParameterError
from tactogram.model import Kind, SignalKind, condition_types
from tactogram.models import ModelDescription
from tactogram_studio.workspace.commands import arguments, assignments, command_line
from tactogram_studio.workspace.runs import FinishedRun

MOST_SEED = 2**31 - 1
MOST_COUNT = 8
LONGEST_S = 60.0
"""Longest signal that this page generates, s; the command line allows an hour."""
DRAWN = ("latent",)
"""Conditions without a part: the seed draws them, independently of the other conditions."""
PARTS: Mapping[str, str] = {
    "material": "materials",
    "image": "photo",
    "words": "words",
    "vibration": "vibration",
    "speed_mm_s": "speed",
    "force_n": "force",
    "motion": "motion",
    "vibration_speed_mm_s": "vibration_speed",
    "vibration_force_n": "vibration_force",
    "contactor": "contactor",
    "vibration_contactor": "vibration_contactor",
}
"""Part of the form by condition."""
OF_A_STROKE = (
    "speed_mm_s", "force_n", "contactor", "vibration_speed_mm_s", "vibration_force_n", "vibration_contactor",
)  # fmt: skip
"""Optional conditions that are fields of a request by the same name."""
Crop = tuple[float, float, float, float]


@dataclass(frozen=True)
class GenerationForm:
    """Required and optional parts of a run's form (values of `PARTS`), and the materials and words that it knows.

    A photograph, vibration or scores of words that are ``instead`` replace the materials, in this order; so does a
    text, also next to a photograph. ``gives`` is "signal" or "image", ``over`` the domain of the results ("time",
    "displacement" or "space"), and ``drawn`` are the conditions that the seed draws.
    """

    needs: tuple[str, ...]
    takes: tuple[str, ...]
    materials: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    gives: str = "signal"
    over: str = "time"
    drawn: tuple[str, ...] = ()
    instead: tuple[str, ...] = ()

    def has(self, part: str) -> bool:
        """Return whether the form has a part."""
        return part in (*self.needs, *self.instead, *self.takes)

    def shows(self, part: str) -> bool:
        """Return whether a part can be filled in: words need names, materials too, and a photograph in their place."""
        if part == "text":
            return self.mixes
        known = {"materials": bool(self.materials), "words": bool(self.words)}
        known["photo"] = known["materials"] or "photo" not in self.instead
        return self.has(part) and known.get(part, True)

    @property
    def some_words(self) -> bool:
        """Whether words may be missing; else a missing word gets its mean over the run's rated items."""
        return self.has("words") and "words" not in self.needs

    def used(self, request: GenerationRequest) -> GenerationRequest:
        """Return ``request`` without what a photograph, vibration, words or motion replace, and what goes with that."""
        if "photo" in self.instead and request.photo:
            request = replace(request, weights={}, vibration="")
        elif ({"vibration"} & {*self.instead} and request.vibration) or (
            "words" in self.instead and request.words
        ):
            request = replace(request, weights={})
        if request.vibration:
            request = replace(request, text="")
        if request.text:
            request = replace(request, weights={})
        if "words" in self.instead and (request.photo or request.vibration or request.text):
            request = replace(request, words={})
        if not request.vibration:
            request = replace(
                request, vibration_speed_mm_s=None, vibration_force_n=None, vibration_contactor=None
            )
        if request.motion:
            request = replace(request, speed_mm_s=None, force_n=None)
        return request

    @property
    def mixes(self) -> bool:
        """Whether materials are weighted; next to a photograph, a single one is chosen."""
        return "materials" in self.needs and bool(self.materials)


def form_of(model: ModelDescription, kind: Kind) -> GenerationForm:
    """Return the form of a run by its model and kind.

    Raises
    ------
    ParameterError
        If the model generates nothing, or has a condition without a part.
    """
    if model.task != "generation":
        raise ParameterError(f"a {model.task} model generates nothing; choose another run")
    conditions = model.conditions
    for name in conditions:
        if name not in PARTS and name not in DRAWN:
            raise ParameterError(f"condition {name!r} has no field here: {condition_types()[name].help}")
    return GenerationForm(
        needs=tuple(PARTS[name] for name in model.needs if name in PARTS),
        takes=tuple(PARTS[name] for name in model.takes if name in PARTS),
        materials=kind.materials if "material" in conditions else (),
        words=kind.words if "words" in conditions else (),
        gives=model.gives,
        over=kind.domain if isinstance(kind, SignalKind) else "space",
        drawn=tuple(name for name in conditions if name in DRAWN),
        instead=tuple(PARTS[name] for name in model.instead if name in PARTS),
    )


def form_of_run(run: FinishedRun) -> GenerationForm:
    """Return the form of a run: without a photograph in place of materials, if it was trained without photographs."""
    form = form_of(run.model, run.kind)
    if run.data.get("photographs", {}).get("train"):
        return form
    return replace(form, instead=tuple(part for part in form.instead if part != "photo"))


@dataclass(frozen=True)
class GenerationRequest:
    """A filled-in form, as JSON types; files and the folder ``run`` are relative to the workspace, "" if none.

    ``weights`` by material, of which those of 0 are ignored, are divided by their sum if ``to_one``. ``text`` is the
    surface in English, for a run that predicts it. Missing ``words`` (scores, 1 to 7) are left open, or set to their
    mean over the run's rated items. ``crop`` has left, top, right and bottom as shares of the photograph's sides.
    ``vibration_speed_mm_s`` and so on are of the stroke in ``vibration``; ``motion`` is a file or ``simulated``.
    """

    run: str = ""
    weights: Mapping[str, float] = field(default_factory=dict)
    to_one: bool = True
    text: str = ""
    words: Mapping[str, float] = field(default_factory=dict)
    photo: str = ""
    crop: Crop | None = None
    vibration: str = ""
    vibration_speed_mm_s: float | None = None
    vibration_force_n: float | None = None
    vibration_contactor: str | None = None
    contactor: str | None = None
    motion: str = ""
    speed_mm_s: float | None = None
    force_n: float | None = None
    seconds: float | None = None
    seed: int = 0
    count: int = 1

    @classmethod
    def from_stored(cls, values: Mapping[str, Any]) -> Self:
        """Return a stored request; malformed values become defaults, so that one field never loses the form."""
        known = {f.name: values[f.name] for f in fields(cls) if f.name in values}
        crop = known.get("crop")
        known["crop"] = tuple(map(float, crop)) if isinstance(crop, list | tuple) and len(crop) == 4 else None
        for name in ("weights", "words"):
            entries = known.get(name)
            entries = entries if isinstance(entries, dict) else {}
            known[name] = {str(key): float(value) for key, value in entries.items()}
        return cls(**known)

    @property
    def mix(self) -> dict[str, float]:
        """The positive weights, divided by their sum if ``to_one``."""
        weights = {name: weight for name, weight in self.weights.items() if weight > 0}
        total = sum(weights.values()) if self.to_one else 1.0
        return {name: weight / total for name, weight in weights.items()}

    @property
    def title(self) -> str:
        """Title of the results."""
        parts = []
        if self.mix:
            largest = sorted(self.mix.items(), key=lambda item: -item[1])[:4]
            pure = len(self.mix) == 1 and self.to_one
            parts.append(" + ".join(name if pure else f"{name} {weight:.2g}" for name, weight in largest))
        if self.photo:
            parts.append(_title_of(self.photo) or "photograph")
        elif self.vibration:
            parts.append(_title_of(self.vibration) or "recording")
        parts += [self.text] if self.text else []
        parts += [f"{word} {score:.2g}" for word, score in list(self.words.items())[:4]]
        if self.motion:
            parts.append(f"motion of {_title_of(self.motion) or 'a simulated hand'}")
        if self.speed_mm_s is not None:
            parts.append(f"{self.speed_mm_s:g} mm/s")
        if self.force_n is not None:
            parts.append(f"{self.force_n:g} N")
        return ", ".join(parts) or "words at their means"


def adapted(request: GenerationRequest, form: GenerationForm) -> GenerationRequest:
    """Return ``request`` without values that the form of another run lacks."""
    weights = {name: weight for name, weight in request.weights.items() if name in form.materials}
    if not weights and form.mixes:
        weights = {form.materials[0]: 1.0}
    if form.has("materials") and not form.mixes and len(weights) > 1:
        weights = {}
    lost: dict[str, Any] = {name: None for name in OF_A_STROKE if not form.has(PARTS[name])}
    return replace(
        request,
        weights=weights if form.has("materials") else {},
        text=request.text if form.mixes else "",
        words={word: score for word, score in request.words.items() if word in form.words},
        photo=request.photo if form.has("photo") else "",
        crop=request.crop if form.has("photo") else None,
        vibration=request.vibration if form.has("vibration") else "",
        motion=request.motion if form.has("motion") else "",
        seconds=request.seconds if form.over == "time" else None,
        **lost,
    )


def check_request(request: GenerationRequest, form: GenerationForm) -> None:
    """Raise `ParameterError` for what the form lacks, or what takes too long for a page; the model checks the rest."""
    replaced = any(getattr(request, part) for part in ("text", *form.instead))
    if form.mixes and not request.mix and not replaced:
        raise ParameterError("Set the weight of at least one material above 0.")
    if form.instead and not form.materials and not replaced:
        raise ParameterError("Describe the surface: give a recording of it, or the score of a word.")
    if "photo" in form.needs and not request.photo:
        raise ParameterError(
            "This model needs a photograph: drop or paste one, choose a file, or use the camera."
        )
    if request.seconds is not None and request.seconds > LONGEST_S:
        raise ParameterError(
            f"Length must be at most {LONGEST_S:g} s, got {request.seconds:g}; use the command line for longer ones."
        )
    if not 1 <= request.count <= MOST_COUNT:
        raise ParameterError(f"Number of results must be 1 to {MOST_COUNT}, got {request.count}.")


def command(request: GenerationRequest, form: GenerationForm, *, photo: str = "") -> str:
    """Return the equivalent command, to be run in the workspace; ``photo`` is the file of the cropped photograph."""
    rest = form.has("words") and not form.some_words and set(form.words) - set(request.words)
    options = {
        "--mix": assignments(request.mix) if form.mixes else "",
        "--material": "" if form.mixes else next(iter(request.mix), ""),
        "--image": request.photo and (photo or request.photo),
        "--text": request.text,
        "--words": assignments(request.words) if form.has("words") else "",
        "--rest": "mean" if rest else "",
        "--vibration": request.vibration,
        "--motion": request.motion,
        "--vibration-speed": request.vibration_speed_mm_s,
        "--vibration-force": request.vibration_force_n,
        "--speed": request.speed_mm_s,
        "--force": request.force_n,
        "--seconds": request.seconds,
        "--vibration-contactor": request.vibration_contactor,
        "--contactor": request.contactor,
        "--seed": str(request.seed),
        "--count": request.count if request.count > 1 else None,
        "--out": "made.png" if form.gives == "image" else "made.wav",
    }
    return command_line(arguments("generate", request.run, options=options))


def word_label(word: str) -> str:
    """Return the label of a word: in English, and in Japanese if it is one of the ten."""
    return f"{word}  {JAPANESE[word]}" if word in JAPANESE else word


def _title_of(file: str) -> str:
    """Return the name of an uploaded file as it was before its hash was added."""
    return file.rpartition("/")[2].rpartition(".")[0].rpartition("-")[0]
