"""Requests of recording sessions, live classification and sensor logs."""

from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TextIO

from tactogram.workflows import Argument, Option, Request

if TYPE_CHECKING:
    from tactogram.workflows import LoadedRun
    from tactogram_capture.live.recognition import WindowClassification
    from tactogram_capture.session.console import Console
    from tactogram_capture.session.metronome import Metronome
    from tactogram_capture.source import BlockListener
    from tactogram_capture.workflows.live import LiveClassifier

SOURCE = "twelite:/dev/ttyUSB0, serial:PORT, lsl:NAME, audio:NAME, ni:Dev1/ai0:2, digilent:, log:FILE, played:STORE"


@dataclass(frozen=True)
class CaptureRequest(Request):
    """A recording session to run or continue."""

    plan: Annotated[Path | str, Argument("a session plan: a TOML file, or one of --list", "PLAN")]
    source: Annotated[str, Option(f"source of the samples: {SOURCE}", "ADDRESS")]
    data: Annotated[Path | str, Option("the store; made with the first take", "DIR")]
    _: KW_ONLY
    session: Annotated[str, Option("name of the session (default: the plan and the subject)", "NAME")] = ""
    subject: Annotated[str | None, Option("who strokes, as a code, since the store keeps it", "CODE")] = None
    changes: Annotated[
        Mapping[str, Any] | None, Option("change a value of the plan", "KEY=VALUE", "--set")
    ] = None
    recognise: Annotated[Path | str | None, Option("classifier that recognises each take", "RUN")] = None
    yes: Annotated[bool, Option("ask no questions: accept good takes, redo bad ones, skip after three")] = (
        False
    )
    sound: Annotated[bool, Option("no metronome", flag="--silent")] = True
    answers: TextIO | None = None
    """Source of answers without a terminal; by default stdin."""
    console: "Console | None" = None
    metronome: "Metronome | None" = None
    heard: "BlockListener | None" = None
    """Receives the source and each block as it is read; see `TappedSource`."""


@dataclass(frozen=True)
class LiveRequest(Request):
    """A source to classify window by window until it ends, is interrupted, or ``seconds`` are over."""

    run: Annotated["Path | str | LoadedRun", Argument("a classifier", "RUN")]
    source: Annotated[str, Option(SOURCE, "ADDRESS")]
    _: KW_ONLY
    window: Annotated[float | None, Option("length of a window, s (default: the network's input)", "S")] = (
        None
    )
    hop: Annotated[
        float | None,
        Option("time from one window to the next (default: a quarter of a window)", "S", above=0),
    ] = None
    rate: Annotated[
        float | None,
        Option(
            "the source's rate, where it states none (default: that of the training data); a measured rate that "
            "contradicts it is used instead",
            "HZ",
        ),
    ] = None
    seconds: Annotated[float | None, Option("stop after this time (default: at Ctrl-C)", "S")] = None
    show: "Callable[[WindowClassification], None] | None" = None
    """Receives each window."""
    begin: "Callable[[LiveClassifier], None] | None" = None
    """Called once before the first."""
    heard: "BlockListener | None" = None
    """Receives the source and each block as it is read; see `TappedSource`."""


@dataclass(frozen=True)
class LogRequest(Request):
    """A sensor's log to read into files or a store; without either, only its facts are returned.

    The default is a signal for each piece between two gaps; ``fill`` makes one signal of all and reports how much of
    it was filled. A measured rate that contradicts ``rate`` is used instead.
    """

    path: Annotated[Path | str, Argument("a log of a TWE-Lite receiver or a board, or an .xdf file", "FILE")]
    _: KW_ONLY
    out: Annotated[Path | str | None, Option("a file, by suffix; several signals are numbered", "F")] = None
    data: Annotated[Path | str | None, Option("a store; created if it does not exist", "DIR")] = None
    material: Annotated[str | None, Option("material touched (required with --data)")] = None
    speed_mm_s: Annotated[float | None, Option("stroking speed", "MM_S", "--speed")] = None
    force_n: Annotated[float | None, Option("normal force", "N", "--force")] = None
    contactor: Annotated[str | None, Option("what touched it, e.g. finger or pen")] = None
    kind: Annotated[
        Literal["twelite", "serial"] | None, Option("what wrote the log, where it is not evident")
    ] = None
    sender: Annotated[str | None, Option("only this sensor", "SID")] = None
    rate: Annotated[float | None, Option("nominal rate; needed where the log has no times", "HZ")] = None
    fill: Annotated[
        bool, Option("fill gaps by straight lines (default: one signal for each stretch between them)")
    ] = False
    most_s: Annotated[float, Option("longest gap that is filled", "S", "--most")] = 0.1
    least_s: Annotated[float, Option("omit shorter stretches", "S", "--least")] = 0.5
    options: Annotated[
        Mapping[str, Any] | None,
        Option("for a board: time, unit, scale, axes, …; for XDF: unit", "KEY=VALUE", "--set"),
    ] = None
