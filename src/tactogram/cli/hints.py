"""Messages in words of the command line: options, nearest names, and the user's command with what it lacks."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from difflib import get_close_matches

from tactogram.errors import Remedy, with_remedies

NAMED = (
    re.compile(r"must be (?:one )?of (?P<known>[^;]+)[,;] got '(?P<got>[^']+)'$"),
    re.compile(r"unknown key '(?P<got>[^']+)'; known here: (?P<known>[^;]+)$"),
)
"""Ends of the messages that list what is known."""
ADDITION = re.compile(r"`(--[\w-]+) ('[^'`]+'|[^`\s]+)`")


def with_nearest(message: str) -> str:
    """Return a message that lists what is known, and names what was given, with the known name nearest to that."""
    found = next((found for form in NAMED if (found := form.search(message))), None)
    if found is None:
        return message
    names = re.split(r", (?:or )?(?:e\.g\. )?", found["known"])
    near = get_close_matches(found["got"], names, n=1, cutoff=0.6)
    return f"{message}; did you mean {near[0]!r}?" if near else message


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
