"""Benchmark of sensor parsing: times real time at which logs are parsed, and what a pty carries. All data is simulated.

"times real time" is the length of the recording over the processor time that parsing it takes, in one thread: the ratio
does not depend on what else the machine does. What a pty carries does: both ends and all else share its cores.
Ten-sample packets at 330 Hz are what Saga et al. record; 690 Hz is all that 115200 baud carry.
"""

import tempfile
import time
from pathlib import Path

from tactogram_capture import SourceEnded, read_log
from tactogram_capture.twelite.parser import TweliteParser
from tactogram_capture.twelite.simulator import SimulatedPort, SimulatedReceiver, transmissions, write_log
from tactogram_capture.twelite.source import TweliteSource

SECONDS = 120


def run():
    rows = [parsing(form, mode) for form in ("hex", "standard", "semicolon") for mode in ("fifo", "single")]
    return [*rows, whole_log(), *(port(rate) for rate in (330, 690, 3300, 33000, 330000))]


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


def port(rate):
    """Return what came of a simulated receiver that prints in real time: both ends on the same machine."""
    receiver = SimulatedReceiver(rate=rate, seconds=3, loss=0.02, seed=1)
    simulated = SimulatedPort(receiver)
    source = TweliteSource(simulated, name="simulated:twelite", simulated=True)
    start, seconds = time.process_time(), time.monotonic()
    with source:
        while True:
            try:
                source.read(0.2)
            except SourceEnded:
                break
    took = time.monotonic() - seconds
    facts = source.facts()
    return {
        "what": f"pty, {rate} Hz asked for",
        "samples/s": (facts["samples"] + facts["lost"]) / took,
        "lost as simulated": facts["lost_packets"] == simulated.lost,
        "bytes rejected": facts["bytes_rejected"],
        "cores (both ends)": (time.process_time() - start) / took,
    }


def best(work, times=3):
    durations = []
    for _ in range(times):
        start = time.process_time()
        work()
        durations.append(time.process_time() - start)
    return min(durations)
