"""Verbs: functions whose options are their parameters, parsed by cyclopts, and the text of their result."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from importlib import import_module
from inspect import Parameter as Argument, Signature, signature
from pathlib import Path
from types import MappingProxyType, UnionType
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, Union, get_args, get_origin

from tactogram.cli.folders import FOLDERS, further_folders
from tactogram.cli.hints import with_options
from tactogram.cli.printing import Printer
from tactogram.errors import ParameterError

if TYPE_CHECKING:
    from tactogram.parameters import Parameter

SPELLING = {
    "changes": "--set",
    "columns": "--column",
    "constants": "--constant",
    "format": "--format --to",
    "how": "--as",
    "images": "--image",
    "margins": "--margin",
    "materials": "--material",
    "model_folders": "--models",
    "normal_force_n": "--force",
    "options": "--set",
    "purpose": "--for",
    "raters": "--rater --raters",
    "resample_to": "--resample",
    "tap_gain": "--tap",
}
"""Options that are not spelt like their parameters; a second spelling is another name."""
UNIT = re.compile(r"_(mm_s|mm|ms|min|hz|s|n|db)$")
"""End of a parameter's name, which its option leaves to the help."""


class UsageError(Exception):
    """Options that do not go together; shown with the usage line, exit status 2."""


class Verb(NamedTuple):
    """A verb: its function as ``module:name``, and the text of its result for people.

    A parameter ``progress`` of the function gets the progress bar, and ``show`` the `Printer`, for a verb that prints
    while it runs; a result of None is not printed. ``out`` is an option, wherever the function takes it.
    """

    function: str
    text: Callable[[Any], str]
    notes: Callable[[Any], Iterable[str]] = lambda result: ()
    """Lines for stderr."""
    folders: tuple[str, ...] = ()
    """Names of the `FOLDERS` that it accepts."""
    status: Callable[[Any], int] = lambda result: 0
    """Exit status of a result."""
    listing: tuple[str, Callable[[Printer], None]] | None = None
    """Help and function of ``--list``, which needs no other option."""
    advice: Mapping[str, str] = MappingProxyType({})
    """Advice instead of a remedy, by its text, or of any value of an argument (``rate=``)."""
    within: Callable[[], AbstractContextManager[Mapping[str, Any] | None]] = nullcontext
    """Context in which the function runs; it may yield further arguments of it, such as callbacks."""
    named: tuple[str, ...] = ()
    """Parameters that are options, although Python takes them by position, too."""
    facts: Callable[[Any], Any] = lambda result: result
    """JSON value of a result."""
    bare: tuple[str, ...] = ()
    """Options that may come without a value, which is empty then."""

    def load(self) -> Callable[..., Any]:
        """Import and return the function."""
        module, _, name = self.function.partition(":")
        function: Callable[..., Any] = getattr(import_module(module), name)
        return function


def run(words: str, verb: Verb, arguments: Sequence[str]) -> int:
    """Run a verb with the arguments of the command line; return its exit status, 2 for wrong usage."""
    from cyclopts import App, CycloptsError

    from tactogram.parameters import parameters, summary
    from tactogram.signal.io.atomic import check_writable

    function = verb.load()
    app = App(
        name=f"tactogram {words}",
        help_format="plaintext",
        version_flags=[],
        result_action="return_value",
        exit_on_error=False,
        print_error=False,
    )
    app["--help"].group = ""

    def call(*positional: Any, **options: Any) -> int:
        show = Printer(json=options.pop("json", False), quiet=options.pop("quiet", False))
        if options.pop("list", False) and verb.listing is not None:
            verb.listing[1](show)
            return 0
        kinds = {parameter.name: parameter.kind for parameter in parameters(function)}
        options = {name: converted(spelt(name), value, kinds.get(name)) for name, value in options.items()}
        further_folders({name: options.pop(name, ()) for name in verb.folders})
        # Refused before hours of work.
        if out := options.get("out"):
            check_writable(Path(out), folder=Path(out).is_dir())
        taken = signature(function).parameters
        if "show" in taken:
            options["show"] = show
        with verb.within() as further:
            options |= further or {}
            if "progress" in taken:
                with show.progress() as progress:
                    result = function(*positional, **options, progress=progress)
            else:
                result = function(*positional, **options)
        if result is None:
            return 0
        flags = flags_of(verb)
        show(verb.facts(result), verb.text(result))
        show.notes(with_options(note, flags) for note in verb.notes(result))
        return verb.status(result)

    listing = verb.listing is not None and "--list" in arguments
    call.__signature__ = options_of(  # type: ignore[attr-defined]
        None if listing else function,
        verb.folders,
        "" if verb.listing is None else verb.listing[0],
        named=verb.named,
    )
    call.__doc__, call.__annotations__ = summary(function), {}  # cyclopts reads the signature alone
    app.default(call)
    empty = {spelt(name) for name in verb.bare}
    try:
        return app([*_with_values(arguments, empty)]) or 0
    except (CycloptsError, UsageError) as error:
        sys.stderr.write(
            f"tactogram {words}: {str(error).rstrip('.')}; `tactogram {words} --help` lists its options\n"
        )
        return 2


