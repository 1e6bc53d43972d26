"""Growth of a store from 10^3 to 10^5 recordings: opening, finding, reading and memory, on a disk and an object store.

Recordings are simulated: noise of 0.25 s at 1 kHz on three axes. ``folder`` is a store as it is written, ``copy`` its
copy with a catalogue, ``s3`` that copy on an S3-like server on loopback (moto, which reads all of a shard for each
request: its times are its own). ``open_ms`` opens the store; ``index_us`` reads the metadata of all recordings, per
recording; ``random_us`` reads one recording at random, the median of 200; ``pass_us`` all samples in order, per
recording; ``gets`` counts the requests of that pass. ``own_mb`` is what this adds to the memory of a process (RssAnon):
after the reads at random, and after all metadata.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.fs as fs
from lightning_fabric.plugins.environments.lightning import find_free_network_port

from benchmarks.bench_processes import noise, own_mb
from tactogram.datasets import create_store, open_store
from tactogram.datasets.store.copying import copy_store

RECORDINGS = (1_000, 10_000, 100_000)
READ = 200
"""Recordings that are read at random."""


def run(recordings: tuple[int, ...] = RECORDINGS, folder: Path | None = None) -> list[dict[str, Any]]:
    """Return a row per number of recordings and place."""
    rows = []
    with tempfile.TemporaryDirectory(dir=folder, prefix="bench-store-scale-") as name, s3_server():
        for count in recordings:
            path = Path(name) / f"store{count}"
            begun = time.perf_counter()
            create_store(path, noise(count, seconds=0.25), name="noise", licence="CC0-1.0", simulated=True)
            writing = time.perf_counter() - begun
            copied, remote = Path(name) / f"copy{count}", f"s3://bench/store{count}"
            copy_store(path, copied)
            copy_store(path, remote)
            for place, where in {"folder": path, "copy": copied, "s3": remote}.items():
                rows.append({"where": place, "recordings": count} | _measured(where))
            facts = open_store(copied).facts
            rows[-3]["write_us"] = round(1e6 * writing / count)
            rows[-2]["catalogue_bytes"] = facts.catalogue.bytes / count if facts.catalogue else None
            rows[-2]["bytes"] = round(sum(file.bytes for file in facts.files) / count)
    return rows


def _measured(where: Path | str) -> dict[str, Any]:
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
    asked = _counted()
    first = open_store(where)  # imports, and the first connection
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
    asked.clear()
    begun = time.perf_counter()
    for id in held:
        store.signal(id, "acceleration")
    passing = time.perf_counter() - begun
    return {
        "open_ms": round(1e3 * float(np.median(opening)), 2),
        "index_us": round(1e6 * index / len(held), 1),
        "random_us": round(1e6 * float(np.median(reading))),
        "pass_us": round(1e6 * passing / len(held), 1),
        "gets": len(asked) or None,
        "own_mb_opened": round(opened, 1),
        "own_mb_with_index": round(own_mb() - before, 1),
    }


def _counted() -> list[int]:
    """Return a list that grows by each range that is requested of a remote file."""
    from tactogram.datasets.store.remote import RemotePath

    asked: list[int] = []
    opened = RemotePath.open

    class Counted:
        def __init__(self, file: Any) -> None:
            self.file = file

        def read_at(self, length: int, start: int) -> Any:
            asked.append(length)
            return self.file.read_at(length, start)

    def counting(self: RemotePath) -> Any:
        file = opened(self)
        return Counted(file) if "shard-" in self.path else file

    RemotePath.open = counting  # type: ignore[method-assign]
    return asked


@contextmanager
def s3_server() -> Iterator[None]:
    """Run an S3-like server with a bucket ``bench``, named in the environment."""
    port = find_free_network_port()
    os.environ |= {
        "AWS_ACCESS_KEY_ID": "bench",
        "AWS_SECRET_ACCESS_KEY": "bench",
        "AWS_REGION": "us-east-1",
        "AWS_ENDPOINT_URL": f"http://127.0.0.1:{port}",
    }
    server = Path(sys.prefix) / "s3" / "bin" / "moto_server"
    process = subprocess.Popen(
        [server, "-H", "127.0.0.1", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        system = fs.S3FileSystem(
            allow_bucket_creation=True, endpoint_override=f"127.0.0.1:{port}", scheme="http"
        )
        for _ in range(100):
            try:
                system.create_dir("bench")
                break
            except OSError:
                time.sleep(0.2)
        yield
    finally:
        process.terminate()
        process.wait()


if __name__ == "__main__":
    if sys.argv[1:]:
        print(json.dumps(measure(sys.argv[1])))
    else:
        for row in run():
            print(", ".join(f"{name} {value}" for name, value in row.items()), flush=True)
