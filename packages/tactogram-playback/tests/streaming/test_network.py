"""Messages for game engines: exact bytes, over loopback, invalid packets never raise."""

import math
import socket
import struct

import numpy as np
import pytest
from hypothesis import given, strategies as st
from pythonosc.osc_message import OscMessage

from tactogram.errors import DeviceError, ParameterError
from tactogram.rendering.motion.finger_state import MixWeights, MotionSample, Tap
from tactogram_playback.streaming.backends import Clock, run_clocked
from tactogram_playback.streaming.contact import ContactSettings
from tactogram_playback.streaming.engine import Engine
from tactogram_playback.streaming.network import (
    NO_MOTION,
    BlockPacket,
    NetworkBlocks,
    NetworkMotion,
    ReceivedPacket,
    block_packet,
    parse,
    parse_address,
)
from tactogram_playback.streaming.output import Stream
from tactogram_playback.streaming.texture_table import TextureTable
from tactogram_playback.streaming.textures import AutoregressiveTexture


def motion_packet(sequence, time_s, *, x_mm=math.nan, y_mm=math.nan, speed_mm_s=math.nan, force_n=math.nan):
    """Return the documented bytes of a motion message."""
    values = struct.pack(">Idffff", sequence, time_s, x_mm, y_mm, speed_mm_s, force_n)
    return b"/tactogram/1/motion\0" + b",idffff\0" + values


def block_in(packet):
    """Return the block in a message, read by python-osc."""
    message = OscMessage(packet)
    assert message.address == "/tactogram/1/block"
    sequence, motion, first, time_s, rate, channels, data = message.params
    samples = np.frombuffer(data, "<f4").reshape(-1, channels).T
    return BlockPacket(samples, rate, sequence % 2**32, first, time_s, motion % 2**32)


def test_a_block_has_the_documented_bytes():
    block = BlockPacket(np.array([[1, 2], [3, 4]], np.float32), 8000.0, 5, 80, 0.25, NO_MOTION)
    head = (
        b"/tactogram/1/block\0\0" + b",iihdfib\0\0\0\0" + struct.pack(">iiqdfi", 5, -1, 80, 0.25, 8000.0, 2)
    )
    assert block_packet(block) == head + struct.pack(">i", 16) + struct.pack("<ffff", 1, 3, 2, 4)


TAP = b"/tactogram/1/tap\0\0\0\0" + b",idf\0\0\0\0" + struct.pack(">idf", 2, 2.5, 0.5)
NAME = "körk".encode()


@pytest.mark.parametrize(
    ("packet", "message"),
    [
        (TAP, Tap(9.0, 0.5)),
        (
            b"/tactogram/1/mix\0\0\0\0" + b",idsf\0\0\0" + struct.pack(">id8sf", 2, 2.5, NAME, 0.25),
            MixWeights({"körk": 0.25}),
        ),
    ],
)
def test_a_tap_and_a_mix_are_read_from_the_documented_bytes(packet, message):
    assert parse(packet, 9.0) == [ReceivedPacket(2, message)]


def test_motion_is_read_from_the_documented_bytes():
    packet = motion_packet(4_000_000_000, 2.5, x_mm=1.0, y_mm=2.0, force_n=0.25)
    sample = parse(packet, 9.0)
    assert sample[0].sequence == 4_000_000_000
    found = sample[0].message
    assert (found.time_s, found.arrival_s, found.x_mm, found.y_mm, found.force_n) == (2.5, 9.0, 1, 2, 0.25)
    assert math.isnan(found.speed_mm_s)


def test_a_block_comes_back_as_it_was_sent():
    samples = np.random.default_rng(0).standard_normal((2, 40)).astype(np.float32)
    block = block_in(block_packet(BlockPacket(samples, 8000.0, 0xFFFFFFFF, 1 << 40, 1.25, 3)))
    assert np.array_equal(block.samples, samples)
    assert (block.sequence, block.first_sample, block.time_s, block.motion_sequence) == (
        0xFFFFFFFF,
        1 << 40,
        1.25,
        3,
    )


