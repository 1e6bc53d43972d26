"""What each verb takes."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from typing import Any, cast

from tactogram.cli import verbs
from tactogram.cli.printing import Arguments

Add = Callable[..., Any]
Verb = Callable[[Arguments], int | None]


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of every verb; what it parses has ``run``, the function in `verbs` to call."""
    parser = argparse.ArgumentParser(
        prog="tactogram",
        description="Learn, generate, judge and render touch.",
        epilog="Results are on stdout, progress on stderr. `tactogram VERB --help` says what a verb takes.",
    )
    parser.add_argument("--version", action=_Version, help="show the version and exit")
    subparsers = parser.add_subparsers(metavar="VERB", required=True)

    def verb(name: str, run: Verb) -> Add:
        sub = subparsers.add_parser(name, **_texts(run))
        sub.set_defaults(run=run)
        sub.add_argument("--json", action="store_true", help="print one JSON object")
        return cast(Add, sub.add_argument)

    add = verb("demo", verbs.demo)
    add("--out", default="runs/demo", help="folder for everything it makes (default %(default)s)")
    add("--seed", type=int, default=0)

    verb("doctor", verbs.doctor)
    _data_verbs(subparsers)

    add = verb("models", verbs.models)
    _models_option(add)

    add = verb("train", verbs.train)
    add("model", metavar="MODEL")
    _training_options(add)
    add("--out", metavar="RUN", help="the run's folder (default runs/MODEL-RECIPE-ID)")
    add("--resume", action="store_true", help="go on with the run in --out after an interruption")
    add("--devices", type=int, default=1, help="how many GPUs (default %(default)s)")

    add = verb("crossval", verbs.crossval)
    add("model", metavar="MODEL")
    _training_options(add, more_by="; of a predictor of ratings item, rater or both")
    add("--folds", type=int, default=10, help="default %(default)s")
    add("--only-folds", type=int, metavar="N", help="run only the first N of them")
    add("--repeats", type=int, default=3, help="of a predictor of ratings: how often folds are drawn anew")
    add("--out", metavar="DIR", help="folder for figures and report (default under runs)")

    add = verb("evaluate", verbs.evaluate)
    add("run_folder", metavar="RUN")
    _models_option(add)
    add("--data", metavar="DIR", help="a data set to judge on (default: the run's own test part)")
    add("--unknown", action="store_true", help="add the materials that were left out of training")
    add(
        "--judging",
        action="append",
        metavar="KEY=VALUE",
        default=[],
        help="of a generator: steps, window_s, longest_s, most or seed of what it is judged with",
    )
    add("--rater", metavar="RUN", help="of a generator that goes by words: the rater model that judges it")

    add = verb("generate", verbs.generate)
    add("run_folders", metavar="RUN", nargs="+", help="two for an image and a vibration from the same words")
    _models_option(add)
    what = subparsers.choices["generate"].add_mutually_exclusive_group()
    what.add_argument("--material", metavar="NAME")
    what.add_argument("--mix", metavar="A=0.6,B=0.4", help="weights by material")
    add("--words", metavar="rough=6,sticky=2", help="scores from 1 to 7 by word")
    add("--rest", choices=("mean",), help="words that are not named: the mean over the run's rated items")
    add("--like", metavar="ITEM", help="words that are not named: as this rated surface or image was scored")
    add("--vibration", metavar="FILE", help="a recording of the surface, for models that start from one")
    add("--rater", metavar="RUN", action="append", default=[], help="a rater that scores what was made")
    add("--image", metavar="FILE", help="a photograph of the surface")
    add("--speed", type=float, metavar="MM_S", help="stroking speed, mm/s")
    add("--force", type=float, metavar="N", help="normal force, N")
    add("--seconds", type=float, help="length (default: the model's own)")
    add("--seed", type=int, default=0)
    add("--count", type=int, default=1, help="how many (default %(default)s)")
    add(
        "--out", required=True, metavar="FILE", help=".wav, .flac, .csv, .npz, .xlsx, .png; of words a folder"
    )

    add = verb("mix", verbs.mix)
    add("run_folder", metavar="RUN")
    add("start", metavar="A")
    add("end", metavar="B")
    _models_option(add)
    add("--mode", choices=("sum", "add"), default="sum", help="weights that sum to 1, or A at 1 and B added")
    add("--steps", type=int, default=11, help="weights of B from 0 to 1 (default %(default)s)")
    add("--signals", type=int, default=6, help="measured at each step (default %(default)s)")
    add("--speed", type=float, metavar="MM_S", help="stroking speed, mm/s")
    add("--force", type=float, metavar="N", help="normal force, N")
    add("--seconds", type=float, help="length of each (default: the model's own)")
    add("--seed", type=int, default=0)
    add("--out", metavar="DIR", help="folder for figure, sounds and JSON (default RUN/mixing/A-B-MODE)")

    add = verb("classify", verbs.classify)
    add("run_folder", metavar="RUN")
    add("files", metavar="FILE", nargs="+")
    _models_option(add)
    _signal_options(add)

    add = verb("score", verbs.score)
    add("run_folder", metavar="RUN")
    add("files", metavar="FILE", nargs="+", help="signals, or images where the run is of images")
    _models_option(add)
    _signal_options(add)

    add = verb("search", verbs.search)
    add("run_folder", metavar="RUN")
    add("file", metavar="FILE")
    add(
        "--data",
        metavar="DIR",
        help="a data set to search in, added recordings too (default: what was trained on)",
    )
    add("--count", type=int, default=5, help="how many to show (default %(default)s)")
    _models_option(add)
    _signal_options(add)

    add = verb("convert", verbs.convert)
    add("source", metavar="A")
    add("target", metavar="B")
    _signal_options(add)
    add("--columns", help="columns to read from a table, e.g. ax,ay,az")
    add("--time", metavar="COLUMN", help="the table's column of time stamps")
    add("--sheet", help="the sheet of an .xlsx file")
    add("--full-scale", type=float, metavar="X", help="what integer full scale means, in the unit")
    add("--play-at", type=float, metavar="MM_S", help="speed at which a signal over displacement is met")
    add("--resample", type=float, metavar="HZ", help="rate of B")
    add("--subtype", help="sample format of B, e.g. PCM_16, PCM_24, FLOAT")

    _run_verbs(subparsers)

    add = verb("reproduce", verbs.reproduce)
    add("experiment", metavar="EXPERIMENT", nargs="?")
    add("--list", action="store_true", help="list the experiments")
    add("--recipe", default="bench", help="bench (hours at most on 2 cores) or paper (default %(default)s)")
    add(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="what the experiment leaves open, e.g. model=ar_texture",
    )
    add("--out", metavar="DIR", help="folder for its results (default runs/EXPERIMENT)")

    verb("table", verbs.table)
    return parser


