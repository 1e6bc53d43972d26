"""Participants at once against the server of ``tactogram study run``, over HTTP, from consent to end.

The study `abx` (simulated stimuli) with its 4 trials of practice and 16 that count. Participants are simulated:
threads of another process on the same machine, each with a connection of its own. They come 10 s after the server,
which makes its stimuli ahead. "1 to 3 s" is how long they think on each page, after fetching its three sounds of 1 s;
"all at once" is nobody thinking, and no sounds: every answer meets 29 others. An answer's time is from sending it
until the next page is there; it is on the disk then (SQLite, WAL, full sync). "lost" are answers that were
acknowledged and are not in the store, "doubled" pages that stand there twice, both counted after the end. "processor"
is what the server had of the processors for each answer, with its page and sounds and what it still made ahead. "disk"
is the p99 of 200 flushes of 8 KiB to that disk just before, with nobody there: where nobody thinks, a slow one holds up
all 30. "load" is the machine's load average at the beginning: above the number of cores, times are those of a busy
machine, unless "nice" is below 0: then server and participants went before all other work.
"""

from __future__ import annotations

import http.client
import json
import os
import random
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path
from urllib.parse import urlencode, urlsplit

import numpy as np
import psutil

from tactogram_study.session.store import SessionStore

CASES = (("1 to 3 s", (1.0, 3.0), 30, 2), ("all at once", None, 30, 5))
"""How they are called, seconds of thinking, participants, repetitions."""
READY_S = 10.0
"""Before anybody joins: the server makes its stimuli ahead."""
REPEATS = 4
"""Of each texture's trial."""


def run():
    rows = []
    for pace, thinking, participants, repetitions in CASES:
        for repetition in range(repetitions):
            load = os.getloadavg()[0]
            with tempfile.TemporaryDirectory() as folder:
                disk = flushed_ms(Path(folder) / "flushed")
                found = taken(Path(folder) / "session", participants, thinking)
            rows.append(
                {
                    "participants": participants,
                    "pace": pace,
                    "repetition": repetition + 1,
                    **found,
                    "disk p99 ms": disk,
                    "load": load,
                    "nice": os.nice(0),
                }
            )
            sys.stderr.write(f"{rows[-1]}\n")
    return rows


def flushed_ms(path):
    """Return the p99 of 200 flushes of 8 KiB, appended to a file."""
    found = []
    with path.open("wb", buffering=0) as file:
        for _ in range(200):
            file.write(bytes(8192))
            begun = time.perf_counter()
            os.fsync(file.fileno())
            found.append(time.perf_counter() - begun)
    return 1e3 * float(np.percentile(found, 99))


def taken(folder, participants, thinking):
    """Let so many take the study, and return how long answers took and what the store holds of them."""
    arguments = ["study", "run", "abx", "--out", str(folder), "--port", "0", "--no-open", "--json"]
    arguments += ["--set", f"design.repeats={REPEATS}"]
    process = subprocess.Popen(
        [sys.executable, "-m", "tactogram", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        facts = json.loads(process.stdout.readline())
        time.sleep(READY_S)
        server = psutil.Process(process.pid)
        before, begun = sum(server.cpu_times()[:2]), time.perf_counter()
        people = [Simulated(facts["join"], thinking, seed) for seed in range(participants)]
        for one in people:
            one.start()
        for one in people:
            one.join()
        wall, busy = time.perf_counter() - begun, sum(server.cpu_times()[:2]) - before
    finally:
        process.terminate()
        process.wait(30)
        process.stdout.close()
    answers = 1e3 * np.concatenate([one.answer_s for one in people])
    sounds = 1e3 * np.concatenate([one.sound_s for one in people]) if thinking else np.zeros(0)
    return {
        "answers": len(answers),
        "answers/s": len(answers) / wall,
        "processor ms": 1e3 * busy / len(answers),
        "p50 ms": float(np.percentile(answers, 50)),
        "p99 ms": float(np.percentile(answers, 99)),
        "max ms": float(answers.max()),
        "sound p50 ms": float(np.percentile(sounds, 50)) if len(sounds) else None,
        "sound p99 ms": float(np.percentile(sounds, 99)) if len(sounds) else None,
        **counted(folder, people),
    }


def counted(folder, people):
    """Return what of the acknowledged answers is not in the store, and what stands there twice."""
    with SessionStore(folder) as store:
        rows = Counter((row.participant, row.more["token"]) for row in store.answers())
        ended = sum(store.state(one.code) == "done" for one in people)
        enrolled = len(store.participants())
    said = {(one.code, token) for one in people for token in one.acknowledged}
    return {
        "lost": len(said - set(rows)),
        "doubled": sum(count > 1 for count in rows.values()) + enrolled - len(people),
        "ended": ended,
    }


class Simulated(threading.Thread):
    """A simulated participant with a connection."""

    def __init__(self, address, thinking, seed):
        super().__init__()
        parts = urlsplit(address)
        self.connection = http.client.HTTPConnection(parts.netloc, timeout=60)
        self.join_path, self.thinking, self.random = parts.path, thinking, random.Random(seed)
        self.answer_s, self.sound_s, self.acknowledged = [], [], []

    def run(self):
        """Take the study."""
        joined = self.asked(
            "POST",
            self.join_path,
            {"language": "en", "attempt": f"simulated-{self.join_path[-8:]}-{id(self)}"},
        )
        self.code, base = joined["code"], f"/take/{joined['ticket']}"
        page = self.asked("GET", f"{base}/page")["page"]
        while page is not None:
            if self.thinking:
                for slot in page["slots"]:
                    query = urlencode({"token": page["token"], "slot": slot["slot"]})
                    begun = time.perf_counter()
                    self.asked("GET", f"{base}/sound?{query}")
                    self.sound_s.append(time.perf_counter() - begun)
                time.sleep(self.random.uniform(*self.thinking))
            given = {"token": page["token"], "answers": {q["key"]: self.answer(q) for q in page["questions"]}}
            begun = time.perf_counter()
            answered = self.asked("POST", f"{base}/answers", {**given, "rt_ms": {"": 900.0}})
            self.answer_s.append(time.perf_counter() - begun)
            self.acknowledged.append(page["token"])
            page = answered["page"]

    def answer(self, question):
        """Return some answer to a question."""
        values = [option["value"] for option in question["options"]]
        if not values:
            return "" if question["kind"] == "text" else str(question["low"] or 1)
        return values[0] if "agreed" in values else self.random.choice(values)

    def asked(self, method, path, body=None):
        """Return what the server answers: JSON values, or bytes."""
        headers = {"Content-Type": "application/json"} if body is not None else {}
        self.connection.request(method, path, None if body is None else json.dumps(body), headers)
        answer = self.connection.getresponse()
        data = answer.read()
        if answer.status != 200:
            raise RuntimeError(
                f"{method} {path.partition('?')[0].rpartition('/')[2]}: {answer.status} {data[:200]!r}"
            )
        return json.loads(data) if answer.headers["content-type"] == "application/json" else data
