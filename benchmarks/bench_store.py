"""The store: importing a set of the shape of Cluster's in four sizes, and reading it back by the window.

Samples are random, so these are simulated recordings; the files and the importer are those of production: CSV with
jittered stamps at 6 kHz (acceleration, force) and 100 Hz (position), strokes of 100 mm at 20 to 60 mm/s.
Sound is left out: it would add disk space, not another kind of work.
"""

from __future__ import annotations

import itertools
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pyarrow as pa
import pyarrow.csv

from tactogram.datasets import Recording, Store, create_store, open_store
from tactogram.datasets.examples import cores
from tactogram.datasets.importing import import_dataset
from tactogram.signal import Signal

IMPORTED = (40, 80, 160, 320)
"""Recordings imported from files; 18,880 are the whole set. 0.6 GB of files and 0.2 GB of stores."""
WRITTEN = (250, 500, 1000, 4000)
"""Recordings in the stores that are read; 1.6 GB in all."""
WHOLE_SET = 18_880


def run(
    imported: tuple[int, ...] = IMPORTED, written: tuple[int, ...] = WRITTEN, folder: Path | None = None
) -> list[dict[str, Any]]:
    """Return a row per size and what was measured, and the line through the import times."""
    with tempfile.TemporaryDirectory(dir=folder, prefix="bench-store-") as name:
        rows = _imports(Path(name), imported)
        return [*rows, _line(rows), *(_reading(Path(name) / f"read{n}", n) for n in written)]


def _imports(folder: Path, sizes: tuple[int, ...]) -> list[dict[str, Any]]:
    strokes = list(itertools.islice(_strokes(), max(sizes)))
    for stroke in strokes:
        _write_files(folder / "files", stroke)
    rows = []
    for size in sizes:
        source = folder / f"source{size}"
        for kind in ("accel", "force", "position"):
            place = source / "sensor_data" / kind
            place.mkdir(parents=True)
            for stroke in strokes[:size]:
                (place / f"{stroke}.csv").symlink_to(folder / "files" / kind / f"{stroke}.csv")
        rows.append(
            {"what": "import", "recordings": size} | _measured_import(source, folder / f"store{size}")
        )
    return rows


def _measured_import(source: Path, out: Path) -> dict[str, Any]:
    """Import in a process of its own, and watch it and its children."""
    process = subprocess.Popen([sys.executable, __file__, source, out], stdout=subprocess.PIPE, text=True)
    peak = _watch(psutil.Process(process.pid), lambda: process.poll() is None)
    text, _ = process.communicate()
    if process.returncode:
        raise RuntimeError(f"import of {source} failed")
    facts = json.loads(text)
    return facts | {"peak_mb_all_processes": round(peak / 2**20), "store_mb": round(_size(out) / 2**20, 1)}


def _import(source: Path, out: Path) -> None:
    """Import and print what it took; runs as a process of its own."""
    begun = time.perf_counter()
    report = import_dataset("cluster", source, out, workers=cores())
    seconds = time.perf_counter() - begun
    own, children = os.times(), os.times()
    used = own.user + own.system + children.children_user + children.children_system
    peak = int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]) / 1024
    facts = {
        "seconds": round(seconds, 2),
        "ms_per_recording": round(1000 * seconds / report["recordings"], 1),
        "cores": cores(),
        "cores_busy": round(used / seconds, 2),
        "peak_mb": round(peak),
    }
    print(json.dumps(facts))


def _watch(process: psutil.Process, running: Callable[[], bool]) -> int:
    """Return the largest resident memory of ``process`` and its children together, in bytes."""
    peak = 0
    while running():
        total = 0
        try:
            for member in (process, *process.children(recursive=True)):
                total += member.memory_info().rss
        except psutil.NoSuchProcess:
            pass
        peak = max(peak, total)
        time.sleep(0.05)
    return peak