def _data_verbs(subparsers: Any) -> None:
    data = subparsers.add_parser("data", help="import, simulate, look at and check data sets").add_subparsers(
        metavar="list|import|simulate|info|check|add|rate", required=True
    )

    def verb(name: str, run: Verb) -> Add:
        sub: argparse.ArgumentParser = data.add_parser(name, **_texts(run))
        sub.set_defaults(run=run)
        sub.add_argument("--json", action="store_true", help="print one JSON object")
        return sub.add_argument

    verb("list", verbs.data_list)
    add = verb("import", verbs.data_import)
    add("set", metavar="SET", help="one of `tactogram data list`; `folder` for MATERIAL/*.wav and the like")
    add("path", metavar="PATH")
    add("--out", required=True, metavar="DIR")
    add("--skip-bad", action="store_true", help="report broken files and go on without them")
    add(
        "--set",
        dest="options",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="what the files do not say, e.g. rate=1000",
    )
    add("--workers", type=int, help="processes (default: all cores)")
    add = verb("simulate", verbs.data_simulate)
    add("set", metavar="SET")
    add("--out", required=True, metavar="DIR")
    add("--seed", type=int, default=0)
    add("--per-class", type=int, metavar="N", help="recordings per class")
    add("--rate", type=float, metavar="HZ")
    add("--seconds", type=float, help="length of a recording")
    add("--photographs", type=int, metavar="N", help="of each surface, up to 9 places (default: one picture)")
    add(
        "--raters",
        type=int,
        metavar="N",
        help="simulated people who score, in sets with ratings (default: the paper's)",
    )
    add("--workers", type=int, help="processes (default: all cores)")
    for name, function in (("info", verbs.data_info), ("check", verbs.data_check)):
        verb(name, function)("path", metavar="DIR")
    add = verb("add", verbs.data_add)
    add("path", metavar="DIR")
    add("file", metavar="FILE")
    add("--material", required=True, metavar="NAME")
    add("--stream", default=None, help="what it is (default: the store's only stream)")
    add("--speed", type=float, metavar="MM_S", help="stroking speed, mm/s")
    add("--force", type=float, metavar="N", help="normal force, N")
    _signal_options(add)
    add = verb("rate", verbs.data_rate)
    add("path", metavar="DIR")
    add(
        "files",
        metavar="FILE",
        nargs="+",
        help=".csv, .tsv or .parquet: a row per score, or a column per word",
    )
    add(
        "--scale",
        default="7-point",
        help="7-point, evoked, LOW:HIGH or LOW:HIGH:STEP (default %(default)s)",
    )
    add("--replace", action="store_true", help="in the place of ratings that are there already")
    add(
        "--set",
        dest="options",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="column.rater=HEADING (or item, word, score, order, session, a word), words=A,B, ignore=A,B, "
        "item=plate{:0>2}, encoding=cp932",
    )


