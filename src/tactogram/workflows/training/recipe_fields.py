"""Settings of a recipe, derived from the model's configuration: value, published value, description and widget."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from tactogram.errors import ParameterError
from tactogram.models import ModelInfo
from tactogram.recipe import Preparation, Recipe, TrainingSettings

Widget = Literal["switch", "choice", "integer", "number", "text"]


@dataclass(frozen=True)
class RecipeField:
    """A setting of a recipe by its dotted key, with the widget that edits it.

    ``published`` is the default: for a model's configuration, the paper's value.
    """

    key: str
    value: Any
    published: Any
    text: str
    widget: Widget
    choices: tuple[str, ...] = ()

    def read(self, entry: Any) -> Any:
        """Return the recipe's value for a widget's entry; raise `ParameterError` for a fraction in an integer field."""
        if self.widget == "integer" and entry is not None:
            if float(entry) != int(float(entry)):
                raise ParameterError(f"{self.key} must be a whole number, got {entry}")
            return int(float(entry))
        if self.widget == "text":
            return parse_text(entry)
        return entry


def recipe_fields(facts: ModelInfo, recipe: str) -> list[RecipeField]:
    """Return the settings that can be changed: seed, preparation, training loop, and the model's configuration.

    Imports the model, and torch with it.
    """
    chosen = Recipe.load(facts.recipe(recipe))
    seed = RecipeField("seed", chosen.seed, 0, "Seed of weights, batches and splits.", "integer")
    config = facts.config_class()
    return [
        seed,
        *_fields(Preparation, chosen.prepare.model_dump(mode="json"), "prepare"),
        *_fields(TrainingSettings, chosen.training.model_dump(mode="json"), "training"),
        *_fields(config, facts.config(chosen.config).model_dump(mode="json"), "config"),
    ]


def assignments(fields: list[RecipeField], entries: Mapping[str, Any]) -> list[str]:
    """Return ``KEY=VALUE`` for each changed setting, as in ``--set``; entries with unknown keys are ignored."""
    changed = []
    for field in fields:
        if field.key not in entries:
            continue
        value = field.read(entries[field.key])
        if value is not None and value != field.value:
            changed.append(f"{field.key}={json.dumps(value, ensure_ascii=False)}")
    return changed


def text_of(value: Any) -> str:
    """Return the content of a text field for a value; the inverse of `parse_text`."""
    return "" if value is None else json.dumps(value, ensure_ascii=False)


def parse_text(text: str | None) -> Any:
    """Return the value of a text field: TOML if it parses, else the text itself; None if empty."""
    text = (text or "").strip()
    if not text:
        return None
    try:
        return tomllib.loads(f"x = {text}")["x"]
    except tomllib.TOMLDecodeError:
        return text


def _fields(model: type[BaseModel], values: Mapping[str, Any], prefix: str) -> list[RecipeField]:
    fields: list[RecipeField] = []
    for name, field in model.model_fields.items():
        key, value = f"{prefix}.{name}", values[name]
        inner = field.annotation
        if isinstance(inner, type) and issubclass(inner, BaseModel):
            fields += _fields(inner, value, key)
            continue
        default = field.get_default(call_default_factory=True)
        if isinstance(default, tuple):
            default = list(default)
        widget, choices = _widget(field)
        text = " ".join((field.description or "").split())
        fields.append(RecipeField(key, value, default, text, widget, choices))
    return fields


def _widget(field: FieldInfo) -> tuple[Widget, tuple[str, ...]]:
    kind = field.annotation
    if get_origin(kind) is Literal and all(isinstance(choice, str) for choice in get_args(kind)):
        return "choice", get_args(kind)
    simple: dict[Any, Widget] = {bool: "switch", int: "integer", float: "number"}
    return simple.get(kind, "text"), ()
