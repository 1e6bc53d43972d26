"""Catalogue of the verbs: only the module of the chosen one is imported, and nothing heavy by it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import NamedTuple

GROUPS = {
    "data": "import, simulate, inspect and check data sets",
    "run": "pack a run into one file, or unpack one",
}
VERBS = {
    "start": {
        "doctor": "Check the installation: packages, missing extras with their purpose, and the compute device.",
        "models": "List the models, or show one with the settings that `train --set` takes.",
    },
    "data": {
        "data list": "List what can be imported and simulated.",
        "data import": "Import a data set into a store.",
        "data info": "Describe what a store holds.",
        "data export": "Write a store as a data set of the Hugging Face Hub.",
        "data check": "Check every shard of a store against its hash.",
        "data copy": "Copy a store to an object store such as S3, back, or to another folder, and check it on the way.",
        "data add": "Add a recording to a store.",
        "data like": "Find the recordings of a store whose spectra are nearest to a file's, without a trained run.",
        "data rate": "Add tables of ratings to a store.",
        "data ratings": "Write the ratings of a store as a table.",
    },
    "training": {
        "train": "Train a model on a data set, or continue a run.",
        "crossval": "Cross-validate a classifier, by recording, or a predictor of ratings, by item or rater.",
        "evaluate": "Evaluate a run on recordings that it was not trained on.",
        "compare": "Compare runs: their data, the settings in which they differ, and their results.",
        "run export": "Pack a run into one .zip file, or write its networks for other programs.",
        "run import": "Unpack a run from a .zip file, or take it from the Hugging Face Hub.",
    },
    "generating": {
        "generate": "Generate signals or images with a trained run, or both from the same words with two.",
        "clone": "Make a texture for any speed and force from one stroke of a surface, or from words.",
        "mix": "Generate a ladder of mixes of two materials, and measure where each step lies.",
    },
    "recognising": {
        "classify": "Classify the material of recordings.",
        "score": "Predict word scores of recordings, generated signals or images with a rater model.",
        "search": "Find the recordings nearest to a file, or report none of these.",
    },
    "files": {
        "convert": "Convert a signal from one file format to another, a folder of them, or check a haptic file.",
        "effect": "List the ready effects, or write one as a haptic file or a signal.",
    },
    "rendering": {
        "displays": "List the displays, or show one.",
        "render": "Render a signal to the drive of a display, with a report of what changed.",
    },
}
"""Verbs and their help, by the module of `tactogram.cli` that declares each in its own ``VERBS``."""
EXTRAS = {
    "simulate": ("demo", "data simulate"),
    "playback": ("stream", "play", "sweep", "response", "calibrate", "transducer", "track"),
    "capture": ("capture", "capture-log", "live", "sources", "device"),
    "study": ("study",),
    "studio": ("studio", "study run", "touch"),
    "benchmark": ("benchmark", "reproduce", "table"),
}
"""Verbs and groups of the project's further distributions, by the extra that installs them."""


class VerbPlace(NamedTuple):
    """A verb: its help, and the module that declares it."""

    help: str
    module: str


def verb_places() -> dict[str, VerbPlace]:
    """Return the verbs of this package and those of installed ones (entry points ``tactogram.verbs``), by words."""
    tables = [("tactogram.cli", VERBS), *((name, import_module(name).VERBS) for name in _packages())]
    return {
        words: VerbPlace(line, f"{package}.{module}")
        for package, modules in tables
        for module, verbs in modules.items()
        for words, line in verbs.items()
    }


@cache
def _packages() -> tuple[str, ...]:
    return tuple(sorted(point.value for point in entry_points(group="tactogram.verbs")))


def group_helps() -> dict[str, str]:
    """Return what the groups of verbs are for, by their word."""
    return GROUPS | {
        group: line
        for package in _packages()
        for group, line in getattr(import_module(package), "GROUPS", {}).items()
    }


def overview(group: str = "") -> str:
    """Return the verbs of a group, or the verbs and groups of all, a line each, as ``--help`` shows them."""
    places = verb_places()
    if group:
        lines = {words: entry.help for words, entry in places.items() if words.startswith(f"{group} ")}
        usage, about = f"{group} VERB", group_helps()[group]
    else:
        helps = group_helps()
        lines = {words.split()[0]: helps.get(words.split()[0], entry.help) for words, entry in places.items()}
        usage, about = "VERB", "learn, generate, evaluate and render touch"
    width = max(map(len, lines)) + 2
    return "\n".join([
        f"usage: tactogram {usage} [options]    (--version shows the version)",
        f"{about[:1].upper()}{about[1:]}.",
        "",
        *(f"  {words:{width}}{line[:1].lower()}{line[1:].rstrip('.')}" for words, line in lines.items()),
        "",
        "Results are on stdout, progress on stderr. `tactogram VERB --help` lists a verb's options.",
        "",
    ])  # fmt: skip


def nearest_verb(words: Sequence[str], verbs: Iterable[str]) -> str | None:
    """Return what to say of words that begin with no verb; None if they do, or begin with an option.

    ``verbs`` have one word, or that of a group and their own.
    """
    known = [verb.split() for verb in verbs]
    typed = list(words[:2])
    if not typed or typed[0].startswith("-") or typed[:1] in known or typed in known:
        return None
    inner = [verb for verb in known if verb[0] == typed[0]]
    if inner and (len(typed) == 1 or typed[1].startswith("-")):
        return None
    for extra, listed in EXTRAS.items():
        for named in (" ".join(typed), *([] if inner else typed[:1])):
            if named in listed:
                return f"`tactogram {named}` comes with an extra: pip install 'tactogram[{extra}]'"
    wrong = typed[-1] if inner else typed[0]
    near = get_close_matches(wrong, {verb[-1] for verb in inner or known}, n=1)
    matches = [f"`tactogram {' '.join(verb)}`" for verb in inner or known if verb[-1:] == near]
    likely = f"did you mean {' or '.join(matches)}? " if matches else ""
    shown, group = (" ".join(typed), f"{typed[0]} ") if inner else (wrong, "")
    return f"no verb {shown!r}; {likely}`tactogram {group}--help` lists all"
