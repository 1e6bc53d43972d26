"""Recipe form, built from the model's configuration: values, published ones, and what they mean."""

from __future__ import annotations

import ast
import inspect
import json
import textwrap
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from tactogram.errors import ParameterError
from tactogram.models import ModelInfo
from tactogram.recipe import Preparation, Recipe, TrainingSettings

Widget = Literal["switch", "choice", "integer", "number", "text"]


@dataclass(frozen=True)
class RecipeField:
    """One value of a recipe.

    Parameters
    ----------
    key : str
        Dotted, as ``--set`` takes it.
    value : JSON value
        What the recipe says, or the default.
    published : JSON value
        The default: of a model's configuration, the paper's.
    text : str
        What it means, and where it stands.
    widget : str
        How it is asked for.
    choices : tuple of str
        Of a ``choice``.
    """

    key: str
    value: Any
    published: Any
    text: str
    widget: Widget
    choices: tuple[str, ...] = ()

    def read(self, given: Any) -> Any:
        """Return what a widget gives as a value of the recipe.

        Raises
        ------
        ParameterError
            If it is none.
        """
        if self.widget == "integer" and given is not None:
            if float(given) != int(float(given)):
                raise ParameterError(f"{self.key} must be a whole number, got {given}")
            return int(float(given))
        if self.widget == "text":
            return parsed(given)
        return given


def settings_of(facts: ModelInfo, recipe: str) -> list[RecipeField]:
    """Return what can be changed: the seed, the preparation, the loop, and the model's configuration.

    Imports the model, and torch with it.
    """
    chosen = Recipe.load(facts.recipe(recipe))
    seed = RecipeField("seed", chosen.seed, 0, "The one seed of weights, batches and splits.", "integer")
    config = facts.config_class()
    return [
        seed,
        *_fields(Preparation, chosen.prepare.model_dump(mode="json"), "prepare"),
        *_fields(TrainingSettings, chosen.training.model_dump(mode="json"), "training"),
        *_fields(config, facts.config(chosen.config).model_dump(mode="json"), "config"),
    ]


def assignments(settings: list[RecipeField], given: Mapping[str, Any]) -> list[str]:
    """Return ``KEY=VALUE`` of each setting that was changed, as ``--set`` takes it.

    Parameters
    ----------
    settings : list of Setting
    given : mapping
        What widgets give, by key; keys that are no setting are left out.

    Raises
    ------
    ParameterError
        If a value cannot be read.
    """
    found = []
    for setting in settings:
        if setting.key not in given:
            continue
        value = setting.read(given[setting.key])
        if value is not None and value != setting.value:
            found.append(f"{setting.key}={json.dumps(value, ensure_ascii=False)}")
    return found


def shown(value: Any) -> str:
    """Return a value as a text field shows it."""
    return "" if value is None else json.dumps(value, ensure_ascii=False)


def parsed(text: str | None) -> Any:
    """Return what a text field holds: a TOML value, else the text; nothing is None."""
    text = (text or "").strip()
    if not text:
        return None
    try:
        return tomllib.loads(f"x = {text}")["x"]
    except tomllib.TOMLDecodeError:
        return text


def _fields(model: type[BaseModel], values: Mapping[str, Any], prefix: str) -> list[RecipeField]:
    texts = described(model)
    found: list[RecipeField] = []
    for name, field in model.model_fields.items():
        key, value = f"{prefix}.{name}", values[name]
        inner = field.annotation
        if isinstance(inner, type) and issubclass(inner, BaseModel):
            found += _fields(inner, value, key)
            continue
        default = field.get_default(call_default_factory=True)
        if isinstance(default, tuple):
            default = list(default)
        widget, choices = _widget(field)
        found.append(RecipeField(key, value, default, texts.get(name, ""), widget, choices))
    return found


def _widget(field: FieldInfo) -> tuple[Widget, tuple[str, ...]]:
    kind = field.annotation
    if kind is bool:
        return "switch", ()
    if kind is int:
        return "integer", ()
    if kind is float:
        return "number", ()
    if get_origin(kind) is Literal and all(isinstance(choice, str) for choice in get_args(kind)):
        return "choice", get_args(kind)
    return "text", ()


def described(model: type[BaseModel]) -> dict[str, str]:
    """Return the string below each field of a class, inherited ones included, as one line each."""
    found: dict[str, str] = {}
    for kind in reversed(model.__mro__):
        if kind is BaseModel or not issubclass(kind, BaseModel):
            continue
        try:
            tree = ast.parse(textwrap.dedent(inspect.getsource(kind)))
        except (OSError, TypeError, SyntaxError):
            continue
        [body] = [node.body for node in tree.body if isinstance(node, ast.ClassDef)]
        for field, after in pairwise(body):
            if (
                isinstance(field, ast.AnnAssign)
                and isinstance(field.target, ast.Name)
                and isinstance(after, ast.Expr)
                and isinstance(after.value, ast.Constant)
                and isinstance(after.value.value, str)
            ):
                found[field.target.id] = " ".join(after.value.value.split())
    return found
