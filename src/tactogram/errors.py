"""Errors raised on purpose: what was expected, what was found, what to do."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePath
from types import MappingProxyType
from typing import Self, SupportsIndex

MOST_VALUE = 80
"""Characters of a value that a message repeats at most."""
MOST_MESSAGE = 1000
_LONG_VALUE = re.compile(r"""(?<!\w)(?:'.{200,}?'|".{200,}?"|\[.{200,}?\]|\{.{200,}?\}|\d{200,})(?!\w)""")
_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 4 * MOST_VALUE
_REPR.maxlist = _REPR.maxtuple = _REPR.maxdict = MOST_VALUE // 2
_ABSENT = object()


@dataclass(frozen=True)
class Remedy:
    """Advice that ends with an argument: to give it ``value``, or of None to mind or omit it.

    >>> print(Remedy("give it, e.g.", "rate", 1000), "or", Remedy("omit", "time"))
    give it, e.g. `rate=1000` or omit `time`
    """

    advice: str
    parameter: str = ""
    value: object = None

    def __str__(self) -> str:
        """Return the advice in words of Python."""
        return f"{self.advice} {self.argument}".strip()

    @property
    def argument(self) -> str:
        """The argument as Python takes it, in backquotes; empty if there is none."""
        value = "" if self.value is None else f"={self.value}"
        return self.parameter and f"`{self.parameter}{value}`"


class Message(str):
    """One line on a file or an argument: a text in words of Python, whose parts other faces put in their own.

    It is a text, so that errors, notes and reports carry it, also through JSON, which keeps the text alone.

    >>> Message("no rate in it", Remedy("give it, e.g.", "rate", 1000), place="a.csv")
    'a.csv: no rate in it; give it, e.g. `rate=1000`'
    """

    problem: str
    remedies: tuple[Remedy, ...]
    place: str
    """File, with row and column, or what else the problem is in."""
    parameter: str
    """Argument that the problem is about, its subject."""

    def __new__(
        cls, problem: object, *remedies: Remedy | str, place: object = "", parameter: str = ""
    ) -> Self:
        """Return the message; the ``problem`` may be one, of which ``place`` is another, or the same, place."""
        outer = _tidy(str(place))
        advice = tuple(Remedy(each) if isinstance(each, str) else each for each in remedies)
        if isinstance(problem, Message):
            outer = ": ".join(filter(None, (outer, problem.place_in(outer))))
            advice, parameter = (*problem.remedies, *advice), problem.parameter
            problem = problem.problem
        text = _tidy(str(problem))
        self = super().__new__(cls, _joined(outer, parameter, text, map(str, advice)))
        self.problem, self.remedies, self.place, self.parameter = text, advice, outer, parameter
        return self

    def __getnewargs_ex__(self) -> tuple[tuple[object, ...], dict[str, str]]:
        """Return the parts, to copy and pickle it."""
        return (self.problem, *self.remedies), {"place": self.place, "parameter": self.parameter}

    def place_in(self, outer: object) -> str:
        """Return the place in an ``outer`` one, such as the row in a file, without that."""
        return f"{self.place}: ".removeprefix(f"{outer}: ").removesuffix(": ")

    def within(self, outer: object) -> Message:
        """Return the message without a file or other place of which its readers know that it is about it."""
        place = self.place_in(outer)
        return Message(self.problem, *self.remedies, place=place, parameter=self.parameter)

    def replace(self, old: str, new: str, count: SupportsIndex = -1, /) -> Message:
        """Return the message with another text, such as a shorter path, in its place and problem."""
        place, problem = self.place.replace(old, new, count), self.problem.replace(old, new, count)
        return Message(problem, *self.remedies, place=place, parameter=self.parameter)

    def in_words(
        self, remedy: Callable[[Remedy], str], names: Mapping[str, str] = MappingProxyType({})
    ) -> str:
        """Return the line with each remedy as a face of the package says it, and its name of the parameter."""
        name = names.get(self.parameter, self.parameter)
        return _joined(self.place, name, self.problem, map(remedy, self.remedies))


class TactogramError(Exception):
    """Root of the errors raised on purpose; the command line prints one line for it and exits 1.

    The arguments are the problem, or the place (file, row and column) and the problem, which may be another error
    whose place and remedies it keeps. Where an argument is wrong (`ParameterError.must`), ``parameter`` is its name,
    ``value`` what it was, ``expected`` completes "must …", and ``choices`` are the values that are known, if these are
    few. ``remedy`` says what to do, once or in several ways. Each face of the package says these in its own words, from
    the parts of ``message``.
    """

    def __init__(
        self,
        *args: object,
        parameter: str = "",
        value: object = None,
        expected: str = "",
        remedy: str | Remedy | Sequence[Remedy] = "",
        choices: Iterable[str] = (),
    ) -> None:
        super().__init__(*args)
        self.parameter, self.value, self.expected, self.remedy = parameter, value, expected, remedy
        self.choices = tuple(choices)
        place, problem = args if len(args) == 2 else ("", args[0] if args else "")
        remedies = (remedy,) if isinstance(remedy, (str, Remedy)) else remedy
        self.message: Message = Message(
            problem.message if isinstance(problem, TactogramError) else problem,
            *(each for each in remedies if each),
            place=place,
            parameter=parameter,
        )

    def __str__(self) -> str:
        """Return the message as one printable line, with long values shortened."""
        return str(self.message)


class ParameterError(TactogramError, ValueError):
    """An argument is outside the range for which the function is defined."""

    @classmethod
    def must(
        cls,
        parameter: str,
        expected: str,
        value: object = _ABSENT,
        *,
        remedy: str | Remedy = "",
        choices: Iterable[str] = (),
    ) -> Self:
        """Return the error of an argument that must ``expected``, e.g. "be at least 1"; its value is shown if given.

        >>> str(ParameterError.must("count", "be at least 1", 0, remedy="omit it for one"))
        'count must be at least 1, got 0; omit it for one'
        """
        got = "" if value is _ABSENT else f", got {shown(value)}"
        return cls(
            f"must {expected}{got}",
            parameter=parameter,
            value=None if value is _ABSENT else value,
            expected=expected,
            remedy=remedy,
            choices=choices,
        )

    @classmethod
    def one_of(
        cls, parameter: str, choices: Iterable[str], value: object, *, remedy: str | Remedy = ""
    ) -> Self:
        """Return the error of an argument that is none of the known ones."""
        known = tuple(map(str, choices))
        return cls.must(parameter, f"be one of {', '.join(known)}", value, remedy=remedy, choices=known)


class FailedTrainingError(ParameterError):
    """The request needs networks that failed the model's own training criterion."""


