"""Paths through the code: the modules and functions of tactogram between a command and its result, and how deep.

Each path runs once from the command line and once from Python, in a process of its own under `sys.setprofile`, on
small simulated data. "modules" are those of `tactogram` and `tactogram_*` of which a function ran, "functions" the
different functions, "depth" the most frames of these modules on the stack at once. Imports, comprehensions, generated
functions such as a dataclass's `__init__`, and other libraries' frames are not counted; threads are. From Python,
counting begins at the public function, from the command line at `main`.

``python -m benchmarks.bench_paths [--json FILE] [PATH…]`` prints the table alone; the file has the modules of each
path and its deepest stack, from the outermost function.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import numpy as np

FOLDER = Path(__file__).parents[1]
IMPLICIT = {"<listcomp>", "<setcomp>", "<dictcomp>", "<genexpr>"}
"""Functions that Python makes of an expression; later versions have no frame for some of them."""


def is_ours(module: str) -> bool:
    """Return whether a module is of tactogram or of one of its applications."""
    return module.partition(".")[0] == "tactogram" or module.startswith("tactogram_")


@dataclass
class Trace:
    """The functions of tactogram that ran: ``with Trace() as trace: …``."""

    functions: set[CodeType] = field(default_factory=set)
    modules: set[str] = field(default_factory=set)
    deepest: list[str] = field(default_factory=list)
    """Functions on the stack where it was deepest, the outermost first."""
    _stacks: dict[int, list[FrameType]] = field(default_factory=dict)

    def __enter__(self) -> Trace:
        threading.setprofile(self._event)
        sys.setprofile(self._event)
        return self

    def __exit__(self, *error: object) -> None:
        sys.setprofile(None)
        threading.setprofile(None)
        self._stacks.clear()

    def _event(self, frame: FrameType, event: str, argument: Any) -> None:
        code = frame.f_code
        if event not in ("call", "return") or code.co_name in IMPLICIT or code.co_filename.startswith("<"):
            return
        module = frame.f_globals.get("__name__") or ""
        if not is_ours(module):
            return
        stack = self._stacks.setdefault(threading.get_ident(), [])
        if event == "return":
            if frame in stack:
                del stack[stack.index(frame) :]
            return
        caller = frame.f_back
        while caller is not None and caller not in stack:
            caller = caller.f_back
        # A frame above the caller was left by an exception that was thrown into a generator.
        del stack[0 if caller is None else stack.index(caller) + 1 :]
        stack.append(frame)
        if any(each.f_code.co_name == "<module>" for each in stack):
            return  # an import, and all that it calls
        self.functions.add(code)
        self.modules.add(module)
        if len(stack) > len(self.deepest):
            self.deepest = [f"{each.f_globals['__name__']}.{each.f_code.co_qualname}" for each in stack]

    def counts(self) -> dict[str, int]:
        """Return the numbers of modules and functions, and the depth."""
        return {
            "modules": len(self.modules),
            "functions": len(self.functions),
            "depth": len(self.deepest),
        }


@dataclass(frozen=True)
class CodePath:
    """A way through the code, as a command and as a function without arguments that is made before it is traced."""

    command: str
    python: Callable[[], Callable[[], Any]]


def _csv_to_store() -> Callable[[], Any]:
    from tactogram.workflows.data.stores import import_store

    return lambda: import_store("folder", "tables", out="store-2", workers=1)


def _store_to_model() -> Callable[[], Any]:
    from tactogram import train

    return lambda: train("stroke_cnn", "store", recipe="tiny", out="names-2")


def _words_to_wav() -> Callable[[], Any]:
    from tactogram import pipeline, write_signal

    def generated() -> None:
        write_signal("words-2.wav", pipeline("text-to-touch")("corduroy", speed_mm_s=120, seconds=1))

    return generated


def _mix_to_stream() -> Callable[[], Any]:
    from tactogram_playback import stream

    return lambda: stream("textures", mix={"cork": 0.5, "tile": 0.5}, seconds=0.2, out="felt-2.wav")


def _photograph_to_file() -> Callable[[], Any]:
    from tactogram import convert

    return lambda: convert("photo.png", "photo-2.ahap")


def _answers_to_report() -> Callable[[], Any]:
    from tactogram_study.workflows.analysis import analyse_study

    return lambda: analyse_study("answers", "report-2")


PATHS = {
    "CSV to store": CodePath("data import folder tables --out store-1 --workers 1", _csv_to_store),
    "store to trained model": CodePath(
        "train stroke_cnn --recipe tiny --data store --out names-1", _store_to_model
    ),
    "words to WAV": CodePath(
        "generate texture_flow --text corduroy --speed 120 --seconds 1 --out words-1.wav", _words_to_wav
    ),
    "mix to stream block": CodePath(
        "stream textures --mix cork=0.5,tile=0.5 --seconds 0.2 --out felt-1.wav", _mix_to_stream
    ),
    "photograph to file": CodePath("convert photo.png photo-1.ahap", _photograph_to_file),
    "answers to report": CodePath("study analyse answers --out report-1", _answers_to_report),
}
SETUP = (
    "data import folder tables --out store --workers 1",
    "train texture_var --recipe tiny --data store --out textures",
    "study simulate two-area --out answers --participants 4 --set design.repeats=2",
)
"""Commands that make the data that the paths begin with, after the tables and the photograph."""


def run() -> list[dict[str, Any]]:
    """Return the rows of all paths."""
    return [{key: row[key] for key in ("path", "from", "modules", "functions", "depth")} for row in traced()]


def traced(names: list[str] | None = None) -> list[dict[str, Any]]:
    """Return rows with their modules and deepest stacks, of the named paths or of all."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _write_inputs(folder)
        for command in SETUP:
            _python(folder, ["-m", "tactogram", *command.split()])
        return [
            json.loads(_python(folder, ["-m", "benchmarks.bench_paths", "--trace", start, path]))
            for path in names or PATHS
            for start in ("command line", "Python")
        ]


