"""Saga et al., Tables I and II: 30 classes of strokes, per speed and mixed.

The paper's recordings are not published. The default data are simulated in their layout: 15 surfaces x finger or pen at
100, 200 and 400 mm/s, three 3-minute back-and-forth takes each, 330 Hz wireless. Folds are ten contiguous
blocks of every take with a gap of one window. Our figures show that the method works on data of this shape;
they neither confirm nor refute the published accuracies.
"""

from __future__ import annotations

from pathlib import Path
from statistics import mean, stdev
from typing import Any

from tactogram.cli.printing import columns
from tactogram.workflows import ProgressCallback, crossval
from tactogram_benchmark.experiments.artifacts import facts_of, find_or_simulate, kind_of

PUBLISHED = {"100": 89.0, "200": 88.0, "400": 93.2, "mixed": 88.9}
"""Table II, classification accuracy in %, windows. The printed rows P, R, V, X, Y, Z of Table I are corrupt."""

BENCH = {
    "config.window": 200,
    "config.batch_size": 32,
    "config.steps": 300,
    "config.hop": 0.5,
    "training.precision": "32-true",
}


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    on: str = "",
    processes: int | None = None,
) -> dict[str, Any]:
    """Return accuracy per speed and mixed, in %, mean and spread over folds.

    ``data`` is a store with contactors and speeds, by default simulated; those of the speeds that it has are compared.
    ``on`` and ``processes`` are those of `crossval`.
    """
    store = find_or_simulate(folder / "data", "stroking30", given=data, progress=progress)
    speeds = {f"{info.speed_mm_s:g}" for info in store.index if info.speed_mm_s is not None} | {"mixed"}
    options: dict[str, Any] = {"folds": 10, "label": "material+contactor", "recipe": "paper"}
    if not paper:
        options |= {"recipe": "quick", "changes": BENCH}
    running: dict[str, Any] = {"on": on, "processes": processes, "progress": progress}
    rows: dict[str, dict[str, Any]] = {}
    for speed, published in PUBLISHED.items():
        if speed not in speeds:
            continue
        where = {} if speed == "mixed" else {"speed_mm_s": speed}
        out = folder / f"speed-{speed}"
        result = crossval("stroke_cnn", store.path, where=where, out=out, **options, **running)
        windows = [100 * fold["window_accuracy"] for fold in result["per_fold"]]
        rows[speed] = {
            "published": published,
            "ours": mean(windows),
            "sd_over_folds": stdev(windows) if len(windows) > 1 else None,
            "recording_accuracy": 100 * result["recording_accuracy"],
            "folds": result["folds"],
            "split": result["split"],
            "report": result["report"],
        }
    return {
        "table": "II",
        **facts_of(store),
        "recipe": options["recipe"],
        "changes": options.get("changes", {}),
        "rows": rows,
        "text": _text(rows, kind_of(store)),
    }


def _text(rows: dict[str, dict[str, Any]], kind: str) -> str:
    table = [("speed, mm/s", "published", "ours", "folds")]
    for speed, row in rows.items():
        spread = f" ± {row['sd_over_folds']:.1f}" if row["sd_over_folds"] is not None else ""
        table.append((speed, f"{row['published']:.1f}", f"{row['ours']:.1f}{spread}", str(row["folds"])))
    lines = [
        f"Window accuracy, %. Ours: {kind}; published: 30 classes of the paper's own. Not comparable.",
        columns(table),
    ]
    return "\n".join(lines)