def spelt(name: str) -> str:
    """Return the option of a parameter."""
    return _spellings(name)[0]


def _spellings(name: str) -> list[str]:
    return SPELLING.get(name, f"--{UNIT.sub('', name).replace('_', '-')}").split()


def flags_of(verb: Verb) -> dict[str, str]:
    """Return how the command line calls each parameter of a verb, and its advice."""
    from tactogram.parameters import parameters

    flags = {
        parameter.name: parameter.name if _by_place(parameter, verb.named) else spelt(parameter.name)
        for parameter in parameters(verb.load())
    }
    return flags | dict(verb.advice)


def options_of(
    function: Callable[..., Any] | None,
    folders: Sequence[str] = (),
    listing: str = "",
    *,
    named: Sequence[str] = (),
) -> Signature:
    """Return the signature that cyclopts parses: arguments by place, options by name, ``--json`` and ``--quiet``.

    ``function`` is None for ``--list``, whose help ``listing`` is.
    """
    from cyclopts import Parameter as CommandParameter

    from tactogram.parameters import parameters

    def argument(name: str, kind: Any, default: Any, text: str, *, positional: bool = False) -> Argument:
        negative = None if default is True else ()
        facts: dict[str, Any] = {"help": text, "negative": negative, "show_default": bool(default)}
        if not positional:
            facts["name"] = _spellings(name)
        usage = Argument.POSITIONAL_ONLY if positional else Argument.KEYWORD_ONLY
        return Argument(name, usage, default=default, annotation=Annotated[kind, CommandParameter(**facts)])

    arguments = [
        argument(
            parameter.name,
            str if parameter.kind is Any else _form(parameter.kind),
            parameter.default,
            parameter.text,
            positional=_by_place(parameter, named),
        )
        for parameter in (parameters(function) if function is not None else ())
    ]
    arguments += [argument(name, list[str], (), FOLDERS[name]) for name in folders]
    if listing:
        arguments.append(argument("list", bool, False, listing))
    arguments.append(argument("json", bool, False, "print one JSON object"))
    arguments.append(argument("quiet", bool, False, "show no progress"))
    return Signature(arguments)


def _by_place(parameter: Parameter, named: Sequence[str]) -> bool:
    return parameter.positional and parameter.name not in ("out", *named)


def _with_values(arguments: Sequence[str], bare: Container[str]) -> Iterator[str]:
    """Yield the arguments, with an empty value for options in ``bare`` that have none."""
    for word, after in zip(arguments, (*arguments[1:], "-"), strict=False):
        yield f"{word}=" if word in bare and after.startswith("-") else word


def _form(kind: Any) -> Any:
    """Return the type that cyclopts reads: texts of what is converted later and of paths, and no bounds."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return _form(inner[0])
    if origin in (Union, UnionType):
        several = [member for member in inner if get_origin(member) is Sequence]
        # A path would lose the slashes of a URL.
        texts = str in inner
        return Union[tuple(_form(member) for member in several or inner if member is not Path or not texts)]  # noqa: UP007
    if origin is Sequence:
        return list[_form(inner[0])]  # type: ignore[misc]
    return list[str] if _is_mapping(kind) else str if _is_list(kind) else kind


def converted(flag: str, value: Any, kind: Any) -> Any:
    """Return ``KEY=VALUE`` texts as a mapping, and a list separated by commas as a tuple; errors name the ``flag``."""
    if value is None:
        return None
    for member in get_args(kind) if get_origin(kind) in (Union, UnionType) else (kind,):
        if _is_mapping(member):
            return mapping_of(value, get_args(member)[1], flag, "KEY=VALUE")
        if _is_list(member):
            return tuple_of(value, get_args(member)[0], flag)
    return value


def _is_mapping(kind: Any) -> bool:
    origin = get_origin(kind)
    return isinstance(origin, type) and issubclass(origin, Mapping)


def _is_list(kind: Any) -> bool:
    return get_origin(kind) is tuple and get_args(kind)[-1] is ...


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
