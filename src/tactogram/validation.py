"""Values from a file or a command line, checked against a typed description, or refused in one line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from tactogram.errors import ParameterError, shortened, shown

M = TypeVar("M", bound=BaseModel)


def validated(kind: type[M], values: Mapping[str, Any], *, where: str) -> M:
    """Return ``values`` as a ``kind``, or refuse them in one line that names the key."""
    try:
        return kind.model_validate(dict(values))
    except ValidationError as error:
        first = error.errors()[0]
        key = shortened(".".join(str(part) for part in first["loc"]))
        if first["type"] == "extra_forbidden":
            known = ", ".join(sorted(_keys_at(kind, first["loc"][:-1])))
            said = f"; known here: {known}" if known else ""
            raise ParameterError(f"{where}: unknown key {key!r}{said}") from None
        message = first["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
        if isinstance(first["input"], Mapping | BaseModel):
            # Of a whole table the message says what is wrong; its values would fill a page.
            raise ParameterError(": ".join(part for part in (where, key, message) if part)) from None
        raise ParameterError(f"{where}: {key}: {message}, got {shown(first['input'])}") from None


def with_changes(values: Mapping[str, Any], changes: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the tables of a file with other values by dotted key, such as ``{"prepare.rate": 2000}``.

    Raises
    ------
    ParameterError
        If a key leads through what is a value, not a table.
    """
    changed = dict(values)
    for key, value in (changes or {}).items():
        *tables, last = key.split(".")
        table = changed
        for name in tables:
            inner = table.get(name, {})
            if not isinstance(inner, Mapping):
                raise ParameterError(f"{key}: {name} is a value, not a table")
            table[name] = table = dict(inner)
        table[last] = value
    return changed


def _keys_at(kind: type[BaseModel], place: tuple[int | str, ...]) -> list[str]:
    """Return the keys of the table at a place; none where it may be one of several kinds."""
    fields = kind.model_fields
    for part in place:
        # What is no field is a key of a mapping or a place in a list, whose model was taken already.
        if str(part) in fields:
            inner = _models_in(fields[str(part)].annotation)
            if len(inner) != 1:
                return []
            fields = inner.pop().model_fields
    return list(fields)


def _models_in(annotation: Any) -> set[type[BaseModel]]:
    """Return the models within a type, as in ``dict[str, X] | None``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return {annotation}
    return {model for inner in get_args(annotation) for model in _models_in(inner)}
