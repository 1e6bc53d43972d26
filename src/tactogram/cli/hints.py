"""Hints in errors: nearest names, and the user's own command with the option that it lacks."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Sequence
from difflib import get_close_matches

NAMED = (
    re.compile(r"must be (?:one )?of (?P<known>[^;]+)[,;] got '(?P<got>[^']+)'$"),
    re.compile(r"unknown key '(?P<got>[^']+)'; known here: (?P<known>[^;]+)$"),
)
"""Ends of the messages that list what is known."""
ADDITION = re.compile(r"`(--[\w-]+) ('[^'`]+'|[^`\s]+)`")


EXTRAS = {
    "capture": ("capture", "capture-log", "live", "sources", "device"),
    "study": ("study",),
    "studio": ("studio", "study run"),
    "benchmark": ("benchmark", "reproduce", "table"),
}
"""Verbs and groups of the project's further distributions, by the extra that installs them."""


def nearest_verb(words: Sequence[str], verbs: Iterable[str]) -> str | None:
    """Return what to say of words that begin with no verb; None if they do, or begin with an option.

    ``verbs`` have one word, or that of a group and their own.
    """
    known = [verb.split() for verb in verbs]
    given = list(words[:2])
    if not given or given[0].startswith("-") or given[:1] in known or given in known:
        return None
    inner = [verb for verb in known if verb[0] == given[0]]
    if inner and (len(given) == 1 or given[1].startswith("-")):
        return None
    for extra, words_there in EXTRAS.items():
        if " ".join(given) in words_there or (not inner and given[0] in words_there):
            return f"`tactogram {' '.join(given)}` comes with an extra: pip install 'tactogram[{extra}]'"
    wrong = given[-1] if inner else given[0]
    near = get_close_matches(wrong, {verb[-1] for verb in inner or known}, n=1)
    found = [f"`tactogram {' '.join(verb)}`" for verb in inner or known if verb[-1:] == near]
    likely = f"did you mean {' or '.join(found)}? " if found else ""
    shown, group = (" ".join(given), f"{given[0]} ") if inner else (wrong, "")
    return f"no verb {shown!r}; {likely}`tactogram {group}--help` lists all"


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
