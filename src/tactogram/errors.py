"""Errors raised on purpose: what was expected, what was found, what to do."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Callable, Iterable
from pathlib import PurePath
from typing import NamedTuple, Self

MOST_VALUE = 80
"""Characters of a value that a message repeats at most."""
MOST_MESSAGE = 1000
_LONG_VALUE = re.compile(r"""(?<!\w)(?:'.{200,}?'|".{200,}?"|\[.{200,}?\]|\{.{200,}?\}|\d{200,})(?!\w)""")
_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 4 * MOST_VALUE
_REPR.maxlist = _REPR.maxtuple = _REPR.maxdict = MOST_VALUE // 2
_ABSENT = object()


class TactogramError(Exception):
    """Root of the errors raised on purpose; the command line prints one line for it and exits 1.

    Where an argument is wrong (`ParameterError.must`), ``parameter`` is its name, ``value`` what it was, ``expected``
    completes "must …", ``choices`` are the values that are known, if these are few, and ``remedy`` says what to do:
    each face of the package names the parameter in its own words.
    """

    def __init__(
        self,
        *args: object,
        parameter: str = "",
        value: object = None,
        expected: str = "",
        remedy: str = "",
        choices: Iterable[str] = (),
    ) -> None:
        super().__init__(*args)
        self.parameter, self.value, self.expected, self.remedy = parameter, value, expected, remedy
        self.choices = tuple(choices)

    def __str__(self) -> str:
        """Return the message as one printable line, with long values shortened."""
        message = re.sub(r"\s*[\n\r]\s*", " ", super().__str__())
        return printable(shortened(_LONG_VALUE.sub(lambda value: shortened(value[0]), message), MOST_MESSAGE))


class Remedy(NamedTuple):
    """An argument that a message names: to give it ``value``, or of None to mind it or omit it.

    Its text is part of messages, errors and notes alike, and survives in reports and stores. Python shows it as it is;
    another face of the package renders it in its own words (`with_remedies`).

    >>> f"no rate in the file; give it, {Remedy('rate', 1000)}"
    'no rate in the file; give it, `rate=1000`'
    """

    parameter: str
    value: object = None

    def __str__(self) -> str:
        """Return the remedy as `REMEDY` finds it in a message."""
        return f"`{self.parameter}`" if self.value is None else f"`{self.parameter}={self.value}`"


REMEDY = re.compile(r"`(\w+)(?:=([^`]+))?`")


def remedies_in(message: str) -> tuple[Remedy, ...]:
    """Return the remedies that a message names, in their order."""
    return tuple(Remedy(*found.groups()) for found in REMEDY.finditer(message))


def with_remedies(message: str, render: Callable[[Remedy], str]) -> str:
    """Return a message with its remedies in the words of ``render``."""
    return REMEDY.sub(lambda found: render(Remedy(*found.groups())), message)


class ParameterError(TactogramError, ValueError):
    """An argument is outside the range for which the function is defined."""

    @classmethod
    def must(
        cls,
        parameter: str,
        expected: str,
        value: object = _ABSENT,
        *,
        remedy: str = "",
        choices: Iterable[str] = (),
    ) -> Self:
        """Return the error of an argument that must ``expected``, e.g. "be at least 1"; its value is shown if given.

        >>> str(ParameterError.must("count", "be at least 1", 0, remedy="omit it for one"))
        'count must be at least 1, got 0; omit it for one'
        """
        got = "" if value is _ABSENT else f", got {shown(value)}"
        return cls(
            f"{parameter} must {expected}{got}{remedy and f'; {remedy}'}",
            parameter=parameter,
            value=None if value is _ABSENT else value,
            expected=expected,
            remedy=remedy,
            choices=choices,
        )

    @classmethod
    def one_of(cls, parameter: str, choices: Iterable[str], value: object, *, remedy: str = "") -> Self:
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
