"""Argument parser. Only the module of the chosen verb is imported, and nothing heavy by it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, NamedTuple

GROUPS = {
    "data": "import, simulate, inspect and check data sets",
    "run": "pack a run into one file, or unpack one",
}
VERBS = {
    "start": {
        "demo": "Simulate, classify, search, generate and evaluate surfaces, and write a report.",
        "doctor": "Check the installation: packages, missing extras with their purpose, and the compute device.",
        "models": "List the models, or show one with the settings that `train --set` takes.",
    },
    "data": {
        "data list": "List what can be imported and simulated.",
        "data import": "Import a data set into a store.",
        "data simulate": "Simulate a data set of surfaces.",
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
    },
    "rendering": {
        "displays": "List the displays, or show one.",
        "render": "Render a signal to the drive of a display, with a report of what changed.",
        "sweep": "Write the sweep that measures a display's response.",
        "response": "Identify a display's response from a played sweep and its recording.",
    },
    "actuating": {
        "calibrate": "Fit voltage to friction, person by person, for an electrovibration display.",
        "transducer": "Identify a transducer's resonance and Q from its measured admittance.",
        "track": "Keep a carrier at a transducer's resonance, by its measured voltage and current.",
        "play": "Play a rendered drive on a sound card, or an envelope on a generator that makes the carrier itself.",
    },
    "streaming": {"stream": "Play textures that follow a finger, and measure how late they are."},
}
"""Verbs and their help, by the module of `tactogram.cli` that declares each in its own ``VERBS``."""


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


def make_parser(argv: Sequence[str] | None = None) -> argparse.ArgumentParser:
    """Return the parser of every verb, with the options of the verb in ``argv``; of all where it is None.

    What it parses has ``verb``, a `tactogram.cli.verbs.Verb`, and ``usage_error``.
    """
    parser = argparse.ArgumentParser(
        prog="tactogram",
        description="Learn, generate, evaluate and render touch.",
        epilog="Results are on stdout, progress on stderr. `tactogram VERB --help` lists a verb's options.",
    )
    parser.add_argument("--version", action=_Version, help="show the version and exit")
    top = parser.add_subparsers(metavar="VERB", required=True)
    helps = GROUPS | {
        group: line
        for package in _packages()
        for group, line in getattr(import_module(package), "GROUPS", {}).items()
    }
    places = verb_places()
    groups: dict[str, Any] = {}
    for words, place in places.items():
        group, _, name = words.rpartition(" ")
        if group and group not in groups:
            inner = top.add_parser(group, help=helps[group])
            names = [verb.partition(" ")[2] for verb in places if verb.startswith(f"{group} ")]
            groups[group] = inner.add_subparsers(metavar="|".join(names), required=True)
        sub = groups.get(group, top).add_parser(
            name, help=place.help[:1].lower() + place.help[1:].rstrip("."), description=place.help
        )
        if argv is None or words.split() == list(argv[: words.count(" ") + 1]):
            _complete(sub, place.module, words, listing="--list" in (argv or ()))
    return parser


def _complete(sub: argparse.ArgumentParser, module: str, words: str, *, listing: bool) -> None:
    from tactogram.cli.functions import FunctionVerb
    from tactogram.cli.verbs import add_options

    verb = import_module(module).VERBS[words]
    if not isinstance(verb, FunctionVerb):
        add_options(sub, verb, listing=listing)
        sub.set_defaults(verb=verb, usage_error=sub.error)


class _Version(argparse.Action):
    """Show the version without looking it up for every other command."""

    def __init__(self, option_strings: Sequence[str], dest: str, **kwargs: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **kwargs)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version

        sys.stdout.write(f"tactogram {version('tactogram')}\n")
        parser.exit()
