"""Kind of source: what a module of ``capture.sources`` declares as its ``SOURCE``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, get_args

from pydantic import BaseModel

from tactogram.errors import ParameterError
from tactogram_capture.source import Source


class OpenFunction(Protocol):
    """Function from the parts of an address to a source."""

    def __call__(self, place: str, options: Any, /, *, name: str) -> Source:
        """Return the source at the address ``name``, not entered yet.

        ``place`` is the part between the colon and the question mark; it may be empty. Raises `ParameterError` if the
        place or the options are wrong; devices are opened later, by entering the source.
        """
        ...


@dataclass(frozen=True)
class SourceKind:
    """A kind of source, addressed as ``name:place?option=value&…``."""

    name: str
    """Start of its addresses, equal to the module's name."""
    title: str
    example: str
    """An address."""
    options: type[BaseModel]
    """Options that are files have the type Path; ``log``, if present, is a new file for all bytes."""
    open: OpenFunction
    find: Callable[[float], Mapping[str, str]] | None = None
    """Returns the connected devices: descriptions by address. Its argument limits the search on a network, s."""
    place_is_file: bool = False
    simulated: bool = False

    def file_options(self) -> set[str]:
        """Return the names of the options that are files."""
        fields = self.options.model_fields.items()
        return {name for name, field in fields if Path in (field.annotation, *get_args(field.annotation))}


def required_place(place: str, name: str, what: str) -> str:
    """Return ``place``, the part of an address after the colon, or raise `ParameterError` if it is empty."""
    if not place:
        raise ParameterError(f"{name.rstrip(':')}: must name {what} after the colon")
    return place
