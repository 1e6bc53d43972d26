"""Errors raised on purpose: what was expected, what came, what to do."""

from __future__ import annotations

import re
import reprlib

MOST_VALUE = 80
"""Characters of a value that a message repeats."""
MOST_MESSAGE = 1000
_LONG_VALUE = re.compile(r"""(?<!\w)(?:'.{200,}?'|".{200,}?"|\[.{200,}?\]|\{.{200,}?\}|\d{200,})(?!\w)""")
_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 4 * MOST_VALUE
_REPR.maxlist = _REPR.maxtuple = _REPR.maxdict = MOST_VALUE // 2


class TactogramError(Exception):
    """Root of the errors raised on purpose; the command line prints one line for it and exits 1."""

    def __str__(self) -> str:
        """Return the message in one line, without what is long in the values that it repeats."""
        message = re.sub(r"\s*[\n\r]\s*", " ", super().__str__())
        return shortened(_LONG_VALUE.sub(lambda found: shortened(found[0]), message), MOST_MESSAGE)


class ParameterError(TactogramError, ValueError):
    """An argument is outside what the function is defined for."""


class FailedTrainingError(ParameterError):
    """The request needs networks whose training failed by the model's own rule."""


class UnitError(TactogramError, ValueError):
    """A quantity has another unit than the operation needs."""


class DataError(TactogramError):
    """A file or a data set is broken or not what it claims to be; the message names file and place."""


class LeakError(TactogramError):
    """The same recording would stand on both sides of a split."""


class RunError(TactogramError):
    """A run folder is missing, broken, unfinished, or of another version."""


class StoppedError(TactogramError):
    """A training ended before its end because it was asked to; what it had learned is kept in its checkpoint."""


class MissingExtraError(TactogramError, ImportError):
    """An optional dependency is not installed; the message names the extra that brings it."""


class DeviceError(TactogramError):
    """A device or its driver is not there, did not open, or stopped answering; the message names it."""


def shown(value: object) -> str:
    """Return a value as a message repeats it, without reading through all that is in it."""
    return shortened(_REPR.repr(value))


def shortened(text: str, most: int = MOST_VALUE) -> str:
    """Return a text without its middle where it has more than ``most`` characters."""
    return text if len(text) <= most else f"{text[: most * 2 // 3]} … {text[-(most // 3 - 3) :]}"
