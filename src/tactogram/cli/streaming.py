"""The verb that streams textures under a finger."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from tactogram.cli.stopping import interrupt_on_sigterm
from tactogram.cli.verbs import Verb


def _text(result: dict[str, Any]) -> str:
    from tactogram.workflows.streaming.stream import latency_lines

    of = " (simulated)" if result["simulated"] else ""
    lines = [f"{', '.join(result['textures'])}{of}: {result['seconds']:g} s to {result['backend']}"]
    lines += latency_lines(result)
    lines += [f"{name}: {result[name]}" for name in ("file", "figure") if name in result]
    return "\n".join(lines)


@contextmanager
def _streaming() -> Iterator[Mapping[str, Any]]:
    status = _StatusPrinter()
    with interrupt_on_sigterm():
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


VERBS = {
    "stream": Verb(
        "tactogram.workflows.streaming.stream:stream",
        _text,
        lambda result: result["limited"],
        folders=("models",),
        within=_streaming,
    )
}
