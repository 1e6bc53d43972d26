"""Form of the page Make: the conditions that a run's model is given, and a filled-in form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Self

from tactogram.datasets import JAPANESE
from tactogram.errors import ParameterError
from tactogram.model import Kind, SignalKind, condition_types
from tactogram.models import ModelDescription
from tactogram_studio.workspace.commands import arguments, command_line, stem_of
from tactogram_studio.workspace.runs import FinishedRun

MOST_SEED = 2**31 - 1
MOST_COUNT = 8
LONGEST_S = 60.0
"""Longest signal that this page generates, s; the command line allows an hour."""
OF_A_RECORDING = "vibration_"
"""Start of the names of conditions that say how the vibration was recorded."""
Crop = tuple[float, float, float, float]


@dataclass(frozen=True)
class GenerationForm:
    """Conditions that a run needs and takes, by `tactogram.model.condition_types`; materials and words that it knows.

    A photograph, vibration or scores of words that are ``instead`` replace the materials, in this order; so does a
    text, also next to a photograph. ``gives`` is "signal" or "image", ``over`` the domain of the results ("time",
    "displacement" or "space"), and ``drawn`` are the conditions for Python alone, which the seed draws.
    """

    needs: tuple[str, ...]
    takes: tuple[str, ...]
    materials: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    gives: str = "signal"
    over: str = "time"
    drawn: tuple[str, ...] = ()
    instead: tuple[str, ...] = ()

    def has(self, name: str) -> bool:
        """Return whether the form has a condition; a text in place of the materials that are mixed."""
        return name in (*self.needs, *self.instead, *self.takes) or (name == "text" and self.mixes)

    def shows(self, name: str) -> bool:
        """Return whether a condition can be stated: words need names; materials, and so a photograph, too."""
        known = {"material": bool(self.materials), "words": bool(self.words)}
        known["image"] = known["material"] or "image" not in self.instead
        return self.has(name) and known.get(name, True)

    @property
    def some_words(self) -> bool:
        """Whether words may be missing; else a missing word gets its mean over the run's rated items."""
        return self.has("words") and "words" not in self.needs

    @property
    def mixes(self) -> bool:
        """Whether materials are weighted; next to a photograph, a single one is chosen."""
        return "material" in self.needs and bool(self.materials)

    def used(self, request: GenerationRequest) -> GenerationRequest:
        """Return ``request`` without what a photograph, vibration, words or motion replace, and what goes with that."""
        values = dict(request.values)

        def drop(*names: str) -> None:
            for name in names:
                values.pop(name, None)

        if "image" in self.instead and "image" in values:
            drop("material", "vibration")
        elif {"vibration", "words"} & {*self.instead} & values.keys():
            drop("material")
        drop(*(["text"] if "vibration" in values else []))
        drop(*(["material"] if "text" in values else []))
        if "words" in self.instead and {"image", "vibration", "text"} & values.keys():
            drop("words")
        if "vibration" not in values:
            drop(*(name for name in request.values if name.startswith(OF_A_RECORDING)))
        if "motion" in values:
            drop("speed_mm_s", "force_n")
        return replace(request, values=values)


def form_of(model: ModelDescription, kind: Kind) -> GenerationForm:
    """Return the form of a run by its model and kind.

    Raises
    ------
    ParameterError
        If the model generates nothing, or needs a condition for Python alone.
    """
    if model.task != "generation":
        raise ParameterError(f"a {model.task} model generates nothing; choose another run")
    conditions, known = model.conditions, condition_types()
    for name in model.needs:
        if not known[name].options:
            raise ParameterError(f"condition {name!r} has no field here: {known[name].help}")
    return GenerationForm(
        needs=model.needs,
        takes=tuple(name for name in model.takes if known[name].options),
        materials=kind.materials if "material" in conditions else (),
        words=kind.words if "words" in conditions else (),
        gives=model.gives,
        over=kind.domain if isinstance(kind, SignalKind) else "space",
        drawn=tuple(name for name in conditions if not known[name].options),
        instead=model.instead,
    )


def form_of_run(run: FinishedRun) -> GenerationForm:
    """Return the form of a run: without a photograph in place of materials, if it was trained without photographs."""
    form = form_of(run.model, run.kind)
    if run.data.get("photographs", {}).get("train"):
        return form
    return replace(form, instead=tuple(name for name in form.instead if name != "image"))


