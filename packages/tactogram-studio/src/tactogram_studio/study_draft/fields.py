"""Fields of the editor's forms, derived from the study's models: label, help, widget, default and choices."""

from __future__ import annotations

import math
import re
import types
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from tactogram_study.designs import Design
from tactogram_study.wording import Wording

Place = tuple[str | int, ...]
"""Keys of tables and indices of lists, from the top of the file."""
Widget = Literal["line", "texts", "number", "integer", "switch", "choice", "numbers"]
SIMPLE: Mapping[Any, Widget] = {
    Wording: "texts",
    bool: "switch",
    int: "integer",
    float: "number",
    str: "line",
}

LABELS: Mapping[str, str] = {
    "source": "Publication that is reproduced",
    "consent": "Consent text",
    "order": "Order of the trials",
    "rest_every": "Offer a rest after this many trials (0: never)",
    "instructions": "Text above each trial",
    "speed_mm_s": "Speed of the finger, mm/s",
    "low": "Lowest value",
    "high": "Highest value",
    "low_text": "Text at the lower end",
    "high_text": "Text at the upper end",
    "id": "Name in the tables of answers",
    "kind": "Kind of answer",
    "required": "Must be answered",
    "trials": "Trials of practice",
    "feedback": "Show after each answer whether it was right",
    "right": "After a right answer",
    "wrong": "After a wrong answer",
    "ended": "At the end of the practice",
    "seconds": "Length, s",
    "autoregressive": "Replace it by a signal from an autoregressive model of it",
    "reconstructed": "Convert it to a spectrogram and back",
    "count": "Number of items",
}
"""By the setting's key; other keys are shown with spaces."""
CHOICES: Mapping[str, Mapping[str, str]] = {
    "order": {
        "random": "all trials in one random order",
        "blocks": "each repeat in its own random order",
        "latin": "Latin square over participants",
        "williams": "Williams design over participants",
        "as-listed": "as listed",
    },
    "played_by": {
        "browser": "the participant's browser, as sound",
        "server": "a display at this machine",
        "stream": "a display at this machine, following the finger",
    },
    "kind": {
        "choice": "one of several options",
        "steps": "a scale of steps",
        "vas": "a line without marks",
        "number": "a number",
        "text": "free text",
    },
    "reconstructed": {"griffin_lim": "phase by Griffin-Lim", "phase_gradient": "phase by its gradient"},
}
"""By the setting's key and the value."""


@dataclass(frozen=True)
class StudyField:
    """A setting at a place in the study's values; ``default`` is as JSON, ``choices`` are titles by value."""

    place: Place
    label: str
    help: str
    widget: Widget
    default: Any = None
    choices: Mapping[str, str] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Its key in the table."""
        return str(self.place[-1])


def fields_of(
    model: type[BaseModel], place: Place = (), *, only: Collection[str] = (), skip: Collection[str] = ()
) -> list[StudyField]:
    """Return the fields of a model's plain settings and texts, in its order or that of ``only``.

    Lists of texts, tables and models are left out: they have forms of their own.
    """
    fields = []
    for name in only or model.model_fields:
        info = model.model_fields[name]
        widget, choices = _widget(info)
        if name in skip or widget is None:
            continue
        named = choices_of(model, name, choices)
        label, text = label_of(model, name), "" if named else help_of(model, name)
        text = "" if text.rstrip(".") == label else text
        fields.append(StudyField((*place, name), label, text, widget, _default(info), named))
    return fields


def _widget(info: FieldInfo) -> tuple[Widget | None, tuple[str, ...]]:
    kind = info.annotation
    if get_origin(kind) in (Union, types.UnionType):
        kind = next(inner for inner in get_args(kind) if inner is not type(None))
    if get_origin(kind) is Literal:
        choices = get_args(kind)
        return ("choice", choices) if len(choices) > 1 else (None, ())
    if get_origin(kind) is tuple and set(get_args(kind)) <= {float, int, Ellipsis}:
        return "numbers", ()
    return SIMPLE.get(kind), ()


def help_of(model: type[BaseModel], name: str) -> str:
    """Return the first sentence of a setting's description, without citations."""
    text = " ".join((model.model_fields[name].description or "").replace("`", "").split())
    text = re.sub(r" ?\((?:\[|Sec\.|Table)[^()]*\)", "", text)
    return re.split(r"(?<=\.) (?=[\[A-Z])", text)[0]


def _default(info: FieldInfo) -> Any:
    if info.is_required():
        return None
    value = info.get_default(call_default_factory=True)
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json", exclude_defaults=True)
    if isinstance(value, float) and math.isnan(value):
        return None
    return list(value) if isinstance(value, tuple) else value


def label_of(model: type[BaseModel], key: str) -> str:
    """Return a setting's label: the title of its field, if it has one."""
    field = model.model_fields.get(key)
    return (field and field.title) or LABELS.get(key) or key.replace("_", " ").capitalize()


def choices_of(model: type[BaseModel], key: str, values: Sequence[str]) -> dict[str, str]:
    """Return the titles of a setting's choices by value."""
    own = model.labels if issubclass(model, Design) else {}
    titles = CHOICES.get(key, {})
    return {value: own.get(f"{key}.{value}") or titles.get(value, value) for value in values}
