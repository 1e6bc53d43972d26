"""Logs: our own lose nothing, others are parsed, and both give the samples seen live."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactogram.errors import DataError
from tactogram_capture import SourceEnded, open_source, read_log
from tactogram_capture.stream.raw_log import RawLog, escaped, log_pieces, unescaped
from tactogram_capture.twelite.simulator import SimulatedReceiver


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


def test_a_damaged_line_in_our_own_log_is_named(tmp_path, write_log):
    path = tmp_path / "a.log"
    write_log(path, SimulatedReceiver(seconds=0.5))
    path.write_bytes(path.read_bytes().replace(b"\t", b" ", 1))

    with pytest.raises(DataError, match=r"a\.log, line 2: must be a time, a tab and bytes"):
        list(log_pieces(path))


def test_a_missing_file_and_an_existing_log_are_refused(tmp_path):
    with pytest.raises(DataError, match="no such file"):
        read_log(tmp_path / "none.log")
    with pytest.raises(DataError, match="no such file"):
        read_log(tmp_path / "\0.log")
    (tmp_path / "there.log").touch()
    with pytest.raises(DataError, match="must not exist yet"):
        RawLog(tmp_path / "there.log", kind="twelite", address="x")
