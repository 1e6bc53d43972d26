"""Growth of a store from 10^3 to 10^5 recordings: opening, finding, reading and memory.

Recordings are simulated: noise of 0.25 s at 1 kHz on three axes. ``open_ms`` opens the store; ``index_us`` reads the
metadata of all recordings, per recording; ``random_us`` reads one recording at random, the median of 200; ``pass_us``
all samples in order, per recording. ``own_mb`` is what this adds to the memory of a process (RssAnon): after the reads
at random, and after all metadata.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets import Recording, create_store, open_store
from tactogram.signal import Signal

RECORDINGS = (1_000, 10_000, 100_000)
READ = 200
"""Recordings that are read at random."""
MATERIALS = 20


def run(recordings: tuple[int, ...] = RECORDINGS, folder: Path | None = None) -> list[dict[str, Any]]:
    """Return a row per number of recordings."""
    rows = []
    with tempfile.TemporaryDirectory(dir=folder, prefix="bench-store-scale-") as name:
        for count in recordings:
            path = Path(name) / f"store{count}"
            begun = time.perf_counter()
            create_store(path, noise(count), name="noise", licence="CC0-1.0", simulated=True)
            writing = time.perf_counter() - begun
            rows.append({"recordings": count} | _measured(path) | {"write_us": round(1e6 * writing / count)})
    return rows


def noise(count: int, *, seconds: float = 0.25, rate: float = 1000.0) -> Iterator[Recording]:
    """Yield simulated recordings: noise on three axes, of a level that depends on the material."""
    for number in range(count):
        material = number % MATERIALS
        rng = np.random.default_rng(number)
        samples = (1 + material) * rng.standard_normal((3, round(seconds * rate)), np.float32)
        yield Recording(
            streams={"acceleration": Signal(samples, rate, "m/s^2")},
            material=f"material {material}",
            source=str(number),
            simulated=True,
        )


def _measured(where: Path) -> dict[str, Any]:
    """Measure in a process of its own."""
    text = subprocess.run(
        [sys.executable, "-m", "benchmarks.bench_store_scale", str(where)],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    facts: dict[str, Any] = json.loads(text)
    return facts


def measure(where: str) -> dict[str, Any]:
    """Return what opening and reading the store at ``where`` costs; runs as a process of its own."""
    first = open_store(where)  # imports
    first.info(first._ids["id"][0].decode())
    del first
    before = own_mb()
    opening = []
    for _ in range(5):
        begun = time.perf_counter()
        store = open_store(where)
        opening.append(time.perf_counter() - begun)
    rng = np.random.default_rng(0)
    ids = [id.decode() for id in rng.choice(store._ids["id"], READ)]
    reading = []
    for id in ids:
        begun = time.perf_counter()
        store.signal(id, "acceleration")
        reading.append(time.perf_counter() - begun)
    opened = own_mb() - before
    begun = time.perf_counter()
    held = [info.id for info in store.index]
    index = time.perf_counter() - begun
    begun = time.perf_counter()
    for id in held:
        store.signal(id, "acceleration")
    passing = time.perf_counter() - begun
    return {
        "open_ms": round(1e3 * float(np.median(opening)), 2),
        "index_us": round(1e6 * index / len(held), 1),
        "random_us": round(1e6 * float(np.median(reading))),
        "pass_us": round(1e6 * passing / len(held), 1),
        "own_mb_opened": round(opened, 1),
        "own_mb_with_index": round(own_mb() - before, 1),
    }


def own_mb() -> float:
    """Return the resident memory of this process that no file backs."""
    found = re.search(r"RssAnon:\s+(\d+) kB", Path("/proc/self/status").read_text())
    return int(found[1]) / 1024 if found else float("nan")


if __name__ == "__main__":
    print(json.dumps(measure(sys.argv[1])))
