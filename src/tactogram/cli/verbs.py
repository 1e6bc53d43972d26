"""Verbs: the fields of a request as options of the command line, and the function that runs it."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, Field
from types import NoneType, UnionType
from typing import Any, Literal, NamedTuple, get_args, get_origin

from tactogram.cli.folders import FOLDERS
from tactogram.cli.printing import Printer
from tactogram.errors import ParameterError, Remedy, with_remedies
from tactogram.workflows.request import Argument, Option, Request, declared


class Verb(NamedTuple):
    """A verb: its request, and the function that carries it out and returns an exit status."""

    request: type[Request]
    run: Callable[[Any, Printer], int | None]
    folders: tuple[str, ...] = ()
    """Names of the `FOLDERS` that it accepts."""
    listing: tuple[str, Callable[[Printer], None]] | None = None
    """Help and function of ``--list``, which needs no other option."""


class UsageError(Exception):
    """Options that do not go together; shown with the usage line, exit status 2."""


def add_options(parser: argparse.ArgumentParser, verb: Verb, *, listing: bool = False) -> None:
    """Add the options of a verb to its parser; only those of every verb for a command with ``--list``."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--quiet", action="store_true", help="show no progress")
    if verb.listing is not None:
        parser.add_argument("--list", action="store_true", help=verb.listing[0])
        if listing:
            return
    for folder in verb.folders:
        parser.add_argument(f"--{folder}", action="append", default=[], metavar="PATH", help=FOLDERS[folder])
    for field, option, kind in declared(verb.request):
        required = field.default is MISSING
        settings = _settings(option, kind, field.default)
        if isinstance(option, Argument):
            nargs = settings.get("nargs") or (None if required else "?")
            nargs = "*" if nargs == "+" and not required else nargs
            parser.add_argument(field.name, **settings | {"nargs": nargs})
        else:
            flags = _flag(field, option).split()
            parser.add_argument(*flags, dest=field.name, required=required, **settings)


def request_of(verb: Verb, arguments: argparse.Namespace) -> Request:
    """Return the request of parsed arguments; omitted ones have the request's defaults.

    Raises `ParameterError` if a value is not of its type, or out of bounds.
    """
    values = {}
    for field, option, kind in declared(verb.request):
        value = getattr(arguments, field.name)
        if value is not None:
            flag = _flag(field, option).split()[0]
            values[field.name] = _converted(value, _plain(kind), flag, str(option.metavar or "KEY=VALUE"))
    return verb.request(**values)


def flags_of(verb: Verb) -> dict[str, str]:
    """Return how the command line calls each parameter of a verb."""
    return {
        field.name: field.name if isinstance(option, Argument) else _flag(field, option).split()[0]
        for field, option, _ in declared(verb.request)
    }


def with_options(message: str, flags: Mapping[str, str]) -> str:
    """Return an error's message with options in place of the parameters that it names, as of `flags_of`.

    They are its remedies (`tactogram.errors.Remedy`), or begin the message and are followed by "must". A name with a
    value that is no option is one of those of ``--set``, if the verb has it. What a verb advises instead has the text
    of the remedy as its key in ``flags``, or ``rate=`` for any value.
    """
    flags = {**flags, "model_folders": "--models"}
    others = "--set {}={}" if "--set" in flags.values() else "{}={}"

    def option(remedy: Remedy) -> str:
        name, value = remedy.parameter, remedy.value
        if value is None:
            return flags.get(str(remedy), flags.get(name, str(remedy)))
        if advice := flags.get(str(remedy), flags.get(f"{name}=")):
            return advice
        text = str(value)
        if flags.get(name, "").startswith("-"):
            return f"`{flags[name]} {shlex.quote(text)}`"
        return f"`{others.format(name, text if ' ' not in text else shlex.quote(text))}`"

    message = with_remedies(message, option)
    return re.sub(r"^(\w+)(?= must)", lambda name: flags.get(name[1], name[0]), message)


def _flag(field: Field[Any], option: Option) -> str:
    return option.flag or f"--{field.name.replace('_', '-')}"


def _plain(kind: Any) -> Any:
    """Return a type without None; the first of several."""
    if isinstance(kind, UnionType):
        return next(one for one in get_args(kind) if one is not NoneType)
    return kind


def _settings(option: Option, kind: Any, default: Any) -> dict[str, Any]:
    """Return what ``add_argument`` needs for a parameter; ``default`` is MISSING where it is required."""
    plain = _plain(kind)
    origin, inner = get_origin(plain), get_args(plain)
    settings: dict[str, Any] = {"help": _help(option.help, default)}
    if isinstance(default, bool):
        return settings | {"action": "store_const", "const": not default}
    settings["metavar"] = option.metavar
    if option.const is not None:
        settings |= {"nargs": "?", "const": option.const}
    if plain is bool:
        settings["choices"] = ("on", "off")
    elif plain in (int, float):
        settings["type"] = plain
    elif origin is Literal:
        settings["choices"] = inner
    elif origin is Sequence and isinstance(option, Argument):
        settings["nargs"] = "+"
    elif origin in (Sequence, Mapping):
        settings["action"] = "append"
    elif origin is tuple and inner[-1] is not ...:
        settings |= {"nargs": len(inner), "type": inner[0]}
    return settings


def _help(text: str, default: Any) -> str:
    if isinstance(default, str | int | float) and not isinstance(default, bool) and default != "":
        shown = f"{default:g}" if isinstance(default, float) else default
        stated = f"default {shown}"
        if "default" not in text:
            text = f"{text} ({stated})" if text else stated
    return text.replace("%", "%%")


def _converted(value: Any, kind: Any, flag: str, form: str) -> Any:
    """Return a parsed value as its type; ``flag`` and ``form`` are for errors."""
    origin, inner = get_origin(kind), get_args(kind)
    if kind is bool:
        return value if isinstance(value, bool) else value == "on"
    if origin is Mapping:
        return mapping_of(value, inner[1], flag, form)
    if origin is tuple:
        return tuple_of(value, inner[0], flag) if inner[-1] is ... else tuple(value)
    return value


def mapping_of(texts: Sequence[str], kind: Any, flag: str, form: str) -> dict[str, Any]:
    """Return ``KEY=VALUE`` texts by key: numbers also separated by commas; values of any type are read as TOML."""
    if kind is Any:
        from tactogram.recipe import parse_changes

        return parse_changes(texts, option=flag)
    number = kind is float
    pairs: dict[str, Any] = {}
    for text in ",".join(texts).split(",") if number else texts:
        name, sign, value = text.rpartition("=") if number else text.partition("=")
        try:
            read = float(value) if number else value
        except ValueError:
            sign = ""
        name = name.strip()
        if not (sign and name):
            raise ParameterError(f"{flag} must be {form}, got {text!r}")
        if name in pairs:
            raise ParameterError(f"{flag} names {name!r} twice")
        pairs[name] = read
    return pairs


def tuple_of(text: str, kind: Any, flag: str) -> tuple[Any, ...]:
    """Return the parts of a text that commas separate; `ParameterError` if one is not of the ``kind``."""
    try:
        return tuple(kind(part.strip()) for part in text.split(",") if part.strip())
    except ValueError:
        numbers = "whole numbers" if kind is int else "numbers"
        raise ParameterError(f"{flag} needs {numbers} separated by commas, got {text!r}") from None
