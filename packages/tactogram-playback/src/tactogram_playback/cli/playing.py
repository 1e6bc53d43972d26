"""Verbs that play: streams, drives, sweeps, and what of a display and its transducer is measured first."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from tactogram.cli.printing import columns, lines_of
from tactogram.cli.verbs import Verb

WORKFLOWS = "tactogram_playback.workflows"


@contextmanager
def _interrupt_on_sigterm() -> Iterator[None]:
    """Let SIGTERM interrupt a verb as Ctrl-C does: an actuator is brought to rest on the way out."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _stream_text(result: dict[str, Any]) -> str:
    from tactogram_playback.workflows.stream import latency_lines

    of = " (simulated)" if result["textures_simulated"] else ""
    lines = [f"{', '.join(result['textures'])}{of}: {result['seconds']:g} s to {result['backend']}"]
    lines += latency_lines(result)
    lines += [f"{name}: {result[name]}" for name in ("file", "figure") if name in result]
    return "\n".join(lines)


@contextmanager
def _streaming() -> Iterator[Mapping[str, Any]]:
    status = _StatusPrinter()
    with _interrupt_on_sigterm():
        yield {"status": status, "tell": status.line}
    if sys.stderr.isatty():
        sys.stderr.write("\n")


class _StatusPrinter:
    """Overwrites the status line on a terminal; elsewhere writes one every ten seconds."""

    def __init__(self) -> None:
        self._next_s = 0.0

    def line(self, text: str) -> None:
        """Write a line that stays."""
        sys.stderr.write(text + "\n")
        sys.stderr.flush()

    def __call__(self, line: str, now_s: float) -> None:
        if sys.stderr.isatty():
            sys.stderr.write(f"\r{line[:118]:118}")
        elif now_s >= self._next_s:
            self._next_s = now_s + 10
            sys.stderr.write(line + "\n")
        sys.stderr.flush()


def _calibrate_text(result: dict[str, Any]) -> str:
    rows = [("person", "k_e, N/V^2", "interval", "mu_0", "exponent", "square law", "pairs")]
    for name, fit in result["people"].items():
        low, high = fit["newton_per_v2_interval"]
        exponent = "-" if fit["exponent"] is None else f"{fit['exponent']:.2f}"
        holds = {True: "not contradicted", False: "contradicted", None: "not tested"}[fit["square_law_holds"]]
        rows.append(
            (
                name,
                f"{fit['newton_per_v2']:.3g}",
                f"{low:.3g} to {high:.3g}",
                f"{fit['mu_0']:.3g}",
                exponent,
                holds,
                str(fit["pairs"]),
            )
        )
    return f"{columns(rows)}\n{result['file']}"


@contextmanager
def _tracking() -> Iterator[Mapping[str, Callable[[str], None] | None]]:
    terminal = sys.stderr.isatty()
    with _interrupt_on_sigterm():
        yield {"status": _show_status if terminal else None}
    if terminal:
        sys.stderr.write("\n")


def _show_status(line: str) -> None:
    sys.stderr.write(f"\r{line:78}")
    sys.stderr.flush()


VERBS = {
    "stream": Verb(
        f"{WORKFLOWS}.stream:stream",
        _stream_text,
        lambda result: result["limited"],
        folders=("models",),
        within=_streaming,
        advice={"amps_per_volt": "--track amps_per_volt"},
    ),
    "play": Verb(f"{WORKFLOWS}.actuators:play", lines_of, within=_interrupt_on_sigterm),
    "sweep": Verb(f"{WORKFLOWS}.response:write_sweep", lines_of),
    "response": Verb(f"{WORKFLOWS}.response:write_identified", lines_of),
    "calibrate": Verb(f"{WORKFLOWS}.actuators:calibrate", _calibrate_text),
    "transducer": Verb(f"{WORKFLOWS}.actuators:transducer", lines_of),
    "track": Verb(f"{WORKFLOWS}.actuators:track", lines_of, within=_tracking),
}
