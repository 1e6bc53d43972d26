"""Stop signals end a verb in order."""

import json
import os
import signal

from tactogram.cli import main
from tactogram_playback.transducer.simulation import SimulatedBench


def test_sigterm_ends_it_in_order_as_ctrl_c_does(tmp_path, capsys, monkeypatch):
    take, log = SimulatedBench.take, tmp_path / "track.csv"
    before = signal.getsignal(signal.SIGTERM)

    def killed(bench, seconds, *, after_s):
        if bench.clock_s > 6:
            os.kill(os.getpid(), signal.SIGTERM)
        return take(bench, seconds, after_s=after_s)

    monkeypatch.setattr(SimulatedBench, "take", killed)
    assert main(["track", "--display", "ultrasonic-envelope", "--out", str(log), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["interrupted"]
    assert 0 < found["steps"] < 100
    assert log.read_text().count("\n") == 1 + found["measured"]
    assert signal.getsignal(signal.SIGTERM) is before
