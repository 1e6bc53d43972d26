"""TWE-Lite receivers: every form gives its expected values, split and damaged in any way."""

from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram_capture.twelite.messages import MILLI_G
from tactogram_capture.twelite.parser import LONGEST_LINE, TweliteParser
from tactogram_capture.twelite.simulator import SimulatedReceiver, transmissions


def test_published_block_of_ten_samples_is_read_in_mg():
    """Saga et al., Sec. II-A: "ten consecutive measurement values are stored in one packet"."""
    _, lines = published()
    [packet], parser = parsed("".join(f"{line}\r\n" for line in lines).encode())

    assert (packet.sender, packet.sequence, packet.mode, packet.form) == ("81021745", 2, "fifo", "semicolon")
    assert (packet.receiver_s, packet.lqi, packet.battery_mv) == (33.90, 150, 2495)
    mg = packet.samples / MILLI_G
    assert mg[:, 0] == pytest.approx([-24, 168, -936], abs=1e-3)
    assert mg[:, 9] == pytest.approx([136, 72, -968], abs=1e-3)
    assert packet.samples.shape == (3, 10)
    assert np.linalg.norm(mg, axis=0) == pytest.approx(1000, rel=0.2)
    assert not parser.rejected


GOLDEN = Path(__file__).parents[1] / "golden" / "twelite_lines.txt"


FORMS = ("hex", "standard", "semicolon")


MODES = ("fifo", "single", "low_energy")


def published():
    """Return the published hex lines by name, and the block of the semicolon form."""
    lines = [line for line in GOLDEN.read_text().splitlines() if line and not line.startswith("#")]
    hexes = {name: body for name, _, body in (line.partition(" ") for line in lines) if body.startswith(":")}
    return hexes, [line for line in lines if line.startswith(";")]


def parsed(data, **receiver):
    parser = TweliteParser()
    return parser.feed(data) + parser.finish(), parser


def simulated(form="hex", mode="fifo", **settings):
    """Return the packets that a simulated receiver prints."""
    settings = {"seconds": 0.5, "seed": 1} | settings
    return list(transmissions(SimulatedReceiver(form=form, mode=mode, **settings)))


def test_a_published_line_of_an_accelerometer_has_its_published_values():
    hexes, _ = published()
    [packet], parser = parsed(f"{hexes['adxl_normal']}\r\n".encode())

    assert (packet.sender, packet.sequence, packet.mode, packet.form) == ("81013C85", 23, "single", "hex")
    assert (packet.lqi, packet.battery_mv, packet.adc1_mv, packet.adc2_mv) == (99, 3330, 1399, 754)
    assert packet.relay == "80000000"
    # x = 0, y = -106, z = -16 in steps of 10 mg.
    assert packet.samples[:, 0] == pytest.approx(np.array([0, -1060, -160]) * 9.80665e-3, abs=1e-5)
    assert not parser.rejected


@pytest.mark.parametrize("name", ["analog", "switch", "app_twelite_0x81"])
def test_published_lines_of_other_sensors_give_no_sample(name):
    packets, parser = parsed(f"{published()[0][name]}\r\n".encode())

    assert packets == []
    assert sum(parser.other.values()) == 1
    assert not parser.rejected


def test_documented_line_of_the_standard_form_is_read_in_10_mg():
    line = b"::rc=80000000:lq=135:ct=0009:ed=810043C1:id=0:ba=3060:a1=1136:a2=0651:x=0004:y=-001:z=0096\r\n"
    [packet], _ = parsed(line)

    assert (packet.sender, packet.sequence, packet.lqi, packet.battery_mv) == ("810043C1", 9, 135, 3060)
    assert packet.samples[:, 0] == pytest.approx(np.array([40, -10, 960]) * 9.80665e-3, abs=1e-5)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("mode", MODES)
def test_every_form_and_mode_gives_the_measured_samples(form, mode):
    sent = simulated(form, mode, first_sequence=65530)
    packets, parser = parsed(b"".join(s.data for s in sent))

    assert len(packets) == len(sent)
    for packet, one in zip(packets, sent, strict=True):
        assert (packet.samples == one.samples).all()
        # The standard form does not tell single and low-energy samples apart, which have one unit.
        said = "single" if (form, mode) == ("standard", "low_energy") else mode
        assert (packet.sequence, packet.mode, packet.form) == (one.sequence % 65536, said, form)
        assert (packet.sender, packet.battery_mv, packet.adc1_mv, packet.lqi) == ("81013C85", 3330, 1399, 99)
    assert not parser.rejected
    assert parser.bytes_rejected == 0


@pytest.mark.parametrize(
    ("damage", "why"),
    [
        (lambda line: line.replace(b"FF96", b"FF97"), "checksum"),
        (lambda line: line[:-5] + b"\r\n", "not hex"),
        (lambda line: line[:-4] + b"\r\n", "checksum"),
        (lambda line: line.replace(b"3C", b"3c"), "not hex"),
        (lambda line: line[1:], "not a line of any form"),
    ],
)
def test_damaged_hex_frame_is_refused_and_counted(damage, why):
    line = f"{published()[0]['adxl_normal']}\r\n".encode()
    packets, parser = parsed(damage(line))

    assert packets == []
    assert parser.rejected == Counter({why: 1})
    assert parser.bytes_rejected == len(damage(line))


def test_samples_after_a_damaged_line_of_ten_are_nan_and_not_shifted():
    lines = published()[1]
    lines[3] = lines[3].replace("0064", "0x64")
    [packet], parser = parsed("".join(f"{line}\r\n" for line in lines).encode())

    # The three before it are sure; which of the lines behind it is which, is not.
    assert np.isfinite(packet.samples[:, :3]).all()
    assert np.isnan(packet.samples[:, 3:]).all()
    assert packet.samples.shape == (3, 10)
    assert parser.rejected["samples missing"] == 1
    assert parser.rejected["continuation of nothing"] == 6


