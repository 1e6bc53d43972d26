"""Neshov et al. 2026, Table 3 and Figure 2: number of discriminators and of their downsampling layers.

The paper selects the cell with the lowest LPIPS and reports the same figure as its result. Here the cell is selected on
the validation part, and the test part is shown for all cells: the minimum of 16 noisy figures is biased downwards.
Every cell is compared with the selected one by a two-tailed t-test (Sec. 4.2), paired by seed; p is uncorrected: one
of 15 comparisons below 0.05 means little.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tactogram.cli.printing import columns
from tactogram.datasets import Store
from tactogram.evaluation import save_figure
from tactogram.workflows import ProgressCallback
from tactogram_benchmark.experiments.artifacts import listed, spread
from tactogram_benchmark.experiments.picture_cells import (
    about_cells,
    cell_texts,
    compared,
    data_of,
    facts_of_cells,
    table_cells,
    table_settings,
    text_of,
)

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


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    trainings: int = 3,
    cells: str = "",
    protocol: str = "",
    alexnet: str = "",
    inception: str = "",
    densenet201: str = "",
) -> dict[str, Any]:
    """Return every cell's figures, and the cell selected on the validation part.

    Parameters
    ----------
    folder, paper, progress
        See `tactogram_benchmark.experiments`. ``paper`` trains the published size, otherwise a small one.
    data : str
        Store with photographs; default: simulated surfaces.
    trainings : int
        Seeds per cell; 10 in the paper.
    cells : str
        Only these, such as ``1x1,3x3`` (discriminators x layers); default: all 16.
    protocol : str
        Order of splitting, cutting and pairing: ``crop-split`` (the paper's, of ``paper``), ``source-split`` (ours) or
        ``pair-then-split``.
    alexnet, inception, densenet201 : str
        Files of published weights (`tactogram doctor` lists them); default: torch's cache.
    """
    sizes = _wanted(cells)
    files = {"alexnet": alexnet, "inception": inception, "densenet201": densenet201}
    settings = table_settings(paper=paper, protocol=protocol, progress=progress, **files)
    store = data_of(folder, data, paper=paper, progress=progress)
    grid = {
        key: ("visual_tactile_gan", {"config.discriminators": d, "config.layers": layers})
        for key, (d, layers) in sizes.items()
    }
    trained = table_cells(folder, store, grid, settings=settings, trainings=trainings, progress=progress)
    first = next(iter(trained.values()))[0]
    chosen_by = next(name for name in first["validation"] if name != "label_accuracy_unseen")
    validation = {
        key: spread([cell["validation"][chosen_by] for cell in row]) for key, row in trained.items()
    }
    chosen = min(validation, key=lambda key: validation[key]["mean"])
    rows = compared(trained, chosen)
    result = {
        "table": 3,
        **facts_of_cells(store, settings, trained),
        "chosen_by": chosen_by,
        "chosen": chosen,
        "cells": {
            key: {"validation": validation[key], **row, "published_lpips": PUBLISHED[sizes[key]]}
            for key, row in rows.items()
        },
    }
    shown_by = "lpips" if "lpips" in rows[chosen]["test"] else chosen_by
    heights = {
        sizes[key]: (row["test"] | {chosen_by: row["validation"]})[shown_by]["mean"]
        for key, row in result["cells"].items()
    }
    figure = _surfaces(heights, sizes[chosen], shown_by, store) if set(heights) == set(PUBLISHED) else None
    result["figure"] = str(save_figure(folder / "figure2.png", figure)) if figure else None
    return result | {"text": _text(result)}


def _wanted(names: str) -> dict[str, tuple[int, int]]:
    """Return discriminators and layers of the named cells, of all for none."""
    known = {f"{d}x{layers}": (d, layers) for d, layers in PUBLISHED}
    return {name: known[name] for name in listed(names, known, "cells") or known}


def _surfaces(
    heights: Mapping[tuple[int, int], float], chosen: tuple[int, int], measure: str, store: Store
) -> Figure:
    """Draw the published surface of Figure 2 beside ours; red: the selected cell."""
    published = {key: mean for key, (mean, _) in PUBLISHED.items()}
    best = min(published, key=lambda key: published[key])
    kind = "simulated strokes" if store.simulated else "recordings"
    figure = Figure(figsize=(10, 4.5), layout="constrained")
    for panel, (title, surface, dot) in enumerate(
        (
            ("published: LPIPS, LMT-108", published, best),
            (
                f"ours: {measure.removesuffix('_unseen').replace('_', ' ')}, {store.name}, {kind}",
                heights,
                chosen,
            ),
        ),
        1,
    ):
        axes: Any = figure.add_subplot(1, 2, panel, projection="3d")
        counts = sorted({d for d, _ in surface})
        layers = sorted({count for _, count in surface})
        across, up = np.meshgrid(layers, counts)
        axes.plot_surface(
            across,
            up,
            np.array([[surface[d, count] for count in layers] for d in counts]),
            cmap="viridis",
            alpha=0.8,
        )
        axes.scatter(dot[1], dot[0], surface[dot], color="red", s=50, depthshade=False)
        axes.set(xlabel="downsampling layers (L)", ylabel="discriminators (D)", xticks=layers, yticks=counts)
        axes.set_box_aspect(None, zoom=0.85)
        axes.set_title(title, fontsize=9)
    return figure


def _text(result: dict[str, Any]) -> str:
    rows = result["cells"]
    table = [("D x L", "published LPIPS", "validation", *rows[result["chosen"]]["test"])]
    for key, row in rows.items():
        published = "{:.4f} ± {:.4f}".format(*row["published_lpips"])
        table.append(
            (key + "*" * (key == result["chosen"]), published, text_of(row["validation"]), *cell_texts(row))
        )
    lines = [
        f"visual_tactile_gan on {about_cells(result, result['chosen'])}; D x L",
        columns(table),
        f"*: selected on the validation part, by {result['chosen_by']}. Published: real accelerations of LMT-108.",
    ]
    return "\n".join([*lines, *(f"{name}: {why}" for name, why in result["missing"].items())])
