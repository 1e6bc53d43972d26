"""Neshov et al. 2026, Table 3: number of discriminators and of their downsampling layers.

The paper selects the cell with the lowest LPIPS and reports the same figure as its result. Here the cell is selected on
the validation part, and the test part is shown for all cells: the minimum of 16 noisy figures is biased downwards.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.experiments.picture_cells import cell, data_of, shown, spread, text_of
from tactogram.workflows.progress import ProgressCallback

PUBLISHED = {
    (1, 1): (0.3442, 0.0106),
    (1, 2): (0.3486, 0.0099),
    (1, 3): (0.3458, 0.0080),
    (1, 4): (0.3337, 0.0084),
    (2, 1): (0.3254, 0.0078),
    (2, 2): (0.3328, 0.0090),
    (2, 3): (0.3294, 0.0084),
    (2, 4): (0.3258, 0.0100),
    (3, 1): (0.3291, 0.0102),
    (3, 2): (0.3308, 0.0096),
    (3, 3): (0.3113, 0.0087),
    (3, 4): (0.3202, 0.0073),
    (4, 1): (0.3200, 0.0079),
    (4, 2): (0.3274, 0.0072),
    (4, 3): (0.3194, 0.0057),
    (4, 4): (0.3205, 0.0101),
}
"""LPIPS, mean and sd of 10 runs, by discriminators and layers: nine materials of LMT-108, acceleration."""
COARSE = ((1, 1), (1, 3), (3, 1), (3, 3))
"""Cells of the bench recipe."""


def run(
    folder: Path, *, paper: bool, progress: ProgressCallback, data: str = "", trainings: int = 3
) -> dict[str, Any]:
    """Return every cell's figures, and the cell selected on the validation part.

    Parameters
    ----------
    folder, paper, progress
        See `tactogram.experiments`. ``paper`` trains all 16 cells at the published size, otherwise 4 at a small one.
    data : str
        Store with photographs; default: simulated surfaces.
    trainings : int
        Seeds per cell; 10 in the paper.
    """
    store = data_of(folder, data, paper=paper, progress=progress)
    cells = {}
    for d, layers in PUBLISHED if paper else COARSE:
        cells[d, layers] = [
            cell(
                folder,
                store,
                f"{d}x{layers}",
                model="visual_tactile_gan",
                recipe="paper" if paper else "bench",
                changes={"config.discriminators": d, "config.layers": layers},
                seed=seed,
                progress=progress,
            )
            for seed in range(trainings)
        ]
    measures = shown([found for row in cells.values() for found in row])
    rows: dict[str, dict[str, Any]] = {
        f"{d}x{layers}": {
            "validation": {
                name: spread([found["validation"][name] for found in row])
                for name in row[0]["validation"]
                if name.endswith("_unseen") and name != "label_accuracy_unseen"
            },
            "test": {name: spread([found["values"][name] for found in row]) for name in measures},
            "published_lpips": PUBLISHED[d, layers],
        }
        for (d, layers), row in cells.items()
    }
    chosen_by = next(iter(next(iter(rows.values()))["validation"]), None)
    chosen = min(rows, key=lambda key: rows[key]["validation"][chosen_by]["mean"]) if chosen_by else None
    result = {
        "table": 3,
        "simulated": store.simulated,
        "data": store.name,
        "data_sha256": store.sha256,
        "trainings": trainings,
        "missing": next(iter(cells.values()))[0]["missing"],
        "chosen_by": chosen_by,
        "chosen": chosen,
        "cells": rows,
    }
    return result | {"text": _text(result)}


def _text(result: dict[str, Any]) -> str:
    rows = result["cells"]
    measures = list(next(iter(rows.values()))["test"])
    kind = "simulated strokes" if result["simulated"] else "recordings"
    lines = [
        f"visual_tactile_gan on {result['data']} ({kind}), {result['trainings']} trainings, mean ± sd; D x L",
        f"{'D x L':8}{'validation':>20}"
        + "".join(f"{name:>{len(name) + 4}}" for name in measures)
        + f"{'published LPIPS':>20}",
    ]
    for key, row in rows.items():
        validation = row["validation"].get(result["chosen_by"])
        mark = "*" if key == result["chosen"] else ""
        lines.append(
            f"{key + mark:8}{text_of(validation) if validation else '–':>20}"
            + "".join(f"{text_of(row['test'][name]):>{len(name) + 4}}" for name in measures)
            + "{:>20}".format("{:.4f} ± {:.4f}".format(*row["published_lpips"]))
        )
    lines.append(
        f"*: selected on the validation part, by {result['chosen_by']}. Published: real accelerations of LMT-108."
    )
    lines += [f"{name}: {why}" for name, why in result["missing"].items()]
    return "\n".join(lines)
