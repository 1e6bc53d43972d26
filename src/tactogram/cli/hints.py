"""Messages in words of the command line: options, nearest names, and the user's command with what it lacks."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from difflib import get_close_matches

from tactogram.errors import Message, Remedy, TactogramError


def in_words(error: TactogramError, flags: Mapping[str, str], words: Sequence[str]) -> str:
    """Return the message of an error for the user of a command: options, the nearest name, and the command with more.

    ``flags`` are those of `tactogram.cli.verbs.flags_of`, ``words`` the command.
    """
    return with_nearest(with_options(error.message, flags, words), error)


def with_nearest(message: str, error: BaseException | None) -> str:
    """Return a message with the known name nearest to the value, where the error or its cause lists some."""
    while error is not None:
        if isinstance(error, TactogramError) and error.choices:
            near = get_close_matches(str(error.value), error.choices, n=1, cutoff=0.6)
            return f"{message}; did you mean {near[0]!r}?" if near else message
        error = error.__cause__
    return message


def with_options(message: str, flags: Mapping[str, str], words: Sequence[str] = ()) -> str:
    """Return a `tactogram.errors.Message` with options in place of its parameters, as of `flags_of`; a text as it is.

    A name with a value that is no option is one of those of ``--set``, if the verb has it. With the ``words`` of a
    command, an option with a value is that command with it. What a verb advises instead has the argument in backquotes
    as its key in ``flags``, or ``rate=`` for any value.
    """
    if not isinstance(message, Message):
        return message
    flags = {**flags, "model_folders": "--models"}
    settings = "--set" in flags.values()

    def option(remedy: Remedy) -> str:
        name, value = remedy.parameter, remedy.value
        if value is None:
            said = flags.get(remedy.argument, flags.get(name, remedy.argument))
        elif advice := flags.get(remedy.argument, flags.get(f"{name}=")):
            said = advice
        elif flags.get(name, "").startswith("-"):
            said = f"`{command_with(flags[name], shlex.quote(str(value)), words)}`"
        elif settings:
            setting = f"{name}={shlex.quote(str(value)) if ' ' in str(value) else value}"
            said = f"`{command_with('--set', setting, words)}`"
        else:
            said = remedy.argument
        return f"{remedy.advice} {said}".strip()

    return message.in_words(option, flags)


def command_with(flag: str, value: str, words: Sequence[str]) -> str:
    """Return a command with an option and its value instead of those it has; without ``words`` the option alone.

    Only of ``--set`` there may be several.
    """
    kept, last = [], ""
    for word in words:
        if flag == "--set" or flag not in (last, word.partition("=")[0]):
            kept.append(word)
        last = word
    return " ".join([*([shlex.join(["tactogram", *kept])] if words else []), flag, value])
