"""Logs of receivers and boards, played back through the parser that reads live."""

from __future__ import annotations

from pathlib import Path

from pydantic import Field

from tactogram_capture.logs import log_kind
from tactogram_capture.source import Source, SourceKind, required_place
from tactogram_capture.stream.byte_source import Replay
from tactogram_capture.stream.csv_lines import CsvFormat
from tactogram_capture.stream.csv_source import CsvSource
from tactogram_capture.stream.raw_log import log_facts, log_pieces
from tactogram_capture.twelite.source import TweliteSource


class LogOptions(CsvFormat):
    """Options of ``log:FILE``: the format of a board's lines, and these."""

    kind: str | None = Field(default=None, pattern="^(twelite|serial)$")
    sender: str | None = None


def _open(place: str, options: LogOptions, *, name: str) -> Source:
    path = Path(required_place(place, name, "the file"))
    simulated = bool((log_facts(path) or {}).get("simulated"))
    stream = Replay(str(path), log_pieces(path))
    if (options.kind or log_kind(path)) == "twelite":
        return TweliteSource(stream, name=name, sender=options.sender, rate=options.rate, simulated=simulated)
    return CsvSource(stream, options, name=name, simulated=simulated)


SOURCE = SourceKind("log", "log of a receiver or a board", "log:FILE", LogOptions, _open, place_is_file=True)