def _line(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Fit seconds = start + slope * recordings."""
    n = np.array([row["recordings"] for row in rows], dtype=float)
    seconds = np.array([row["seconds"] for row in rows])
    slope, start = np.polyfit(n, seconds, 1)
    rest = seconds - (start + slope * n)
    return {
        "what": "line through the import times",
        "start_s": round(float(start), 2),
        "ms_per_recording": round(1000 * float(slope), 1),
        "r2": round(1 - float(rest @ rest / ((seconds - seconds.mean()) ** 2).sum()), 4),
        "whole_set_minutes": round(float(start + slope * WHOLE_SET) / 60, 1),
    }


def _reading(path: Path, size: int) -> dict[str, Any]:
    """Open a store of ``size`` recordings and read windows of 200 samples at random places."""
    begun = time.perf_counter()
    ids = []

    def recordings() -> Any:
        for number, stroke in enumerate(itertools.islice(_strokes(), size)):
            recording = _recording(number, stroke)
            ids.append(recording.id)
            yield recording

    create_store(path, recordings(), name="bench", licence="CC0-1.0", simulated=True)
    writing = time.perf_counter() - begun
    rng = np.random.default_rng(0)
    opening = []
    for _ in range(20):
        begun = time.perf_counter()
        _window(open_store(path), ids, rng)
        opening.append(time.perf_counter() - begun)
    store = open_store(path)
    for _ in range(200):
        _window(store, ids, rng)
    windows = []
    for _ in range(2000):
        begun = time.perf_counter()
        _window(store, ids, rng)
        windows.append(time.perf_counter() - begun)
    return {
        "what": "read",
        "recordings": size,
        "store_mb": round(_size(path) / 2**20, 1),
        "shards": len(store.facts.shards),
        "write_ms_per_recording": round(1000 * writing / size, 2),
        "open_and_first_window_ms": round(1000 * float(np.median(opening)), 2),
        "window_us": round(1e6 * float(np.median(windows))),
        "window_us_95": round(1e6 * float(np.quantile(windows, 0.95))),
    }


def _window(store: Store, ids: list[str], rng: np.random.Generator) -> Signal:
    id = ids[rng.integers(len(ids))]
    start = int(rng.integers(store.length(id, "acceleration") - 200))
    return store.signal(id, "acceleration", start=start, stop=start + 200)


def _strokes() -> Any:
    """Yield names in Cluster's order: texture, direction, speed, force, repeat."""
    for texture in itertools.count():
        yield from (
            "_".join(map(str, (texture, *rest)))
            for rest in itertools.product(range(0, 360, 45), range(20, 70, 10), (500, 1000), (0, 1))
        )


def _seconds(stroke: str) -> float:
    return 100.0 / float(stroke.split("_")[2])


def _recording(number: int, stroke: str) -> Recording:
    rng = np.random.default_rng(number)
    length = round(6000 * _seconds(stroke))
    texture, direction, speed, force, _ = stroke.split("_")
    return Recording(
        streams={
            "acceleration": Signal(rng.standard_normal((3, length), np.float32), 6000.0, "m/s^2"),
            "force": Signal(rng.standard_normal(length, np.float32), 6000.0, "N"),
            "position": Signal(rng.standard_normal((2, length // 60), np.float32), 100.0, "m", ("x", "y")),
        },
        material=f"texture {texture}",
        speed_mm_s=float(speed),
        force_n=float(force) / 1000,
        direction_deg=float(direction),
        source=stroke,
        simulated=True,
    )


def _write_files(folder: Path, stroke: str) -> None:
    rng = np.random.default_rng([int(n) for n in stroke.split("_")])
    length = round(6000 * _seconds(stroke))
    times = (np.arange(length) + rng.uniform(-0.2, 0.2, length) + 1) / 6000
    tables = {
        "accel": {"time": times} | {axis: rng.normal(0, 0.3, length).round(3) for axis in "XYZ"},
        "force": {"time": times, "force": rng.normal(0.5, 0.02, length).round(3)},
    }
    slow = np.arange(length // 60) / 100 + rng.uniform(0, 1e-3, length // 60)
    tables["position"] = {"time": slow} | {axis: np.linspace(0, 70, len(slow)).round(2) for axis in "XY"}
    for kind, columns in tables.items():
        (folder / kind).mkdir(parents=True, exist_ok=True)
        pa.csv.write_csv(
            pa.table(columns),
            folder / kind / f"{stroke}.csv",
            pa.csv.WriteOptions(quoting_style="none", quoting_header="none"),
        )


def _size(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


if __name__ == "__main__":
    _import(Path(sys.argv[2]), Path(sys.argv[3]))
