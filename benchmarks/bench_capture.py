"""Benchmark of sensor parsing: times real time at which logs are parsed. All data is simulated.

"times real time" is the length of the recording over the processor time that parsing it takes, in one thread: the ratio
does not depend on what else the machine does.
Ten-sample packets at 330 Hz are what Saga et al. record; 690 Hz is all that 115200 baud carry.
"""

import tempfile
import time
from pathlib import Path

from tactogram_capture import read_log
from tactogram_capture.twelite.parser import TweliteParser
from tactogram_capture.twelite.simulator import SimulatedReceiver, transmissions, write_log

SECONDS = 120


def run():
    rows = [parsing(form, mode) for form in ("hex", "standard", "semicolon") for mode in ("fifo", "single")]
    return [*rows, whole_log()]


def parsing(form, mode):
    rate = 330 if mode == "fifo" else 33
    receiver = SimulatedReceiver(form=form, mode=mode, rate=rate, seconds=SECONDS, loss=0.02)
    data = b"".join(sent.data for sent in transmissions(receiver))
    took = best(lambda: fed(data))
    return {
        "what": f"{form}, {mode}, {rate} Hz",
        "times real time": SECONDS / took,
        "MB/s": len(data) / took / 1e6,
    }


def fed(data):
    parser = TweliteParser()
    for start in range(0, len(data), 4096):
        parser.feed(data[start : start + 4096])
    parser.finish()


def whole_log():
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.log"
        write_log(path, SimulatedReceiver(seconds=SECONDS, loss=0.02))
        took = best(lambda: read_log(path))
        return {
            "what": "a whole log to samples with gaps and a rate",
            "times real time": SECONDS / took,
            "MB/s": path.stat().st_size / took / 1e6,
        }


def best(work, times=3):
    durations = []
    for _ in range(times):
        start = time.process_time()
        work()
        durations.append(time.process_time() - start)
    return min(durations)
