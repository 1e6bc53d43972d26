"""Logs into files and stores, with their gaps."""

import json

import numpy as np
import pytest

from tactogram.datasets import open_store
from tactogram.errors import DataError, ParameterError
from tactogram.signal.io import read_file
from tactogram_capture import read_log
from tactogram_capture.twelite.simulator import SimulatedReceiver
from tactogram_capture.workflows.logs import capture_log


@pytest.fixture(name="log")
def log_fixture(tmp_path, write_log):
    path = tmp_path / "take.log"
    write_log(path, SimulatedReceiver(seconds=12, loss=0.02, seed=3))
    return path


def test_log_is_described_without_writing_anything(log, tmp_path):
    result = capture_log(log)
    [sensor] = result["sensors"]

    assert result["simulated"] is True
    assert sensor["rate"] == pytest.approx(330, rel=1e-3)
    assert sensor["facts"]["lost"] == 10 * sensor["facts"]["lost_packets"] > 0
    assert list(tmp_path.iterdir()) == [log]
    json.dumps(result)


def test_pieces_between_gaps_go_to_numbered_files_exactly(log, tmp_path):
    result = capture_log(log, out=tmp_path / "out.csv", rate=330)
    samples = read_log(log)[0].samples
    [sensor] = result["sensors"]

    assert len(sensor["signals"]) > 1
    for entry in sensor["signals"]:
        read = read_file(entry["file"])
        first = entry["first_index"]
        assert (read.signal.samples == samples[:, first : first + entry["samples"]]).all()
        assert read.signal.rate == 330
        assert read.metadata["simulated"] is True
        assert read.metadata["first_index"] == first


def test_filling_makes_one_file_and_says_how_much_was_filled(log, tmp_path):
    result = capture_log(log, out=tmp_path / "out.flac", fill=True, rate=330, most_s=0.2)
    [sensor] = result["sensors"]
    file = read_file(tmp_path / "out.flac")

    assert sensor["filled"]["samples"] == sensor["facts"]["lost"]
    assert file.metadata["filled"]["samples"] == sensor["facts"]["lost"]
    assert len(file.signal) == sensor["samples"]


def test_pieces_go_into_a_store_and_a_second_time_add_nothing(log, tmp_path):
    store = tmp_path / "store"
    first = capture_log(log, data=store, material="felt", speed_mm_s=100.0, contactor="finger", rate=330)
    again = capture_log(log, data=store, material="felt", speed_mm_s=100.0, contactor="finger", rate=330)
    stored = open_store(store)

    assert first["added"] == len(first["sensors"][0]["signals"]) == len(stored) > 1
    assert again["added"] == 0
    assert stored.simulated
    assert {info.material for info in stored.index} == {"felt"}
    assert {info.labels["sensor"] for info in stored.index} == {"81013C85"}
    assert all(info.history == ("read from a log", "pieces between gaps") for info in stored.index)


def test_log_without_times_needs_a_rate(log, tmp_path):
    plain = tmp_path / "plain.txt"
    plain.write_bytes(
        b"".join(
            line.split(b"\t")[1].replace(b"\\r\\n", b"\r\n") for line in log.read_bytes().splitlines(True)[1:]
        )
    )

    with pytest.raises(DataError, match="give `rate`"):
        capture_log(plain, out=tmp_path / "out.csv")
    assert not (tmp_path / "out.csv").exists()
    assert capture_log(plain, rate=330)["sensors"][0]["rate"] == 330


def test_a_gap_longer_than_may_be_filled_writes_nothing(log, tmp_path):
    with pytest.raises(DataError, match="longer than the limit for filling"):
        capture_log(log, out=tmp_path / "out.csv", fill=True, most_s=0.01)
    assert not (tmp_path / "out.csv").exists()


def test_what_is_asked_for_wrongly_is_refused(log, tmp_path):
    with pytest.raises(ParameterError, match="give `material`"):
        capture_log(log, data=tmp_path / "store")
    with pytest.raises(ParameterError, match="sender must be one of 81013C85, got '8123'"):
        capture_log(log, sender="8123")
    assert capture_log(log, sender="1013c85")["sensors"][0]["name"] == "81013C85"
    for rate in (0, -1, float("nan"), 1e300):
        with pytest.raises(ParameterError, match="rate must be"):
            capture_log(log, rate=rate)


def test_log_of_a_board_is_read_as_it_is_told(tmp_path):
    path = tmp_path / "board.txt"
    rows = "".join(f"{1000 * n},{np.sin(n / 5):.4f}\n" for n in range(1000) if n % 100 != 50)
    path.write_text(f"micros,force [mN]\n{rows}")
    [sensor] = capture_log(path, rate=1000, least_s=0.05)["sensors"]

    assert (sensor["unit"], sensor["axes"]) == ("N", ["force"])
    assert sensor["facts"]["lost"] == 10
    assert sensor["rate"] == 1000
    # The last of eleven pieces is 49 samples long.
    assert (len(sensor["signals"]), sensor["short"]) == (10, 1)
