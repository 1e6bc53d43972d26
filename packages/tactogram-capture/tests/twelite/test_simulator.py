"""Logs of a simulated receiver."""

import numpy as np
import pytest

from tactogram_capture import read_log
from tactogram_capture.twelite.simulator import SimulatedReceiver, transmissions

RECEIVER = SimulatedReceiver(seconds=3, loss=0.05, seed=4)


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
