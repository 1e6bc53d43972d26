"""Messages of a TWE-Lite receiver (App_Tag parent, App_Wings) with an ADXL34x sensor: lines to packets.

Forms, columns and units are facts of the receiver's documentation and firmware (App_Tag 2.2.4); ``docs/capture.md``
lists them. Only the hex form has a checksum. Lines of the others must match their columns exactly and are otherwise
rejected as a whole, since the rest of a damaged line may be wrong, too.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.signal import STANDARD_GRAVITY

Mode = Literal["single", "fifo", "low_energy"]
Form = Literal["hex", "standard", "semicolon"]

AXES = ("x", "y", "z")

FIFO_SAMPLES = 10
"""Samples of a ten-sample packet in the forms without their number."""

MILLI_G = 1e-3 * STANDARD_GRAVITY
UNITS_BY_MODE: dict[Mode, float] = {
    "single": 10 * MILLI_G,
    "fifo": MILLI_G,
    "low_energy": 10 * MILLI_G,
}
"""m/s^2 per step. Ten-sample packets are in mg, single and low-energy ones in 10 mg."""

_MODES: dict[int, Mode] = {0x00: "single", 0xFA: "fifo", 0xFE: "low_energy"}
_ADXL = 0x35
_HEADER = struct.Struct(">IBHIBB")
_BODY = struct.Struct(">BHHB")
_START = _HEADER.size + _BODY.size


@dataclass(frozen=True, eq=False, slots=True)
class Packet:
    """Content of one radio packet."""

    sender: str
    """Serial number of the sensor, 8 hex digits as on its hex frames."""
    sequence: int
    """0 to 65535, increased by one with every packet of the sensor."""
    mode: Mode
    samples: NDArray[np.float32]
    """float32, shape (axis, n), m/s^2, in order of time; NaN where the line of a sample was broken. Axes are `AXES`."""
    form: Form
    arrival_s: float = float("nan")
    """Arrival of the last byte; NaN if unknown."""
    receiver_s: float = float("nan")
    """Time on the receiver's clock (to 0.01 s in the ten-sample mode); NaN in the forms without it."""
    relay: str = "80000000"
    """Address of the relay; 80000000 without one."""
    lqi: int = 0
    """Quality of the radio link, 0 to 255."""
    battery_mv: int = 0
    adc1_mv: int = 0
    adc2_mv: int = 0


@dataclass(frozen=True, slots=True)
class OtherPacket:
    """Valid packet without acceleration: another kind of sensor, or the receiver's clock or greeting."""

    what: str


@dataclass(frozen=True, slots=True)
class RejectedLine:
    """Rejected line, and the reason."""

    why: str


@dataclass(frozen=True, slots=True)
class ContinuationPacket:
    """A further sample (x, y, z in mg) of the ten-sample packet begun by a preceding line."""

    values: tuple[int, int, int]


def battery_mv(code: int) -> int:
    """Return the voltage in mV that a byte encodes: steps of 5 mV from 1950, of 10 mV from 2800."""
    return 1950 + 5 * code if code <= 170 else 2800 + 10 * (code - 170)


def battery_code(millivolts: int) -> int:
    """Return the byte that encodes a voltage, the inverse of `battery_mv`."""
    return (millivolts - 1950) // 5 if millivolts <= 2800 else 170 + (millivolts - 2800) // 10


def checksum(payload: bytes | bytearray) -> int:
    """Return the byte that brings the sum of all bytes to 0 modulo 256."""
    return -sum(payload) & 0xFF


def decode_hex(body: str, arrival_s: float) -> Packet | OtherPacket | RejectedLine:
    """Decode the upper-case hex digits after a colon, checksum last."""
    if len(body) % 2 or len(body) < 4 or not _HEX.fullmatch(body):
        return RejectedLine("not hex")
    data = bytes.fromhex(body)
    if sum(data) & 0xFF:
        return RejectedLine("checksum")
    return decode_payload(data[:-1], arrival_s)


def decode_payload(payload: bytes, arrival_s: float) -> Packet | OtherPacket | RejectedLine:
    """Decode the payload of a frame whose checksum is correct."""
    if payload[0] < 0x80:
        # The standard application and all others whose frames do not begin with a relay's address.
        return OtherPacket(f"frame of kind 0x{payload[1]:02X}")
    if len(payload) < _HEADER.size:
        return RejectedLine("length")
    relay, lqi, sequence, sender, _, kind = _HEADER.unpack_from(payload)
    if kind != _ADXL:
        return OtherPacket(f"sensor of kind 0x{kind:02X}")
    if len(payload) <= _START:
        return RejectedLine("length")
    battery, adc1, adc2, code = _BODY.unpack_from(payload, _HEADER.size)
    mode = _MODES.get(code)
    if mode is None:
        return RejectedLine(f"mode 0x{code:02X}")
    values = payload[_START:]
    if mode == "fifo":
        count, values = values[0], values[1:]
        if not count or len(values) != 6 * count:
            return RejectedLine("length")
    elif len(values) != 6:
        return RejectedLine("length")
    counts = np.frombuffer(values, ">i2").reshape(-1, 3).T
    return Packet(
        f"{sender:08X}",
        sequence,
        mode,
        (counts * UNITS_BY_MODE[mode]).astype(np.float32),
        "hex",
        arrival_s,
        float("nan"),
        f"{relay:08X}",
        lqi,
        battery_mv(battery),
        adc1 & 0x0FFF,
        adc2 & 0x0FFF,
    )


