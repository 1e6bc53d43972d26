"""Sources by address, found by looking into the folder ``capture.sources`` and further ones."""

from __future__ import annotations

from typing import Annotated, Any
from urllib.parse import parse_qsl

from annotated_types import Ge
from pydantic import BaseModel

from tactogram.errors import DeviceError, MissingExtraError, ParameterError
from tactogram.parameters import checked
from tactogram.plugins import PluginGroup
from tactogram.validation import validated
from tactogram_capture.source import Source, SourceKind

SOURCES = PluginGroup("capture source", "tactogram_capture.sources", "tactogram.sources", "TACTOGRAM_SOURCES")
"""Modules with a ``SOURCE``, a `SourceKind`."""


def source_kind(name: str) -> SourceKind:
    """Return a kind of source by name; `ParameterError` if there is none, or its module declares none."""
    return SOURCES.definition(name, "SOURCE", SourceKind)


def find_devices(name: str, *, find_s: float = 0.5) -> dict[str, str]:
    """Return the connected devices of a kind: descriptions by address.

    Raises `ParameterError` if there is no such kind, or its devices cannot be listed; `MissingExtraError` or
    `DeviceError` if its library or driver is not installed.
    """
    kind = source_kind(name)
    if kind.find is None:
        raise ParameterError(f"sources of kind {name} cannot be listed; use an address like {kind.example}")
    return dict(kind.find(find_s))


def open_source(address: str) -> Source:
    """Return the source at an address; entering it as a context opens the device.

    ``address``: ``twelite:/dev/ttyUSB0``, ``serial:COM3?baud=230400&unit=g``, ``lsl:NAME``, ``audio:NAME``,
    ``ni:Dev1/ai0:2?rate=10000``, ``digilent:``, ``log:FILE``, ``simulated:twelite?loss=0.02&rate=330``. The options of
    each kind are the fields of its `SourceKind.options`.

    Raises `ParameterError` if it is not an address, or an option is wrong.
    """
    kind, place, options = parse_address(address)
    return kind.open(place, options, name=address)


def parse_address(address: str) -> tuple[SourceKind, str, BaseModel]:
    """Return kind, place and options of an address; `ParameterError` if one of them is wrong."""
    name, colon, rest = address.partition(":")
    if not colon or name not in SOURCES:
        examples = ", ".join(source_kind(known).example for known in SOURCES.names())
        raise ParameterError(f"a source must be one of {examples}; got {address!r}")
    place, _, query = rest.partition("?")
    pairs = parse_qsl(query.replace("+", "%2B"), keep_blank_values=True)
    if query and len(pairs) != len(query.split("&")):
        raise ParameterError(f"{address}: options must be like rate=330&loss=0.02, got {query!r}")
    values = dict(pairs)
    if len(values) != len(pairs):
        raise ParameterError(f"{address}: each option may be given once, got {query!r}")
    if any("\0" in text for text in (place, *values.values())):
        raise ParameterError(f"a source's address must not contain a null character, got {address!r}")
    kind = source_kind(name)
    return kind, place, validated(kind.options, values, where=address)


@checked
def find_sources(*, find_s: Annotated[float, Ge(0)] = 0.5) -> list[dict[str, Any]]:
    """List the sources that can be recorded from, and what each lacks.

    Parameters
    ----------
    find_s : float
        Time to search for streams on the network, s.

    Returns
    -------
    list of dict
        ``kind``, ``address`` (for `open_source`; None if there is no device), ``what``, ``missing``
        (what to install; None otherwise) and ``simulated``.
    """
    sources: list[dict[str, Any]] = []
    for kind in map(source_kind, SOURCES.names()):
        if kind.find is None:
            continue
        common = {"kind": kind.name, "simulated": kind.simulated}
        try:
            addresses = find_devices(kind.name, find_s=find_s)
        except (MissingExtraError, DeviceError) as error:
            sources.append({**common, "address": None, "what": kind.title, "missing": str(error)})
            continue
        sources += [{**common, "address": a, "what": what, "missing": None} for a, what in addresses.items()]
        if not addresses:
            sources.append({**common, "address": None, "what": f"no {kind.title}", "missing": None})
    return sources
