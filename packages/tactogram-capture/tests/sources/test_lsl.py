"""Lab Streaming Layer: looped back in one process, and the files of its recorders."""

import time

import numpy as np
import pytest

from tactogram.errors import DeviceError
from tactogram.extras import lsl
from tactogram_capture import SourceLost, open_source


def outlet(name, *, channels=3, rate=1000.0, unit="g", kind="Acceleration"):
    pylsl = lsl()
    info = pylsl.StreamInfo(name, kind, channels, rate, "float32", f"{name}-id")
    described = info.desc().append_child("channels")
    for label in ("ax", "ay", "az")[:channels]:
        described.append_child("channel").append_child_value("label", label).append_child_value("unit", unit)
    return pylsl, pylsl.StreamOutlet(info)


def read_for(source, seconds):
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        source.read(0.1)


def test_samples_arrive_exactly_in_the_streams_own_unit():
    _, out = outlet("tactogram-test-1")
    x = np.random.default_rng(0).standard_normal((500, 3)).astype(np.float32)
    with open_source("lsl:tactogram-test-1") as source:
        out.push_chunk(x.tolist())
        blocks, until = [], time.monotonic() + 5
        while sum(map(len, blocks)) < 500 and time.monotonic() < until:
            if (block := source.read(0.2)) is not None:
                blocks.append(block)
        facts = source.facts()

    assert (source.axes, source.unit, source.rate) == (("ax", "ay", "az"), "m/s^2", 1000.0)
    got = np.concatenate([b.samples for b in blocks], axis=1)
    assert (got == (x.T.astype(np.float64) * 9.80665).astype(np.float32)).all()
    assert (facts["samples"], facts["lost"]) == (500, 0)


def test_a_jump_of_the_time_stamps_is_a_gap_in_its_place():
    pylsl, out = outlet("tactogram-test-2", channels=1, rate=100.0)
    start = pylsl.local_clock()
    with open_source("lsl:tactogram-test-2?unit=1") as source:
        for n in [*range(20), *range(50, 60)]:
            out.push_sample([float(n)], start + n / 100)
        pieces, until = [], time.monotonic() + 5
        while sum(map(len, pieces)) < 60 and time.monotonic() < until:
            if (block := source.read(0.2)) is not None:
                pieces.append(block)
    got = np.concatenate([b.samples for b in pieces], axis=1)[0]

    assert got[:20].tolist() == list(range(20))
    assert np.isnan(got[20:50]).all()
    assert got[50:].tolist() == list(range(50, 60))
    assert source.facts()["lost"] == 30


def test_a_stream_that_is_closed_is_lost():
    _, out = outlet("tactogram-test-3")
    with open_source("lsl:tactogram-test-3") as source:
        out.push_sample([1.0, 2.0, 3.0])
        assert source.read(2.0) is not None
        del out
        with pytest.raises(SourceLost, match="disappeared while it was read"):
            read_for(source, 5.0)


def test_no_stream_and_a_stream_of_text_are_refused():
    pylsl = lsl()
    out = pylsl.StreamOutlet(pylsl.StreamInfo("tactogram-test-4", "Markers", 1, 0, "string", "m"))
    with pytest.raises(DeviceError, match="no stream of the name"), open_source("lsl:none?find_s=0.05"):
        pass
    with pytest.raises(DeviceError, match="contains text"), open_source("lsl:tactogram-test-4"):
        pass
    del out
