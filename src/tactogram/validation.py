"""Validation of values from a file or a command line against a typed description, with errors of one line."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError

from tactogram.errors import DataError, ParameterError, TactogramError, shortened, shown

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

M = TypeVar("M", bound=BaseModel)
T = TypeVar("T")


class FrozenModel(BaseModel):
    """Values that are checked once, on construction: frozen, and without unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class DescribedModel(FrozenModel):
    """As `FrozenModel`, with the docstrings below its fields as their descriptions, for forms and help."""

    model_config = ConfigDict(use_attribute_docstrings=True)


@dataclass(frozen=True)
class Fault:
    """A wrong value: its place as keys and indices, and the sentence that `validated` raises for it."""

    place: tuple[int | str, ...]
    sentence: str
    kind: str = ""
    """pydantic's type of the error, such as ``"dict_type"``."""


class FaultError(ParameterError):
    """Faults that a validator of a whole table finds within it; the message is that of the first."""

    def __init__(self, *faults: Fault) -> None:
        super().__init__(faults[0].sentence)
        self.args = self.faults = faults


def validated(kind: type[M], values: object, *, where: str) -> M:
    """Return ``values`` as a ``kind``; the `ParameterError` names the key."""
    try:
        return kind.model_validate(dict(values) if isinstance(values, Mapping) else values)
    except ValidationError as error:
        first = error.errors()[0]
        unknown = first["type"] == "extra_forbidden"
        known = _keys_at(kind, first["loc"][:-1]) if unknown else ()
        value = str(first["loc"][-1]) if unknown else first["input"]
        raise ParameterError(_sentence(kind, first, where), value=value, choices=known) from None


_adapter: Callable[[Any], TypeAdapter[Any]] = cache(TypeAdapter)


def facts_of(kind: type[T], values: object, *, where: object, remedy: str = "") -> T:
    """Return what this package wrote into a file as a ``kind``, such as a dataclass; the `DataError` names the key."""
    try:
        value: T = _adapter(kind).validate_python(values)
    except ValidationError as error:
        raise DataError(where, _sentence(BaseModel, error.errors()[0], ""), remedy=remedy) from None
    return value


def faults(kind: type[BaseModel], values: Mapping[str, Any], *, where: str) -> tuple[Fault, ...]:
    """Return every fault of ``values`` as a ``kind``, that of `validated` first."""
    try:
        kind.model_validate(dict(values))
    except ValidationError as error:
        return tuple(fault for detail in error.errors() for fault in _faults(kind, detail, where))
    return ()


def _faults(kind: type[BaseModel], error: ErrorDetails, where: str) -> Iterator[Fault]:
    cause = error.get("ctx", {}).get("error")
    if isinstance(cause, FaultError):
        for fault in cause.faults:
            location = (*error["loc"], *fault.place)
            yield Fault(location, _joined(where, _dotted(error["loc"]), fault.sentence), error["type"])
    else:
        location = error["loc"] or (place_of(cause, kind) if isinstance(cause, TactogramError) else ())
        yield Fault(location, _sentence(kind, error, where), error["type"])


def place_of(error: TactogramError, kind: type[BaseModel]) -> tuple[str, ...]:
    """Return the keys that an error names as its place or parameter, if the first is one of ``kind``; else none."""
    keys = tuple((error.message.place or error.parameter).split("."))
    return keys if keys[0] in kind.model_fields else ()


def _dotted(location: tuple[int | str, ...]) -> str:
    return shortened(".".join(map(str, location)))


def _sentence(kind: type[BaseModel], error: ErrorDetails, where: str) -> str:
    key = _dotted(error["loc"])
    if error["type"] == "extra_forbidden":
        known = ", ".join(sorted(_keys_at(kind, error["loc"][:-1])))
        hint = f"; known here: {known}" if known else ""
        return _joined(where, f"unknown key {key!r}{hint}")
    # Our validators raise the cause; the other sentences are pydantic's.
    message = str(error.get("ctx", {}).get("error") or _plain(error["msg"]))
    if isinstance(error["input"], Mapping | BaseModel):
        # A whole table is not repeated in the message: it would fill a page.
        return _joined(where, key, message)
    return _joined(where, key, f"{message}, got {shown(error['input'])}")


def _plain(sentence: str) -> str:
    """Return a sentence of pydantic's in our words."""
    sentence = re.sub(r"a (valid )?(dictionary|mapping).*", "a table", sentence)
    sentence = re.sub(r"^Input should be (a valid list|a valid tuple)$", "must be a list", sentence)
    return sentence.replace("Input should be", "must be").replace("Field required", "is missing")


def _joined(*parts: str) -> str:
    return ": ".join(part for part in parts if part)


def with_changes(values: Mapping[str, Any], changes: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the tables of a file with some values replaced by dotted key, such as ``{"prepare.rate": 2000}``."""
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


def _keys_at(kind: type[BaseModel], location: tuple[int | str, ...]) -> list[str]:
    """Return the keys of the table at a place; none if it may be of several kinds."""
    fields = kind.model_fields
    for part in location:
        # Other parts are keys of a mapping or indices of a list, whose model was entered already.
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
