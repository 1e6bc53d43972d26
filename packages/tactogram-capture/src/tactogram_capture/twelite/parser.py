"""Parser of a TWE-Lite receiver's bytes: any form, split or damaged anywhere."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from tactogram_capture.twelite.messages import (
    FIFO_SAMPLES,
    UNITS_BY_MODE,
    ContinuationPacket,
    OtherPacket,
    Packet,
    RejectedLine,
    decode_columns,
    decode_hex,
    decode_standard,
)

LONGEST_LINE = 1024
"""Bytes without an end of line that are dropped; the longest line of any form has about 350."""


class TweliteParser:
    """Parser of bytes in arbitrary pieces into packets.

    Lines of every form are distinguished as they arrive; a receiver may change its form. Every
    byte is accounted for: after `finish`, ``bytes_taken`` (readable messages, line ends and empty lines) plus
    ``bytes_rejected`` is the number of bytes fed.
    """

    def __init__(self) -> None:
        self.rejected: Counter[str] = Counter()
        """Unreadable lines and frames, by reason."""
        self.other: Counter[str] = Counter()
        """Readable ones without acceleration."""
        self.bytes_taken = self.bytes_rejected = 0
        self._buffer = bytearray()
        self._skipping_line = False
        self._open: Packet | None = None
        self._open_rows: list[tuple[int, int, int]] = []

    def feed(self, data: bytes, arrival_s: float = float("nan")) -> list[Packet]:
        """Return the packets that ``data``, which arrived at ``arrival_s``, completes."""
        self._buffer += data
        packets: list[Packet] = []
        while True:
            end = self._buffer.find(b"\n", 0, LONGEST_LINE)
            if end >= 0:
                line = bytes(self._buffer[: end + 1])
                del self._buffer[: end + 1]
                self._line(line, packets, arrival_s)
            elif len(self._buffer) > LONGEST_LINE:
                self._break(packets)
                self._reject("" if self._skipping_line else "line without an end", LONGEST_LINE)
                self._skipping_line = True
                del self._buffer[:LONGEST_LINE]
            else:
                return packets

    def finish(self, arrival_s: float = float("nan")) -> list[Packet]:
        """Return the open packet; a last line without an end is parsed as a line, since logs often lack it."""
        packets: list[Packet] = []
        if self._buffer:
            self._line(bytes(self._buffer), packets, arrival_s)
            self._buffer.clear()
        self._close(packets)
        return packets

    def _line(self, line: bytes, packets: list[Packet], arrival_s: float) -> None:
        if self._skipping_line:
            self._skipping_line = False
            self._reject("", len(line))
            return
        text = line.strip(b"\r\n\t \0").decode("latin-1")
        if not text:
            self.bytes_taken += len(line)
            return
        before = 0
        decoded: Packet | ContinuationPacket | OtherPacket | RejectedLine
        if text[0] == ";":
            decoded = decode_columns(text, arrival_s)
        elif "::" in text:
            before = text.rfind("::")
            rest = text[before:]
            decoded = (
                OtherPacket("the receiver's clock") if _is_clock(rest) else decode_standard(rest, arrival_s)
            )
        elif ":" in text:
            before = text.rfind(":")
            decoded = decode_hex(text[before + 1 :], arrival_s)
        else:
            decoded = RejectedLine("not a line of any form")
        if text[0] == "*":
            before, decoded = 0, OtherPacket("the receiver's greeting")
        if isinstance(decoded, ContinuationPacket):
            self._continue(decoded, packets, arrival_s, len(line))
            return
        if before and not isinstance(decoded, RejectedLine):
            # Text before a whole frame is a piece of another one.
            self._reject("unfinished", before)
        self._take(decoded, packets, len(line) - (0 if isinstance(decoded, RejectedLine) else before))

    def _take(self, decoded: Packet | OtherPacket | RejectedLine, packets: list[Packet], count: int) -> None:
        if isinstance(decoded, RejectedLine):
            self._break(packets)
            self._reject(decoded.why, count)
            return
        self.bytes_taken += count
        if isinstance(decoded, OtherPacket):
            self.other[decoded.what] += 1
            return
        self._break(packets)
        if decoded.mode == "fifo" and decoded.form == "semicolon":
            self._open, self._open_rows = decoded, []
        else:
            packets.append(decoded)

    def _continue(
        self, further: ContinuationPacket, packets: list[Packet], arrival_s: float, count: int
    ) -> None:
        if self._open is None:
            self._reject("continuation of nothing", count)
            return
        if any(not -32768 <= value <= 32767 for value in further.values):
            self._take(RejectedLine("out of range"), packets, count)
            return
        self.bytes_taken += count
        self._open_rows.append(further.values)
        if len(self._open_rows) == FIFO_SAMPLES - 1:
            self._open = replace(self._open, arrival_s=arrival_s)
            self._close(packets)

    def _break(self, packets: list[Packet]) -> None:
        """Close a ten-sample packet before its end, without knowing which samples are missing."""
        if self._open is not None:
            self.rejected["samples missing"] += 1
            self._close(packets)

    def _close(self, packets: list[Packet]) -> None:
        """Return the open ten-sample packet with NaN for its missing samples."""
        if self._open is None:
            return
        samples = np.full((3, FIFO_SAMPLES), np.nan, np.float32)
        samples[:, :1] = self._open.samples
        if self._open_rows:
            rows = np.array(self._open_rows).T * UNITS_BY_MODE["fifo"]
            samples[:, 1 : 1 + rows.shape[1]] = rows.astype(np.float32)
        packets.append(replace(self._open, samples=samples))
        self._open, self._open_rows = None, []

    def _reject(self, why: str, count: int) -> None:
        """Count unreadable bytes; without a reason they belong to the message counted before."""
        self.bytes_rejected += count
        if why:
            self.rejected[why] += 1


def _is_clock(text: str) -> bool:
    return text.startswith("::ts=") and text[5:].isascii() and text[5:].isdigit()
