"""Saga et al., Figures 7 to 9: spectrograms of recorded and generated strokes of nine textures, simulated.

The paper's recordings are not published. The simulated set has their layout: nine textures rubbed by a finger in
one direction, 4,000 samples of three axes at 1 kHz. The paper shows recorded and generated strokes for three
textures (Figure 7) and generated ones alone for the other six (Figures 8 and 9). Here all nine are compared with
held-out strokes, once from 0 to 1 as printed and once in dB, which shows the level.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.evaluation.generation.spectrogram_figures import spectrograms_figure
from tactogram.evaluation.measures import log_spectral_distance
from tactogram.evaluation.report import save_figure
from tactogram.experiments.artifacts import find_or_simulate, trained_run
from tactogram.signal import Image, Signal
from tactogram.workflows.evaluation.mixing_ladder import recorded
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.progress import ProgressCallback

FIGURES = {
    "figure-7": ("artificial-grass", "carpet", "tile"),
    "figure-8": ("cloth", "cork-sheet", "punched-plastic-sheet"),
    "figure-9": ("luncheon-mat-01", "luncheon-mat-02", "luncheon-mat-03"),
}
"""Three textures each. The text names only Tile as one of the three in Figure 7."""


def run(
    folder: Path, *, paper: bool, progress: ProgressCallback, model: str = "stroke_gan"
) -> dict[str, Any]:
    """Return the figures' files, and each texture's distance between generated and recorded strokes."""
    store = find_or_simulate(folder / "data", "stroking9", progress=progress)
    recipe = "paper" if paper else "quick"
    out = trained_run(model, store, folder / model, recipe=recipe, progress=progress)
    real = {name: recorded(out, name) for names in FIGURES.values() for name in names}
    made = {name: _signals(out, name, strokes) for name, strokes in real.items()}
    files: dict[str, str] = {}
    for figure, names in FIGURES.items():
        groups = {name: {"recorded": real[name][0], "generated": made[name][0]} for name in names}
        for scale in ("0-1", "dB"):
            title = f"{model}, trained on simulated strokes; recorded: simulated as well"
            drawn = spectrograms_figure(groups, scale=scale, title=title)
            files[f"{figure}-{scale}"] = str(save_figure(folder / f"{model}-{figure}-{scale}.png", drawn))
    rows = {
        name: {
            "model": log_spectral_distance(made[name], real[name]),
            "floor": log_spectral_distance(real[name][::2], real[name][1::2]),
            "ceiling": log_spectral_distance([s for n, part in real.items() if n != name for s in part], real[name]),
        }
        for name in real
    }  # fmt: skip
    return {
        "figures": files,
        "model": model,
        "recipe": recipe,
        "simulated": store.simulated,
        "data": store.name,
        "data_sha256": store.sha256,
        "log_spectral_distance_db": rows,
        "text": _text(model, rows, files),
    }


def _text(model: str, rows: dict[str, dict[str, float]], files: dict[str, str]) -> str:
    lines = [
        "Simulated strokes. Log-spectral distance to held-out strokes, dB; floor: one half of them to the other;",
        f"ceiling: other textures. {model:22}{'model':>8}{'floor':>8}{'ceiling':>9}",
    ]
    lines += [
        f"{name:32}{row['model']:>8.2f}{row['floor']:>8.2f}{row['ceiling']:>9.2f}"
        for name, row in rows.items()
    ]
    return "\n".join([*lines, *(f"{name}: {file}" for name, file in files.items())])


def _signals(run: Path, material: str, strokes: Sequence[Signal]) -> list[Signal]:
    """Return one generated signal per recorded one, all as long as the first."""
    signals = []
    for made in generate(run, {"material": material}, seconds=strokes[0].seconds, count=len(strokes)):
        if isinstance(made, Image):
            raise ParameterError(f"{run.name} gives images; choose a model that gives signals")
        signals.append(made)
    return signals