def test_ten_samples_cut_short_in_the_standard_form_are_refused_as_a_whole():
    [sent, *_] = simulated("standard")
    cut = sent.data.rsplit(b":x=", 1)[0] + b"\r\n"
    packets, parser = parsed(cut)

    assert packets == []
    assert parser.rejected == Counter({"samples missing": 1})


def test_the_first_of_ten_samples_alone_is_not_a_single_sample():
    [sent, *_] = simulated("standard")
    packets, parser = parsed(sent.data.split(b":x=")[0] + b":x=" + sent.data.split(b":x=")[1] + b"\r\n")

    assert packets == []
    assert parser.rejected == Counter({"samples missing": 1})


def test_a_whole_frame_after_half_of_another_is_kept():
    sent = simulated()
    packets, parser = parsed(sent[0].data[:60] + sent[1].data)

    assert [p.sequence for p in packets] == [1]
    assert parser.rejected == Counter({"unfinished": 1})
    assert parser.bytes_rejected == 60


def test_a_line_without_an_end_is_rejected_once_and_the_next_one_read():
    sent = simulated()
    packets, parser = parsed(b"8" * (3 * LONGEST_LINE) + b"\r\n" + sent[0].data)

    assert len(packets) == 1
    assert parser.rejected == Counter({"line without an end": 1})
    assert parser.bytes_rejected == 3 * LONGEST_LINE + 2


def test_receivers_greeting_and_clock_are_no_samples_and_no_errors():
    packets, parser = parsed(b"\r\n*** ToCoSamp IO Monitor 1-08-2 ***\r\n::ts=12\r\n;12;\r\n")

    assert packets == []
    assert not parser.rejected
    assert sum(parser.other.values()) == 3


def test_clock_between_the_lines_of_ten_samples_does_not_break_them():
    lines = published()[1]
    text = "".join(f"{line}\r\n" for line in [*lines[:5], ";34;", *lines[5:]])
    [packet], _ = parsed(text.encode())

    assert np.isfinite(packet.samples).all()


@settings(max_examples=50)
@given(st.sampled_from(FORMS), st.sampled_from(MODES), st.lists(st.integers(0, 2500), max_size=12), st.data())
def test_pieces_of_bytes_do_not_matter(form, mode, cuts, data):
    stream = b"".join(
        s.data for s in simulated(form, mode, seconds=0.16, corrupt=0.002, seed=data.draw(st.integers(0, 50)))
    )
    whole, expected = parsed(stream)
    parser, packets = TweliteParser(), []
    places = [0, *sorted(min(c, len(stream)) for c in cuts), len(stream)]
    for start, stop in pairwise(places):
        packets += parser.feed(stream[start:stop])
    packets += parser.finish()

    assert [(p.sender, p.sequence, p.samples.tobytes()) for p in packets] == [
        (p.sender, p.sequence, p.samples.tobytes()) for p in whole
    ]
    assert (parser.rejected, parser.other) == (expected.rejected, expected.other)
    assert parser.bytes_taken + parser.bytes_rejected == len(stream)


@given(st.binary(max_size=4000), st.integers(1, 300))
def test_random_bytes_never_crash_never_give_a_sample_and_are_all_counted(noise, step):
    parser, packets = TweliteParser(), []
    for start in range(0, len(noise), step):
        packets += parser.feed(noise[start : start + step])
    packets += parser.finish()

    assert packets == []
    assert parser.bytes_taken + parser.bytes_rejected == len(noise)


_PIECES = st.one_of(
    st.binary(max_size=40),
    st.text("0123456789ABCDEF:;,=-.xyz\r\n", max_size=60).map(str.encode),
    st.sampled_from(
        [b"\xa5\x5a", b"\xa5\x5a\x80\x20", b":", b"::rc=", b";;;;;;;;;;;;0001;0002;0003;", b"\r\n", b";12;"]
    ),
)


@settings(max_examples=50)
@given(st.lists(_PIECES, max_size=8), st.randoms(use_true_random=False))
def test_the_form_with_a_checksum_between_random_bytes_gives_only_sent_packets(rubbish, random):
    sent = {s.sequence: s for s in simulated("hex", seconds=0.2)}
    parts = [s.data for s in sent.values()]
    for piece in rubbish:
        parts.insert(random.randrange(len(parts) + 1), piece)
    packets, parser = parsed(b"".join(parts))

    for packet in packets:
        assert (packet.samples == sent[packet.sequence].samples).all()
    assert parser.bytes_taken + parser.bytes_rejected == sum(map(len, parts))


@settings(max_examples=50)
@given(st.sampled_from(FORMS), st.integers(0, 10**6))
def test_truncated_and_interleaved_frames_are_counted_and_give_no_false_packet(form, seed):
    rng = np.random.default_rng(seed)
    two = [
        simulated(form, seconds=0.3, sender=sender, seed=s)
        for s, sender in enumerate(("81000001", "81000002"))
    ]
    known = {
        (sender, s.sequence): s.samples
        for sender, one in zip(("81000001", "81000002"), two, strict=True)
        for s in one
    }
    both = [one.data for pair in zip(*two, strict=True) for one in pair]
    chunks = [data[: rng.integers(len(data))] if rng.random() < 0.3 else data for data in both]
    packets, parser = parsed(b"".join(chunks))

    for packet in packets:
        expected = known[packet.sender, packet.sequence]
        came = np.isfinite(packet.samples).all(axis=0)
        assert (packet.samples[:, came] == expected[:, came]).all()
    assert len(packets) <= len(known)
    if any(len(chunk) and not chunk.endswith(b"\n") for chunk in chunks):
        assert parser.rejected
