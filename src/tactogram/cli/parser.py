"""Argument parser. Only the module of the chosen verb is imported, and nothing heavy by it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

GROUPS = {
    "data": "import, simulate, inspect and check data sets",
    "benchmark": "answer fixed tasks with models, and rank them",
    "run": "pack a run into one file, or unpack one",
    "study": "experiments with people: check, run, simulate, export, analyse",
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
    "capturing": {
        "capture": "Record a session by a plan, or continue one; every accepted take is stored at once.",
        "live": "Classify what a sensor touches, live.",
        "sources": "List the sources that can be recorded from, and what each lacks.",
        "capture-log": "Import a sensor's log into files or a store, with its gaps.",
    },
    "studying": {
        "study list": "List the studies that come with the package.",
        "study designs": "List the designs that a study can have, with their margins and power tables.",
        "study languages": "List the languages of participants' pages, or print the texts of one.",
        "study check": "Check a study's file and describe what it asks of a participant.",
        "study run": "Serve a study to participants and its progress to the experimenter; run again to continue.",
        "study simulate": "Let simulated participants take a study, with or without an effect.",
    },
    "study_sessions": {
        "study export": "Write the answers of a session as a tidy table or a BIDS folder.",
        "study withdraw": "Delete a participant and all their data; export tables again afterwards.",
        "study progress": "Show the progress of each participant in a session.",
        "study note": "Add an experimenter's note to a session.",
        "study abort": "End a participant's session now; the answers so far are kept.",
        "study end": "End a study: nobody can join, and unfinished participants cannot continue.",
    },
    "study_analysis": {
        "study analyse": "Analyse answers, as published and with repeated measures, with intervals and verdicts.",
        "study power": "Compute the power of a study before it is run: exactly, and with simulated participants.",
    },
    "studio": {"studio": "Open the studio in the browser: generate, touch, train, send, and run studies."},
    "benchmarking": {
        "benchmark list": "List the tasks, and whether their data is at hand.",
        "benchmark run": "Train models for tasks, answer them, and write a result per model, task and seed.",
        "benchmark table": "Rank the models of every task from results.",
        "benchmark check": "Check the file of a result.",
        "benchmark questions": "Write the training data and questions of a task as files for any framework.",
        "benchmark score": "Score answers from files.",
    },
    "reproducing": {
        "reproduce": "Run the experiment behind a published table or figure.",
        "table": "Show every model's published results and ours, and the figures of evaluated runs.",
    },
}
"""Verbs and their help, by the module of `tactogram.cli` that declares each in its own ``VERBS``."""


def all_verbs() -> list[str]:
    """Return the words of every verb."""
    return [words for verbs in VERBS.values() for words in verbs]


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
    groups: dict[str, Any] = {}
    for module, verbs in VERBS.items():
        for words, line in verbs.items():
            group, _, name = words.rpartition(" ")
            if group and group not in groups:
                inner = top.add_parser(group, help=GROUPS[group])
                names = [
                    verb.partition(" ")[2]
                    for each in VERBS.values()
                    for verb in each
                    if verb.startswith(f"{group} ")
                ]
                groups[group] = inner.add_subparsers(metavar="|".join(names), required=True)
            sub = groups.get(group, top).add_parser(
                name, help=line[:1].lower() + line[1:].rstrip("."), description=line
            )
            if argv is None or words.split() == list(argv[: words.count(" ") + 1]):
                _complete(sub, module, words, listing="--list" in (argv or ()))
    return parser


def _complete(sub: argparse.ArgumentParser, module: str, words: str, *, listing: bool) -> None:
    from tactogram.cli.verbs import add_options

    verb = import_module(f"tactogram.cli.{module}").VERBS[words]
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
