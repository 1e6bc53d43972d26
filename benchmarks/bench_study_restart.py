"""The server of ``tactogram study run`` killed twice while participants answer: what is lost, when it answers again.

100 simulated participants take the study `abx` (simulated stimuli), each thinking for 1 to 3 s on a page. They come
once the server has made its stimuli. The server is killed (SIGKILL) after 20 s and after 40 s, and started again at
once; a participant's request that fails is repeated every 0.2 s, as the pages repeat theirs. "answering s" is from the
start of the process until a join page was there, with all of them waiting; "processor s" is what it had of the
processors by then. "lost" and "doubled" are those of `study_server`. A last row starts the server once more on the
finished session, with nobody waiting. "load" is the machine's load average: above the number of cores, seconds are
those of a busy machine.
"""

from __future__ import annotations

import http.client
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from urllib.parse import urlsplit

import psutil

from benchmarks.bench_study_server import READY_S, REPEATS, Simulated, counted

PARTICIPANTS, THINKING_S = 100, (1.0, 3.0)
KILLED_AFTER_S = (20.0, 20.0)


def run():
    rows = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "session"
        process, facts, _ = started(
            "abx", "--out", folder, "--port", "0", "--set", f"design.repeats={REPEATS}"
        )
        time.sleep(READY_S)
        people = [Persistent(facts["join"], THINKING_S, seed) for seed in range(PARTICIPANTS)]
        for one in people:
            one.start()
        for wait_s in KILLED_AFTER_S:
            time.sleep(wait_s)
            acknowledged = sum(len(one.acknowledged) for one in people)
            killed(process)
            process, _, figures = started(folder, "--port", str(urlsplit(facts["join"]).port))
            rows.append({"waiting": PARTICIPANTS, "acknowledged": acknowledged, **figures})
        for one in people:
            one.join()
        killed(process)
        process, _, figures = started(folder, "--port", "0")
        killed(process)
        found = counted(folder, people)
        acknowledged = sum(len(one.acknowledged) for one in people)
    return [*rows, {"waiting": 0, "acknowledged": acknowledged, **figures, **found}]


def started(*arguments):
    """Start the server, and return its process, its facts, and how long it took until it gave a join page."""
    load, begun = os.getloadavg()[0], time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "tactogram", "study", "run", *map(str, arguments), "--no-open", "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    facts = json.loads(process.stdout.readline())
    address = urlsplit(facts["join"])
    connection = http.client.HTTPConnection(address.netloc, timeout=60)
    connection.request("GET", address.path)
    if connection.getresponse().status != 200:
        raise RuntimeError("no join page")
    seconds, times = time.perf_counter() - begun, psutil.Process(process.pid).cpu_times()
    connection.close()
    figures = {"answering s": seconds, "processor s": times.user + times.system, "load": load}
    return process, facts, figures


def killed(process):
    """End a server without a chance to store anything."""
    process.kill()
    process.wait()
    process.stdout.close()


class Persistent(Simulated):
    """A simulated participant who repeats a request until the server answers."""

    def asked(self, method, path, body=None):
        """Return what the server answers, maybe after a restart."""
        while True:
            try:
                return super().asked(method, path, body)
            except (OSError, http.client.HTTPException):
                self.connection.close()
                time.sleep(0.2)
