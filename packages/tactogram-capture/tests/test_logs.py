"""Logs that are read: raw ones, text of terminals, and XDF files."""

import struct

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactogram.errors import DataError
from tactogram_capture import read_log, read_xdf
from tactogram_capture.twelite.simulator import SimulatedReceiver, transmissions

RECEIVER = SimulatedReceiver(seconds=3, loss=0.05, seed=4)


def text_log(path, stamp, *, receiver=RECEIVER, newline="\r\n"):
    lines = [
        f"{stamp(s.time_s)}{line}{newline}"
        for s in transmissions(receiver)
        for line in s.data.decode().splitlines()
    ]
    path.write_bytes("".join(lines).encode())
    return path


@pytest.mark.parametrize(
    "stamp",
    [
        lambda t: f"{t:.4f} ",
        lambda t: f"[{t:.4f}] ",
        lambda t: f"{t:.4f}\t",
        lambda t: f"23:59:{58 + t:09.6f} -> " if t < 2 else f"00:00:{t - 2:09.6f} -> ",
        lambda t: f"2026-01-02T03:04:{5 + t:09.6f}+09:00 ",
        lambda t: f"2026-01-02 03:04:{5 + t:09.6f} > ",
    ],
    ids=["seconds", "brackets", "tab", "clock over midnight", "date", "date and arrow"],
)
def test_times_in_front_of_lines_are_parsed(tmp_path, stamp):
    [found] = read_log(text_log(tmp_path / "other.txt", stamp))

    assert found.rate.hz == pytest.approx(330, rel=3e-3)
    assert found.facts["rejected"] == {}
    assert found.facts["samples"] + found.facts["lost"] == 990


def test_a_log_without_times_has_the_samples_and_no_rate(tmp_path):
    timed, untimed = tmp_path / "timed.txt", tmp_path / "untimed.txt"
    [with_times] = read_log(text_log(timed, lambda t: f"{t:.4f} "))
    [without] = read_log(text_log(untimed, lambda t: "", newline="\n"))

    assert np.array_equal(with_times.samples, without.samples, equal_nan=True)
    assert without.rate is None


def test_the_receivers_own_clock_gives_the_rate_where_the_log_has_none(tmp_path):
    receiver = SimulatedReceiver(seconds=20, seed=1, form="semicolon", jitter_s=0.001)
    [found] = read_log(text_log(tmp_path / "semicolon.txt", lambda t: "", receiver=receiver))

    assert found.rate.hz == pytest.approx(330, rel=1e-3)


def test_utf_16_text_of_a_shell_is_read(tmp_path):
    path = text_log(tmp_path / "a.txt", lambda t: "")
    path.write_bytes(path.read_bytes().decode().encode("utf-16"))

    assert read_log(path)[0].facts["samples"] > 900


def test_two_sensors_on_one_receiver_are_separated(tmp_path):
    one = SimulatedReceiver(seconds=1, seed=1, sender="81000001")
    two = SimulatedReceiver(seconds=1, seed=2, sender="81000002", loss=0.2)
    both = sorted([*transmissions(one), *transmissions(two)], key=lambda s: s.time_s)
    path = tmp_path / "both.txt"
    path.write_bytes(b"".join(s.data for s in both))
    found = {logged.name: logged for logged in read_log(path)}

    for receiver in (one, two):
        sent = {s.sequence: s.samples for s in transmissions(receiver) if s.data}
        samples = found[receiver.sender].samples
        first = min(sent)
        for sequence, expected in sent.items():
            assert (samples[:, 10 * (sequence - first) : 10 * (sequence - first + 1)] == expected).all()
    assert found["81000001"].facts["lost"] == 0
    assert found["81000002"].facts["lost"] > 0


def test_a_kill_in_the_middle_of_a_line_costs_that_line_only(tmp_path, write_log):
    path = tmp_path / "a.log"
    write_log(path, SimulatedReceiver(seconds=1))
    whole = read_log(path)[0].samples
    path.write_bytes(path.read_bytes()[:-40])

    cut = read_log(path)[0].samples
    assert cut.shape[1] == whole.shape[1] - 10
    assert (cut == whole[:, :-10]).all()


@pytest.mark.parametrize(
    ("head", "line"),
    [
        (b"{", r"line 1: not a JSON document"),
        (b"[" * 4000, r"line 1: not a JSON document: nested too deep"),
        (b"[1]", r"line 1: must hold facts in JSON"),
        (b'{"kind": "tape"}', r"line 1: kind must be twelite or serial, got 'tape'"),
        (b'{"kind": "\xff"}', r"line 1: not UTF-8 text"),
        (b'{"kind": "\0"}', r"line 1: not a text file: zero byte"),
    ],
)
def test_a_damaged_head_is_refused_in_one_line(tmp_path, head, line):
    path = tmp_path / "a.log"
    path.write_bytes(b"# tactogram raw log " + head + b"\n1.0\tx\n")
    with pytest.raises(DataError, match=line) as caught:
        read_log(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"\n\n", b"hello\nworld\n", bytes(range(256)) * 8])
def test_a_file_without_samples_is_refused_in_one_line(tmp_path, content):
    path = tmp_path / "nothing.txt"
    path.write_bytes(content)

    with pytest.raises(DataError, match=r"nothing\.txt: contains no (packet|row)") as caught:
        read_log(path)
    assert "\n" not in str(caught.value)


@given(st.binary(max_size=2000))
def test_arbitrary_bytes_as_a_log_give_no_sample_and_no_crash(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("fuzz") / "x.log"
    path.write_bytes(data)
    with pytest.raises(DataError):
        read_log(path, kind="twelite")


@pytest.mark.parametrize("stamp", ["10:23:{:06.3f} -> ", "[10:23:{:06.3f}] ", "2026-01-02 10:23:{:06.3f}, "])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_log_of_a_boards_monitor_has_its_times_of_arrival(tmp_path, stamp, encoding):
    x = np.round(np.sin(np.arange(400) / 3) ** 3, 4)
    lines = ["ready", "x,y,z", *(f"{n},{-n},1.0" for n in x)]
    text = "".join(f"{stamp.format(i / 250)}{line}\n" for i, line in enumerate(lines))
    (tmp_path / "monitor.txt").write_text(text, encoding=encoding)
    [log] = read_log(tmp_path / "monitor.txt")

    assert log.axes == ("x", "y", "z")
    assert log.samples[0] == pytest.approx(x)
    assert log.rate.hz == pytest.approx(250, rel=1e-3)
    assert "no unit stated" in log.facts["notes"][-1]


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
