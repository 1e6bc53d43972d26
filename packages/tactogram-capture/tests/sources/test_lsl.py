"""Lab Streaming Layer: looped back in one process, and the files of its recorders."""

import struct
import time

import numpy as np
import pytest

from tactogram.errors import DataError, DeviceError
from tactogram.extras import lsl
from tactogram_capture import SourceLost, open_source, read_xdf
from tactogram_capture.stream.channels import described_unit, split_at_gaps


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


def test_jitter_of_stamps_is_no_gap_and_a_stream_without_rate_has_none():
    stamps = np.cumsum(np.random.default_rng(1).exponential(0.01, 200))
    samples = np.zeros((1, 200), np.float32)

    assert sum(p.shape[1] for p in split_at_gaps(samples, stamps, 100.0, None)) == 200
    assert split_at_gaps(samples, stamps * 100, None, None)[0].shape == (1, 200)


def test_unit_is_the_given_one_else_that_of_all_channels_else_counts():
    assert described_unit("mg", ["V", "V"])[0] == "m/s^2"
    assert described_unit(None, ["mV", "mV"]) == ("V", pytest.approx(1e-3))
    assert described_unit(None, ["mV", "g"]) == ("1", 1.0)
    assert described_unit(None, ["microvolts"]) == ("V", pytest.approx(1e-6))
    assert described_unit(None, ["arbitrary"]) == ("1", 1.0)


def xdf_bytes(stamps, rows, *, rate=100.0, channel_format="float32"):
    """Return a small XDF file: one stream with every sample's own stamp."""

    def chunk(tag, content):
        body = struct.pack("<H", tag) + content
        return b"\x04" + struct.pack("<I", len(body)) + body

    channels = "".join(f"<channel><label>{c}</label><unit>mV</unit></channel>" for c in "ab"[: len(rows[0])])
    head = (
        f"<?xml version='1.0'?><info><name>force</name><type>Force</type><channel_count>{len(rows[0])}"
        f"</channel_count><nominal_srate>{rate}</nominal_srate><channel_format>{channel_format}</channel_format>"
        f"<created_at>0</created_at><desc><channels>{channels}</channels></desc></info>"
    )
    samples = b"".join(
        b"\x08" + struct.pack("<d", t) + struct.pack(f"<{len(row)}f", *row)
        for t, row in zip(stamps, rows, strict=True)
    )
    foot = (
        f"<?xml version='1.0'?><info><first_timestamp>{stamps[0]}</first_timestamp><last_timestamp>{stamps[-1]}"
        f"</last_timestamp><sample_count>{len(stamps)}</sample_count><measured_srate>{rate}</measured_srate></info>"
    )
    stream = struct.pack("<I", 1)
    return (
        b"XDF:"
        + chunk(1, b"<?xml version='1.0'?><info><version>1.0</version></info>")
        + chunk(2, stream + head.encode())
        + chunk(3, stream + b"\x04" + struct.pack("<I", len(stamps)) + samples)
        + chunk(6, stream + foot.encode())
    )


def test_xdf_file_is_read_with_its_channels_units_and_gaps(tmp_path):
    places = [*range(300), *range(500, 900)]
    path = tmp_path / "take.xdf"
    path.write_bytes(xdf_bytes([7 + n / 100 for n in places], [[n, -n] for n in places]))
    [found] = read_xdf(path)

    assert (found.name, found.axes, found.unit) == ("force", ("a", "b"), "V")
    assert found.samples.shape == (2, 900)
    assert np.isnan(found.samples[:, 300:500]).all()
    assert found.samples[0, 500:] == pytest.approx(np.arange(500, 900) * 1e-3)
    assert found.facts["lost"] == 200
    assert found.rate.hz == pytest.approx(100, rel=1e-3)


@pytest.mark.parametrize("content", [b"", b"XDF:", b"hello", b"XDF:\x04\xff\xff\xff\xff\x03\x00"])
def test_an_invalid_xdf_file_is_refused_in_one_line(tmp_path, content):
    path = tmp_path / "bad.xdf"
    path.write_bytes(content)
    with pytest.raises(DataError, match=r"bad\.xdf") as caught:
        read_xdf(path)
    assert "\n" not in str(caught.value)


def changed(content, old, new):
    assert content.count(old) == 1
    return content.replace(old, new)


WHOLE = xdf_bytes([n / 100 for n in range(50)], [[n, -n] for n in range(50)])


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (
            changed(WHOLE, b"<type>Force</type><channel_count>2", b"<channel_count>9" + b"9" * 18),
            "not readable as XDF",
        ),
        (xdf_bytes([n * 1e6 for n in range(50)], [[n, n] for n in range(50)]), "time stamps jump 49 times"),
    ],
)
def test_an_xdf_file_that_would_fill_the_memory_is_refused(tmp_path, content, line):
    path = tmp_path / "bad.xdf"
    path.write_bytes(content)
    with pytest.raises(DataError, match=line) as caught:
        read_xdf(path)
    assert "\n" not in str(caught.value)


def test_skipped_parts_of_a_damaged_xdf_file_are_reported_and_not_printed(tmp_path, capfd, caplog):
    path = tmp_path / "damaged.xdf"
    path.write_bytes(WHOLE + b"\x07" + bytes(20))
    [found] = read_xdf(path)
    assert found.facts["samples"] == 50
    assert "Error reading chunk length" in found.facts["damaged"]
    assert capfd.readouterr() == ("", "")
    assert not caplog.records