def _write_inputs(folder: Path) -> None:
    """Write tables of two simulated materials and a photograph of noise."""
    from PIL import Image

    rng = np.random.default_rng(0)
    for material, gain in {"cork": 1.0, "tile": 3.0}.items():
        (folder / "tables" / material).mkdir(parents=True)
        for take in range(4):
            x = np.column_stack([np.arange(2000) / 1000, gain * rng.standard_normal((2000, 3))])
            file = folder / "tables" / material / f"{take}.csv"
            np.savetxt(
                file,
                x,
                "%.5f",
                delimiter=",",
                header="time [s],x [m/s^2],y [m/s^2],z [m/s^2]",
                comments="",
            )
    Image.fromarray(rng.integers(0, 255, (64, 64, 3), dtype=np.uint8)).save(folder / "photo.png")


def _python(folder: Path, arguments: list[str]) -> str:
    """Return what Python prints in a folder; what it says of an error is raised."""
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(FOLDER), os.environ.get("PYTHONPATH", "")])},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"{' '.join(arguments)}: {done.stderr.strip()[-2000:]}")
    return done.stdout


def trace_here(start: str, path: str) -> dict[str, Any]:
    """Return the row of a path that runs in this process and folder."""
    from tactogram.cli import main

    trace = Trace()
    run_path = PATHS[path].python() if start == "Python" else lambda: main(PATHS[path].command.split())
    with contextlib.redirect_stdout(io.StringIO()), trace:
        status = run_path()
    if start != "Python" and status:
        raise RuntimeError(f"{PATHS[path].command}: ended with status {status}")
    return {
        "path": path,
        "from": start,
        **trace.counts(),
        "module names": sorted(trace.modules),
        "deepest stack": trace.deepest,
    }


def main(arguments: list[str] | None = None) -> None:
    """Print the table of the named paths."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.bench_paths", description=__doc__.split("\n")[0]
    )
    parser.add_argument("names", metavar="PATH", nargs="*", help=f"of {', '.join(PATHS)} (default: all)")
    parser.add_argument(
        "--json", metavar="FILE", type=Path, help="file for the modules and stacks of each path"
    )
    parser.add_argument("--trace", help=argparse.SUPPRESS)
    a = parser.parse_args(arguments)
    if unknown := set(a.names) - set(PATHS):
        parser.error(f"unknown: {', '.join(sorted(unknown))}; known are {', '.join(PATHS)}")
    if a.trace:
        print(json.dumps(trace_here(a.trace, a.names[0])))
        return
    rows = traced(a.names)
    print("| path | from | modules | functions | depth |\n| --- | --- | --- | --- | --- |")
    for row in rows:
        print(f"| {row['path']} | {row['from']} | {row['modules']} | {row['functions']} | {row['depth']} |")
    if a.json:
        a.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