def test_a_bundle_may_say_several_things():
    first = motion_packet(1, 0.5, force_n=1.0)
    parts = b"".join(struct.pack(">i", len(m)) + m for m in (first, TAP))
    bundle = b"#bundle\0" + struct.pack(">Q", 1) + parts
    assert [r.sequence for r in parse(bundle, 0.0)] == [1, 2]


@given(
    st.binary(max_size=120),
    st.sampled_from([b"", b"/tactogram/1/m", b"#bundle\0"]),
)
def test_random_bytes_are_never_more_than_not_understood(rest, head):
    found = parse(head + rest, 0.0)
    assert found is None or all(isinstance(one, ReceivedPacket) for one in found)


@given(st.integers(0, 35))
def test_a_packet_cut_short_is_not_understood(length):
    assert parse(motion_packet(1, 0.0, force_n=1.0)[:length], 0.0) is None


def test_another_version_is_not_understood():
    assert parse(TAP.replace(b"/1/", b"/2/"), 0.0) is None


@pytest.fixture(name="port")
def port_fixture():
    clock = Clock()
    motion = NetworkMotion(port=0, clock=clock.now)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as game:
        game.settimeout(2.0)
        yield motion, game, clock
    motion.close()


def test_motion_is_heard_and_lost_and_garbled_packets_are_counted(port, until):
    motion, game, _ = port
    for packet in (
        motion_packet(10, 0.0, x_mm=1, y_mm=0),
        b"nonsense",
        motion_packet(13, 0.01, x_mm=2, y_mm=0),
    ):
        game.sendto(packet, motion.address)
    found = []
    until(lambda: found.extend(motion.poll(0.0)) or len(found) == 2)
    assert [sample.x_mm for sample in found] == [1, 2]
    assert all(isinstance(sample, MotionSample) for sample in found)
    facts = motion.facts()
    assert (facts["not_understood"], facts["missing"]) == (1, 2)
    assert facts["sender"] == f"127.0.0.1:{game.getsockname()[1]}"


def test_a_game_engine_sends_motion_and_gets_blocks(port, sloping):
    """Over loopback: motion in, blocks back to its port, numbered without a gap."""
    motion, game, clock = port
    texture = AutoregressiveTexture(
        "a", TextureTable(sloping, speeds=3, forces=3), rate=8000, most=40, seed=0
    )
    engine = Engine([texture], motion, rate=8000, most=40, contact=ContactSettings(gain=0))
    engine.warm_up()
    sink = NetworkBlocks(rate=8000, motion=motion)
    sequence = 0

    def play(samples, now_s):
        nonlocal sequence
        sequence += 1
        packet = motion_packet(sequence, 50 + now_s, x_mm=100 * now_s, y_mm=0, force_n=0.5)
        game.sendto(packet, motion.address)
        sink(samples, now_s)

    run_clocked(Stream(engine), seconds=0.4, clock=clock, sink=play)
    sink.close()
    assert sink.sent > 0
    blocks = [block_in(game.recv(65_535)) for _ in range(sink.sent)]
    assert all(block is not None and block.samples.shape == (1, 40) for block in blocks)
    numbers = [block.sequence for block in blocks]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert {b.first_sample - 40 * b.sequence for b in blocks} == {0}
    echoed = [b.motion_sequence for b in blocks]
    assert echoed == sorted(echoed)
    assert echoed[-1] > 1
    assert max(np.abs(block.samples).max() for block in blocks) > 0


def test_a_port_in_use_is_one_line(port):
    motion, _, clock = port
    with pytest.raises(DeviceError, match="cannot listen"):
        NetworkMotion(port=motion.address[1], clock=clock.now)


@pytest.mark.parametrize(
    ("text", "expected"),
    [("10.0.0.2:99", ("10.0.0.2", 99)), (":7", ("127.0.0.1", 7)), ("host", ("host", 9120))],
)
def test_addresses(text, expected):
    assert parse_address(text) == expected


@pytest.mark.parametrize("text", ["a:b", "a:70000", "a:-1"])
def test_what_is_no_port_is_refused(text):
    with pytest.raises(ParameterError, match="HOST:PORT"):
        parse_address(text)


def test_blocks_need_somewhere_to_go():
    with pytest.raises(ParameterError, match="to must be an address"):
        NetworkBlocks(rate=8000)
