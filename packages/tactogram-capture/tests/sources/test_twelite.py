"""A live receiver: simulated, on a pty, faster than any real one, unplugged, and among other sensors."""

import os

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram_capture import Source, SourceEnded, SourceLost, open_source
from tactogram_capture.twelite.simulator import SimulatedPort, SimulatedReceiver, transmissions
from tactogram_capture.twelite.source import TRUE_STEP, TweliteSource, serial_number


def drained(source):
    blocks = []
    with source:
        while True:
            try:
                block = source.read(1.0)
            except SourceEnded:
                return blocks
            if block is not None:
                blocks.append(block)


@pytest.mark.parametrize("form", ["hex", "standard"])
def test_two_hundred_times_faster_than_a_real_one_nothing_is_lost_on_the_way(form):
    receiver = SimulatedReceiver(rate=66000, seconds=0.5, form=form, jitter_s=0.0)
    source = TweliteSource(SimulatedPort(receiver, paced=False), name="simulated:twelite", simulated=True)
    samples = np.concatenate([b.samples for b in drained(source)], axis=1)

    assert (samples == np.concatenate([s.samples for s in transmissions(receiver)], axis=1)).all()
    assert source.facts()["bytes_rejected"] == 0


def test_damaged_bytes_lose_samples_and_never_change_one():
    receiver = SimulatedReceiver(seconds=20, corrupt=0.001, seed=2, rate=330)
    source = TweliteSource(SimulatedPort(receiver, paced=False), name="simulated:twelite", simulated=True)
    samples = np.concatenate([b.samples for b in drained(source)], axis=1)
    sent = list(transmissions(receiver))
    first = next(one.sequence for one in sent if not one.damaged)
    expected = np.concatenate([one.samples for one in sent[first:]], axis=1)[:, : samples.shape[1]]

    came = np.isfinite(samples).all(axis=0)
    assert (samples[:, came] == expected[:, came]).all()
    damaged = sum(one.damaged for one in sent)
    assert 0 < damaged < 0.25 * len(sent)
    assert sum(source.facts()["rejected"].values()) >= 0.9 * damaged
    assert source.facts()["lost"] <= 10 * damaged


@pytest.fixture(name="pty")
def pty_fixture():
    """Give a function that prints at a pseudo-terminal, its path, and one that unplugs it."""
    tty = pytest.importorskip("tty")
    ends = os.openpty()
    tty.setraw(ends[1])
    handles = [*ends]

    def unplug():
        while handles:
            os.close(handles.pop())

    yield lambda data: os.write(ends[0], data), os.ttyname(ends[1]), unplug
    unplug()


def test_a_receiver_on_a_serial_port_is_read_and_a_pulled_plug_reported_in_one_line(pty):
    write, path, unplug = pty
    sent = list(transmissions(SimulatedReceiver(seconds=0.3)))
    with open_source(f"twelite:{path}?rate=330") as source:
        write(b"".join(one.data for one in sent))
        blocks = []
        while sum(map(len, blocks)) < 90:
            blocks += [block] if (block := source.read(1.0)) is not None else []
        assert (
            np.concatenate([b.samples for b in blocks], axis=1)
            == np.concatenate([one.samples for one in sent], axis=1)
        ).all()
        unplug()
        with pytest.raises(SourceLost, match="disappeared while it was read") as caught:
            source.read(0.05)
    assert "\n" not in str(caught.value)


def test_the_wanted_sensor_is_read_and_the_others_counted():
    wanted, other = (
        b"".join(s.data for s in transmissions(SimulatedReceiver(seconds=0.2, sender=sender)))
        for sender in ("81000002", "81000001")
    )
    stream = Bytes(other + wanted)
    source = TweliteSource(stream, name="x", sender="1000002")
    blocks = drained(source)

    assert sum(len(b) for b in blocks) == 60
    assert source.facts()["sender"] == "81000002"
    assert source.facts()["others"] == {"81000001": 60}


class Bytes:
    """A stream of the given bytes, a few at a time."""

    def __init__(self, data):
        self.name, self.data = "bytes", data

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def read(self, timeout_s):
        if not self.data:
            raise SourceEnded("bytes: is over")
        piece, self.data = self.data[:7], self.data[7:]
        return piece, 1.0


def test_the_first_sensor_received_is_read_by_default():
    data = b"".join(s.data for s in transmissions(SimulatedReceiver(seconds=0.1, sender="81000007")))
    source = TweliteSource(Bytes(data), name="x")
    drained(source)

    assert source.facts()["sender"] == "81000007"


def test_full_scale_follows_the_scale():
    """The sensor has 4095 steps, whatever their scale."""
    for scale in (1.0, TRUE_STEP, 0.9):
        largest = 4095 * 4e-3 * 9.80665 * scale
        full_scale = TweliteSource(Bytes([]), name="x", scale=scale).full_scale
        assert 0.95 * largest < full_scale <= 1.001 * largest


def test_the_scale_of_the_data_sheet_can_be_chosen():
    data = b"".join(s.data for s in transmissions(SimulatedReceiver(seconds=0.1)))
    plain = np.concatenate([b.samples for b in drained(TweliteSource(Bytes(data), name="x"))], axis=1)
    scaled = drained(TweliteSource(Bytes(data), name="x", scale=TRUE_STEP))

    assert np.concatenate([b.samples for b in scaled], axis=1) == pytest.approx(plain * 0.9765625)


@pytest.mark.parametrize(("text", "number"), [("1013C85", "81013C85"), ("81013c85", "81013C85")])
def test_serial_numbers_are_accepted_as_printed_and_as_sent(text, number):
    assert serial_number(text) == number


@pytest.mark.parametrize("text", ["", "13C85", "91013C85", "hello"])
def test_an_invalid_serial_number_is_refused(text):
    with pytest.raises(ParameterError, match="7 hex digits"):
        serial_number(text)


def test_a_receiver_is_a_source():
    assert isinstance(open_source("simulated:twelite"), Source)


def test_a_read_without_data_returns_none_in_time():
    with open_source("simulated:twelite?loss=0.999999") as source:
        assert source.read(0.05) is None


def test_a_log_that_cannot_be_written_stops_before_the_port_is_opened(tmp_path):
    (tmp_path / "there.log").touch()
    port = SimulatedPort(SimulatedReceiver())
    with pytest.raises(Exception, match="must not exist yet"):
        TweliteSource(port, name="x", log=tmp_path / "there.log").__enter__()
    assert port.sent == 0
