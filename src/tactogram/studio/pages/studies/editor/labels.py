"""Labels of a study's settings and their choices in the editor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from tactogram.study.designs import Design
from tactogram.text_files import read_toml

TEXTS: Mapping[str, Mapping[str, Any]] = read_toml(Path(__file__).with_name("labels.toml"))


def label_of(model: type[BaseModel], key: str) -> str:
    """Return a setting's label: that of its design, if it has one."""
    return _own(model).get(key) or TEXTS["labels"].get(key) or key.replace("_", " ").capitalize()


def choices_of(model: type[BaseModel], key: str, values: Sequence[str]) -> dict[str, str]:
    """Return the titles of a setting's choices by value."""
    own, titles = _own(model), TEXTS["choices"].get(key, {})
    return {value: own.get(f"{key}.{value}") or titles.get(value, value) for value in values}


def _own(model: type[BaseModel]) -> Mapping[str, str]:
    return model.labels if issubclass(model, Design) else {}