def decode_standard(line: str, arrival_s: float) -> Packet | OtherPacket | RejectedLine:
    """Decode a line ``::rc=…``. Its separators are colons; one firmware prints ``;`` before the first z."""
    match = _STANDARD.fullmatch(line)
    if match is None:
        return RejectedLine("standard form")
    relay, lqi, sequence, sender, battery, adc1, adc2, rest = match.groups()
    mode: Mode
    if _STANDARD_SAMPLES.fullmatch(rest):
        rows = _SAMPLE.findall(rest)
        if len(rows) not in (1, FIFO_SAMPLES):
            return RejectedLine("samples missing")
        mode = "single" if len(rows) == 1 else "fifo"
        if mode == "single" and ";" in rest:
            return RejectedLine("samples missing")
    elif _OTHER_VALUES.fullmatch(rest):
        return OtherPacket("another sensor's line")
    else:
        return RejectedLine("standard form")
    return _of_text(
        rows, mode, sender=sender, sequence=int(sequence, 16), form="standard", arrival_s=arrival_s, relay=relay,
        lqi=int(lqi), battery_mv=int(battery), adc1_mv=int(adc1), adc2_mv=int(adc2),
    )  # fmt: skip


def decode_columns(line: str, arrival_s: float) -> Packet | ContinuationPacket | OtherPacket | RejectedLine:
    """Decode a line of the semicolon form.

    A ten-sample packet consists of one line with the packet's columns and its first sample, which is returned as a
    packet of one sample in the mode ``"fifo"``, and lines with twelve empty columns and one sample each.
    """
    if further := _CONTINUED.fullmatch(line):
        x, y, z = further.groups()
        return ContinuationPacket((int(x), int(y), int(z)))
    match = _COLUMNS.fullmatch(line)
    if match is None:
        if _CLOCK.fullmatch(line):
            return OtherPacket("the receiver's clock")
        if _OTHER_COLUMNS.fullmatch(line):
            return OtherPacket("another sensor's line")
        return RejectedLine("columns")
    clock, relay, lqi, sequence, sender, battery, code, adc1, adc2, first = match.groups()
    mode = _MODES.get(int(code, 16))
    if mode is None:
        return RejectedLine(f"mode 0x{int(code, 16):02X}")
    number = int(sequence)
    if number > 0xFFFF:
        return RejectedLine("columns")
    # Serial numbers are printed without their first digit, which is 8 in all of them.
    return _of_text(
        [tuple(first.split(";"))], mode, sender=f"8{sender.upper()}", sequence=number, form="semicolon",
        arrival_s=arrival_s, receiver_s=float(clock), relay=relay, lqi=int(lqi), battery_mv=int(battery),
        adc1_mv=int(adc1), adc2_mv=int(adc2),
    )  # fmt: skip


def _of_text(rows: list[tuple[str, ...]], mode: Mode, **values: Any) -> Packet | RejectedLine:
    """Return the packet with the counts of its samples as text, and further values."""
    counts = np.array([[int(value) for value in row] for row in rows])
    if counts.min() < -32768 or counts.max() > 32767 or values["lqi"] > 255:
        return RejectedLine("out of range")
    return Packet(samples=(counts.T * UNITS_BY_MODE[mode]).astype(np.float32), mode=mode, **values)


# A value is printed with at least four characters, including the sign.
_VALUE = r"(?:-\d{3,5}|\d{4,5})"
_HEX = re.compile(r"[0-9A-F]+")
_STANDARD = re.compile(
    r"::rc=([0-9A-F]{8}):lq=(\d{1,3}):ct=([0-9A-F]{4}):ed=([0-9A-F]{8}):id=[0-9A-F]{1,2}"
    r":ba=(\d{4}):a1=(\d{4}):a2=(\d{4})(.*)"
)
_STANDARD_SAMPLES = re.compile(rf"(?:[:;]x={_VALUE}[:;]y={_VALUE}[:;]z={_VALUE})+")
_SAMPLE = re.compile(rf"[:;]x=({_VALUE})[:;]y=({_VALUE})[:;]z=({_VALUE})")
_OTHER_VALUES = re.compile(r"(?:[:;](?!x=|y=|z=)[a-z][a-z0-9]{1,3}[=:]-?\d+)+")
_CONTINUED = re.compile(rf";{{12}}({_VALUE});({_VALUE});({_VALUE});")
_COLUMNS = re.compile(
    r";(\d{1,10}(?:\.\d\d)?);([0-9A-Fa-f]{8});(\d{3});(\d{3,5});([0-9A-Fa-f]{7});(\d{4})"
    rf";([0-9A-Fa-f]{{4}});[0-9A-Fa-f]{{4}};(\d{{4}});(\d{{4}});X;({_VALUE};{_VALUE};{_VALUE});"
)
_CLOCK = re.compile(r";\d{1,10};")
_OTHER_COLUMNS = re.compile(
    r";\d{1,10}(?:\.\d\d)?;[0-9A-Fa-f]{8};\d{3};\d{3,5};[0-9A-Fa-f]{7};(?:-?[0-9A-Fa-f]*;){4,6}"
    r"[A-WYZ];(?:(?:-?\d+|[A-Z]|[0-9A-F]{2});)*"
)