class UnitError(TactogramError, ValueError):
    """A quantity has another unit than the operation needs."""


class DataError(TactogramError):
    """A file or data set is damaged or of another kind; the message names file and place."""


class LeakError(TactogramError):
    """The same recording would be in two parts of a split."""


class RunError(TactogramError):
    """A run folder is missing, damaged, unfinished, or of another version."""


class StoppedError(TactogramError):
    """A training was stopped on request; its checkpoint holds its state."""


class MissingExtraError(TactogramError, ImportError):
    """An optional dependency is not installed; the message names the extra that contains it."""


class DeviceError(TactogramError):
    """A device or its driver is missing, did not open, or stopped responding; the message names it."""


class MissingDriverError(DeviceError):
    """The driver that a library needs for a device is missing."""


def remedies_of(message: str) -> tuple[Remedy, ...]:
    """Return the remedies of a `Message`; a plain text has none."""
    return message.remedies if isinstance(message, Message) else ()


def _tidy(text: str) -> str:
    """Return a text as one printable line, with long values shortened."""
    line = re.sub(r"\s*[\n\r]\s*", " ", text)
    return printable(_LONG_VALUE.sub(lambda value: shortened(value[0]), line))


def _joined(place: str, parameter: str, problem: str, remedies: Iterable[str]) -> str:
    """Return a message of its parts."""
    subject = "".join((place and f"{place}: ", parameter and f"{parameter} "))
    advice = ", or ".join(remedies)
    joint = " " if problem.endswith("?") else "; "
    return shortened(f"{subject}{problem}{advice and joint + advice}", MOST_MESSAGE)


def shown(value: object) -> str:
    """Return a short representation of a value for a message, without formatting all of it."""
    if isinstance(value, PurePath):
        return shortened(str(value))
    return f"{value:g}" if isinstance(value, float) else shortened(_REPR.repr(value))


def shortened(text: str, most: int = MOST_VALUE) -> str:
    """Return a text without its middle if it has more than ``most`` characters."""
    return text if len(text) <= most else f"{text[: most * 2 // 3]} … {text[-(most // 3 - 3) :]}"


def one_line(error: BaseException) -> str:
    """Return an error's message in one line of at most 200 characters, or its type if it has none."""
    # Some libraries raise a text and a number, which str() would show as a pair.
    message = ", ".join(map(str, error.args)) if str(error).startswith("(") else str(error)
    text = " ".join(message.split()) or type(error).__name__
    return text if len(text) <= 200 else f"{text[:197]}..."


def printable(text: str) -> str:
    r"""Return a text with bytes that are not UTF-8, as a file name may have, written as ``\udcff``."""
    return text.encode("utf-8", "backslashreplace").decode()
