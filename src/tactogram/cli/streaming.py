"""The verb that streams textures under a finger."""

from __future__ import annotations

import sys

from tactogram.cli.printing import Printer
from tactogram.cli.stopping import interrupt_on_sigterm
from tactogram.cli.verbs import Verb
from tactogram.workflows.streaming.requests import StreamRequest


@interrupt_on_sigterm()
def _stream(request: StreamRequest, show: Printer) -> None:
    from tactogram.workflows.streaming.stream import latency_lines, stream

    status = _StatusPrinter()
    result = stream(**vars(request) | {"status": status, "tell": status.line})
    if sys.stderr.isatty():
        sys.stderr.write("\n")
    of = " (simulated)" if result["simulated"] else ""
    lines = [f"{', '.join(result['textures'])}{of}: {result['seconds']:g} s to {result['backend']}"]
    lines += latency_lines(result)
    lines += [f"{name}: {result[name]}" for name in ("file", "figure") if name in result]
    show(result, "\n".join(lines))
    show.notes(result["limited"])


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


VERBS = {"stream": Verb(StreamRequest, _stream, folders=("models",))}