@dataclass(frozen=True)
class GenerationRequest:
    """A filled-in form, as JSON types; the folder ``run`` is relative to the workspace.

    ``values`` state conditions by name, as their options do: numbers, names, and files relative to the workspace.
    Weights by ``material`` are divided by their sum, and those of 0 ignored. Missing ``words``
    (scores, 1 to 7) are left open, or set to their mean over the run's rated items. ``crop`` has left, top, right and
    bottom as shares of the photograph's sides. ``typed`` is the text that gave the weights, until these change.
    """

    run: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    crop: Crop | None = None
    seconds: float | None = None
    seed: int = 0
    count: int = 1
    typed: str = ""

    @classmethod
    def from_stored(cls, stored: Mapping[str, Any]) -> Self:
        """Return a stored request; malformed values become defaults, so that one field never loses the form."""
        known = {f.name: stored[f.name] for f in fields(cls) if f.name in stored}
        crop, values = known.get("crop"), known.get("values")
        known["crop"] = tuple(map(float, crop)) if isinstance(crop, list | tuple) and len(crop) == 4 else None
        known["values"] = {
            name: value
            for name, value in (values.items() if isinstance(values, dict) else ())
            if name not in ("material", "words") or isinstance(value, dict)
        }
        return cls(**known)

    def changed(self, **changes: Any) -> Self:
        """Return a request with other fields and values of conditions; an empty value states nothing."""
        own = {name: changes.pop(name) for name in [f.name for f in fields(self)] if name in changes}
        values = {**self.values, **changes}
        if values.get("material") != self.values.get("material"):
            own = {"typed": "", **own}
        stated = {name: value for name, value in values.items() if value not in (None, "", {})}
        return replace(self, **{"values": stated, **own})

    @property
    def weights(self) -> Mapping[str, float]:
        """The weights by material."""
        weights: Mapping[str, float] = self.values.get("material", {})
        return weights

    @property
    def words(self) -> Mapping[str, float]:
        """The scores by word."""
        words: Mapping[str, float] = self.values.get("words", {})
        return words

    @property
    def mix(self) -> dict[str, float]:
        """The positive weights, divided by their sum."""
        weights = {name: weight for name, weight in self.weights.items() if weight > 0}
        total = sum(weights.values())
        return {name: weight / total for name, weight in weights.items()}

    @property
    def title(self) -> str:
        """Title of the results."""
        parts, values = [], self.values
        if self.mix:
            largest = sorted(self.mix.items(), key=lambda item: -item[1])[:4]
            mix = " + ".join(
                name if len(self.mix) == 1 else f"{name} {weight:.2g}" for name, weight in largest
            )
            named = not self.typed or stem_of(self.typed.lower()) == mix
            parts.append(mix if named else f"{self.typed}: {mix}")
        if "image" in values:
            parts.append(_title_of(values["image"]) or "photograph")
        elif "vibration" in values:
            parts.append(_title_of(values["vibration"]) or "recording")
        parts += [values["text"]] if "text" in values else []
        parts += [f"{word} {score:.2g}" for word, score in list(self.words.items())[:4]]
        if "motion" in values:
            parts.append(f"motion of {_title_of(values['motion']) or 'a simulated hand'}")
        parts += [
            f"{values[name]:g} {one.unit}"
            for name, one in condition_types().items()
            if one.unit and name in values and not name.startswith(OF_A_RECORDING)
        ]
        return ", ".join(parts) or "words at their means"


def adapted(request: GenerationRequest, form: GenerationForm) -> GenerationRequest:
    """Return ``request`` without values that the form of another run lacks."""
    values = {name: value for name, value in request.values.items() if form.has(name)}
    weights = {name: weight for name, weight in request.weights.items() if name in form.materials}
    if not weights and form.mixes:
        weights = {form.materials[0]: 1.0}
    if not form.mixes and len(weights) > 1:
        weights = {}
    words = {word: score for word, score in request.words.items() if word in form.words}
    return replace(
        request,
        values=values,
        crop=request.crop if form.has("image") else None,
        seconds=request.seconds if form.over == "time" else None,
    ).changed(material=weights if form.has("material") else {}, words=words)


def check_request(request: GenerationRequest, form: GenerationForm) -> None:
    """Raise `ParameterError` for what the form lacks, or what takes too long for a page; the model checks the rest."""
    replaced = {"text", *form.instead} & request.values.keys()
    if form.mixes and not request.mix and not replaced:
        raise ParameterError("Set the weight of at least one material above 0.")
    if form.instead and not form.materials and not replaced:
        raise ParameterError("Describe the surface: give a recording of it, or the score of a word.")
    if "image" in form.needs and "image" not in request.values:
        raise ParameterError(
            "This model needs a photograph: drop or paste one, choose a file, or use the camera."
        )
    if request.seconds is not None and request.seconds > LONGEST_S:
        raise ParameterError(
            f"Length must be at most {LONGEST_S:g} s, got {request.seconds:g}; use the command line for longer ones."
        )
    if not 1 <= request.count <= MOST_COUNT:
        raise ParameterError(f"Number of results must be 1 to {MOST_COUNT}, got {request.count}.")


def options_of(request: GenerationRequest, form: GenerationForm) -> dict[str, Any]:
    """Return the values of a request by option (`tactogram.model.condition_options`), in the order of the options."""
    options: dict[str, Any] = {}
    for name, one in condition_types().items():
        if not form.has(name) or not one.options:
            continue
        if name == "material":
            options |= {"mix": request.mix} if form.mixes else {"material": next(iter(request.mix), None)}
        else:
            options[one.options[0].name] = request.values.get(name)
    return {name: value for name, value in options.items() if value not in (None, {})}


def command(request: GenerationRequest, form: GenerationForm, *, image: str = "") -> str:
    """Return the equivalent command, to be run in the workspace; ``image`` is the file of the cropped photograph."""
    rest = form.has("words") and not form.some_words and set(form.words) - set(request.words)
    words = arguments(
        "generate",
        request.run,
        **options_of(request.changed(image=image) if image else request, form),
        rest="mean" if rest else "",
        seconds=request.seconds,
        seed=request.seed,
        count=request.count if request.count > 1 else None,
        out="made.png" if form.gives == "image" else "made.wav",
    )
    return command_line(words)


def word_label(word: str) -> str:
    """Return the label of a word: in English, and in Japanese if it is one of the ten."""
    return f"{word}  {JAPANESE[word]}" if word in JAPANESE else word


def _title_of(file: str) -> str:
    """Return the name of an uploaded file as it was before its hash was added."""
    return file.rpartition("/")[2].rpartition(".")[0].rpartition("-")[0]
