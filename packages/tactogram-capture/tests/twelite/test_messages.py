"""Payloads of packets: modes, battery voltage, and refusals."""

import math
from collections import Counter

import numpy as np
import pytest

from tactogram_capture.twelite.messages import (
    MILLI_G,
    battery_code,
    battery_mv,
    checksum,
    decode_payload,
)
from tactogram_capture.twelite.parser import TweliteParser


def parsed(data, **receiver):
    parser = TweliteParser()
    return parser.feed(data) + parser.finish(), parser


@pytest.mark.parametrize("separator", [";", ":"])
def test_semicolon_slip_of_the_firmware_is_accepted_and_its_correction_too(separator):
    ten = f":x=0100:y=-200{separator}z=0996" + ":x=0104:y=-204:z=1000" * 9
    line = f"::rc=80000000:lq=135:ct=0009:ed=810043C1:id=0:ba=3060:a1=1136:a2=0651{ten}\r\n"
    [packet], parser = parsed(line.encode())

    assert packet.mode == "fifo"
    assert packet.samples[:, 0] / MILLI_G == pytest.approx([100, -200, 996], abs=1e-3)
    assert packet.samples[:, 9] / MILLI_G == pytest.approx([104, -204, 1000], abs=1e-3)
    assert not parser.rejected


def test_any_number_of_samples_in_a_hex_frame_is_read():
    payload = bytes.fromhex("80000000630017810000010035DF057702F2FA") + bytes([3])
    payload += np.arange(9, dtype=">i2").tobytes()
    body = payload + bytes([checksum(payload)])
    [packet], _ = parsed(b":" + body.hex().upper().encode() + b"\r\n")

    assert packet.samples / MILLI_G == pytest.approx(np.arange(9).reshape(3, 3).T, abs=1e-3)


def test_an_unknown_mode_is_refused_by_its_number():
    payload = bytes.fromhex("8000000063001781013C850035DF057702F2000000FF96FFF0")
    payload = payload[: 19 - 1] + b"\x7f" + payload[19:]
    body = payload + bytes([checksum(payload)])
    packets, parser = parsed(b":" + body.hex().upper().encode() + b"\r\n")

    assert packets == []
    assert parser.rejected == Counter({"mode 0x7F": 1})


def test_battery_voltage_follows_the_documented_steps():
    assert battery_mv(0xDF) == 3330
    assert battery_mv(170) == 2800
    assert [battery_code(battery_mv(code)) for code in range(256)] == list(range(256))


@pytest.mark.parametrize(
    "payload", [b"\x80", bytes([0x80] * 12), bytes.fromhex("8000000063001781013C850035")]
)
def test_short_payload_is_refused(payload):
    assert decode_payload(payload, math.nan).why == "length"
