"""Logs as sources."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram_capture import SourceEnded, open_source
from tactogram_capture.twelite.simulator import SimulatedReceiver


def samples_of(address):
    blocks = []
    with open_source(address) as source:
        while True:
            try:
                block = source.read(1.0)
            except SourceEnded:
                return np.concatenate(blocks, axis=1), source
            if block is not None:
                blocks.append(block.samples)


def test_a_receivers_log_is_read_as_that_of_a_simulation(write_log, tmp_path):
    write_log(tmp_path / "raw.log", SimulatedReceiver(seconds=2, loss=0.0, seed=1))
    samples, source = samples_of(f"log:{tmp_path / 'raw.log'}")
    assert samples.shape[0] == 3
    assert samples.shape[1] == pytest.approx(660, abs=20)
    assert np.isfinite(samples).all()
    assert source.facts()["simulated"] is True


def test_lines_of_a_board_are_read_by_its_format(tmp_path):
    (tmp_path / "board.log").write_text("".join(f"{n},{-n}\n" for n in range(200)))
    samples, source = samples_of(f"log:{tmp_path / 'board.log'}?kind=serial&rate=100")
    np.testing.assert_array_equal(samples[-1][-50:], -np.arange(150, 200))
    assert not source.facts().get("simulated")


def test_a_log_needs_its_file_and_a_known_kind(tmp_path):
    with pytest.raises(ParameterError, match="the file"):
        open_source("log:")
    (tmp_path / "x.log").write_text("1,2\n")
    with pytest.raises(ParameterError, match="kind"):
        open_source(f"log:{tmp_path / 'x.log'}?kind=tape")
