"""Logs: our own lose nothing, others are parsed, and both give the samples seen live."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactogram.errors import DataError
from tactogram_capture import SourceEnded, open_source, read_log
from tactogram_capture.stream.raw_log import RawLog, escaped, log_pieces, unescaped
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


def drained(source):
    blocks = []
    with source:
        while True:
            try:
                block = source.read(0.5)
            except SourceEnded:
                return np.concatenate([b.samples for b in blocks], axis=1), source.facts()
            if block is not None:
                blocks.append(block)


@given(st.binary(max_size=300))
def test_escaping_keeps_every_byte_on_one_line(data):
    text = escaped(data)

    assert text.isascii()
    assert not set(text) & set("\r\n\t")
    assert unescaped(text) == data


@pytest.mark.parametrize("form", ["hex", "standard", "semicolon"])
def test_a_log_read_offline_gives_the_samples_seen_live(tmp_path, form):
    path = tmp_path / "take.log"
    address = f"simulated:twelite?seconds=0.6&loss=0.1&corrupt=0.0005&seed=5&form={form}&log={path}"
    live, live_facts = drained(open_source(address))
    [offline] = read_log(path)
    replayed, _ = drained(open_source(f"log:{path}"))

    assert np.array_equal(live, offline.samples, equal_nan=True)
    assert np.array_equal(live, replayed, equal_nan=True)
    assert {**live_facts, "others": {}} == {**offline.facts, "others": {}}
    assert offline.simulated
    assert np.isnan(live).any()


def test_written_log_has_the_losses_that_were_simulated(tmp_path, write_log):
    path = tmp_path / "a.log"
    sent = write_log(path, RECEIVER, start_s=100.0)
    lost = [s.sequence for s in transmissions(RECEIVER) if not s.data]
    [found] = read_log(path)

    assert sent == 99
    assert found.facts["lost_packets"] == len(lost) > 0
    assert sorted({i // 10 for i in np.flatnonzero(np.isnan(found.samples[0]))}) == lost
    assert found.rate.hz == pytest.approx(330, rel=2e-3)
    assert found.start_s == pytest.approx(100, abs=0.1)


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


def test_a_damaged_line_in_our_own_log_is_named(tmp_path, write_log):
    path = tmp_path / "a.log"
    write_log(path, SimulatedReceiver(seconds=0.5))
    path.write_bytes(path.read_bytes().replace(b"\t", b" ", 1))

    with pytest.raises(DataError, match=r"a\.log, line 2: must be a time, a tab and bytes"):
        list(log_pieces(path))


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


def test_a_missing_file_and_an_existing_log_are_refused(tmp_path):
    with pytest.raises(DataError, match="cannot be read"):
        read_log(tmp_path / "none.log")
    with pytest.raises(DataError, match="cannot be read"):
        read_log(tmp_path / "\0.log")
    (tmp_path / "there.log").touch()
    with pytest.raises(DataError, match="must not exist yet"):
        RawLog(tmp_path / "there.log", kind="twelite", address="x")


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