def _run_verbs(subparsers: Any) -> None:
    run_verbs = subparsers.add_parser("run", help="pack a run into one file, or unpack one").add_subparsers(
        metavar="export|import", required=True
    )
    for name, function in (("export", verbs.run_export), ("import", verbs.run_import)):
        sub = run_verbs.add_parser(name, **_texts(function))
        sub.add_argument("source", metavar="RUN" if name == "export" else "FILE")
        sub.add_argument("--out", required=True, metavar="FILE" if name == "export" else "RUN")
        sub.add_argument("--json", action="store_true", help="print one JSON object")
        sub.set_defaults(run=function)


def _texts(run: Verb) -> dict[str, Any]:
    """Return a verb's line in the list of verbs, and what its own help says: the first line of its docstring."""
    line = (run.__doc__ or "").partition("\n")[0]
    return {"help": line[:1].lower() + line[1:].rstrip("."), "description": line}


def _models_option(add: Add) -> None:
    add("--models", action="append", default=[], metavar="DIR", help="a folder with further models")


def _training_options(add: Add, *, more_by: str = "") -> None:
    add("--data", required=True, metavar="DIR", help="a store made by `data import` or `data simulate`")
    add(
        "--recipe",
        default="quick",
        metavar="NAME|FILE",
        help="paper, quick, tiny or a TOML file (default quick)",
    )
    add("--set", action="append", default=[], metavar="KEY=VALUE", help="change a value of the recipe")
    add("--band", type=float, nargs=2, metavar=("LO", "HI"), help="pass band in Hz; as --set prepare.band=…")
    add("--split", default="", metavar="last=N|all", help="keep the last N recordings of a class for testing")
    add(
        "--by",
        default="recording",
        help=f"recording, session, subject, material or condition: never on two sides{more_by}",
    )
    add(
        "--label",
        default="material",
        help="what makes a class, e.g. material+contactor (default %(default)s)",
    )
    add("--where", action="append", default=[], metavar="KEY=VALUE", help="only recordings that have it")
    add("--accelerator", default="auto", help="auto, cpu, cuda or mps (default %(default)s)")
    _models_option(add)


def _signal_options(add: Add) -> None:
    add("--unit", help="unit of the samples, where the file does not say: m/s^2, m/s, m, N, V or 1")
    add("--rate", type=float, metavar="HZ", help="sampling rate, where the file does not say")
    add("--axes", help="names of the columns or channels to read, e.g. x,y,z")


class _Version(argparse.Action):
    """Show the version without looking it up for every other command."""

    def __init__(self, option_strings: Sequence[str], dest: str, **kwargs: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **kwargs)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version

        sys.stdout.write(f"tactogram {version('tactogram')}\n")
        parser.exit()
