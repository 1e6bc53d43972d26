"""Messages in words of the command line: options, nearest names, and the user's command with what it lacks."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from difflib import get_close_matches

from tactogram.errors import Remedy, TactogramError, with_remedies

ADDITION = re.compile(r"`(--[\w-]+) ('[^'`]+'|[^`\s]+)`")


def in_words(error: TactogramError, flags: Mapping[str, str], words: Sequence[str]) -> str:
    """Return the message of an error for the user of a command: options, the nearest name, and the command with more.

    ``flags`` are those of `tactogram.cli.verbs.flags_of`, ``words`` the command.
    """
    message = str(error)
    if error.parameter in flags and message.startswith(f"{error.parameter} "):
        message = flags[error.parameter] + message.removeprefix(error.parameter)
    return with_nearest(with_command(with_options(message, flags), words), error)


def with_nearest(message: str, error: BaseException | None) -> str:
    """Return a message with the known name nearest to what was given, where the error or its cause lists some."""
    while error is not None:
        if isinstance(error, TactogramError) and error.choices:
            near = get_close_matches(str(error.value), error.choices, n=1, cutoff=0.6)
            return f"{message}; did you mean {near[0]!r}?" if near else message
        error = error.__cause__
    return message


def with_command(message: str, words: Sequence[str]) -> str:
    """Return a message in which an option and its value in backquotes are the user's command with them.

    They replace those that the command has already, but for ``--set``, of which there may be several.
    """

    def command(found: re.Match[str]) -> str:
        kept, last = [], ""
        for word in words:
            if found[1] == "--set" or found[1] not in (last, word.partition("=")[0]):
                kept.append(word)
            last = word
        return f"`{shlex.join(['tactogram', *kept])} {found[1]} {found[2]}`"

    return ADDITION.sub(command, message)


def with_options(message: str, flags: Mapping[str, str]) -> str:
    """Return an error's message with options in place of the parameters that it names, as of `flags_of`.

    They are its remedies (`tactogram.errors.Remedy`). A name with a value that is no option is one of those of
    ``--set``, if the verb has it. What a verb advises instead has the text of the remedy as its key in ``flags``, or
    ``rate=`` for any value.
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

    return with_remedies(message, option)
