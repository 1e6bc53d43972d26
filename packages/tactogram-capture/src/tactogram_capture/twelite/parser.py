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
    decode_payload,
    decode_standard,
)

LONGEST_LINE = 1024
"""Bytes without an end of line that are dropped; the longest line of any form has about 350."""
LONGEST_BINARY = 512
"""Largest length of a binary frame; a larger one is damaged."""

_MARK = b"\xa5\x5a"


class TweliteParser:
    """Parser of bytes in arbitrary pieces into packets.

    Binary frames and lines of every text form are distinguished as they arrive; a receiver may change its form. Every
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
        while self._step(packets, arrival_s):
            pass
        return packets

    def finish(self, arrival_s: float = float("nan")) -> list[Packet]:
        """Return the open packet, and reject unfinished messages.

        A last line without an end is parsed as a line: logs often lack it.
        """
        packets: list[Packet] = []
        while self._step(packets, arrival_s) or self._buffer:
            if not self._buffer:
                break
            if self._buffer.startswith(_MARK):
                self._reject("unfinished", 1)
                del self._buffer[:1]
            elif not self._skipping_line and b"\n" not in self._buffer and _MARK not in self._buffer:
                line = bytes(self._buffer)
                self._buffer.clear()
                self._line(line, packets, arrival_s)
            elif self._skipping_line:
                self._reject("", len(self._buffer))
                self._buffer.clear()
        self._close(packets)
        return packets

    def _step(self, packets: list[Packet], arrival_s: float) -> bool:
        """Parse one line or frame from the buffer; return False if none is complete."""
        buffer = self._buffer
        if not buffer:
            return False
        mark = buffer.find(_MARK, 0, LONGEST_LINE + 1)
        if mark == 0:
            return self._binary(packets, arrival_s)
        end = buffer.find(b"\n", 0, LONGEST_LINE)
        if end >= 0 and (mark < 0 or end < mark):
            line = bytes(buffer[: end + 1])
            del buffer[: end + 1]
            if self._skipping_line:
                self._skipping_line = False
                self._reject("", len(line))
            else:
                self._line(line, packets, arrival_s)
            return True
        if mark > 0:
            self._break(packets)
            self._reject("" if self._skipping_line else "unfinished", mark)
            self._skipping_line = False
            del buffer[:mark]
            return True
        if len(buffer) > LONGEST_LINE:
            self._break(packets)
            self._reject("" if self._skipping_line else "line without an end", LONGEST_LINE)
            self._skipping_line = True
            del buffer[:LONGEST_LINE]
            return True
        return False

    def _binary(self, packets: list[Packet], arrival_s: float) -> bool:
        """Parse the binary frame at the start: mark, length, payload, XOR, end; return False if it is incomplete."""
        buffer = self._buffer
        if len(buffer) < 4:
            return False
        length = int.from_bytes(buffer[2:4], "big") ^ 0x8000
        whole = length + 6
        if not 0 < length <= LONGEST_BINARY:
            return self._no_frame(packets, "length")
        if len(buffer) < whole:
            return False
        payload = bytes(buffer[4 : 4 + length])
        if (
            buffer[whole - 1] != 0x04
            or np.bitwise_xor.reduce(np.frombuffer(payload, np.uint8)) != buffer[-2 + whole]
        ):
            return self._no_frame(packets, "checksum")
        self._break(packets)
        self._skipping_line = False
        del buffer[:whole]
        self._take(decode_payload(payload, "binary", arrival_s), packets, whole)
        return True

    def _no_frame(self, packets: list[Packet], why: str) -> bool:
        """Continue after the first byte of a false frame: a whole one may begin inside it."""
        self._break(packets)
        self._reject(why, 1)
        # The bytes up to the end of the line belong to the rejected frame.
        self._skipping_line = True
        del self._buffer[:1]
        return True

    def _line(self, line: bytes, packets: list[Packet], arrival_s: float) -> None:
        text = line.strip(b"\r\n\t \0").decode("latin-1")
        if not text:
            self.bytes_taken += len(line)
            return
        before = 0
        found: Packet | ContinuationPacket | OtherPacket | RejectedLine
        if text[0] in ";,":
            found = decode_columns(text, arrival_s)
        elif "::" in text:
            before = text.rfind("::")
            rest = text[before:]
            found = (
                OtherPacket("the receiver's clock") if _is_clock(rest) else decode_standard(rest, arrival_s)
            )
        elif ":" in text:
            before = text.rfind(":")
            found = decode_hex(text[before + 1 :], arrival_s)
        else:
            found = RejectedLine("not a line of any form")
        if text[0] == "*":
            before, found = 0, OtherPacket("the receiver's greeting")
        if isinstance(found, ContinuationPacket):
            self._continue(found, packets, arrival_s, len(line))
            return
        if before and not isinstance(found, RejectedLine):
            # Text before a whole frame is a piece of another one.
            self._reject("unfinished", before)
        self._take(found, packets, len(line) - (0 if isinstance(found, RejectedLine) else before))

    def _take(self, found: Packet | OtherPacket | RejectedLine, packets: list[Packet], count: int) -> None:
        if isinstance(found, RejectedLine):
            self._break(packets)
            self._reject(found.why, count)
            return
        self.bytes_taken += count
        if isinstance(found, OtherPacket):
            self.other[found.what] += 1
            return
        self._break(packets)
        if found.mode == "fifo" and found.form in ("semicolon", "comma"):
            self._open, self._open_rows = found, []
        else:
            packets.append(found)

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
