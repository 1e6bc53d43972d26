"""Saga et al., Figures 7 to 9: spectrograms of recorded and generated strokes of nine textures.

The default data are simulated in the layout of the paper's: nine textures rubbed by a finger in one direction, 4,000
samples of three axes at 1 kHz. The paper shows recorded and generated strokes for three textures (Figure 7) and
generated ones alone for the other six (Figures 8 and 9). Here all nine are compared with held-out strokes, once from 0
to 1 as printed and once in dB, which shows the level. Several trainings, of different recipes or lengths, are compared
by their distance to these strokes, and by whether each texture is nearest to its own.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import mean
from typing import Any

from tactogram.cli.printing import columns
from tactogram.errors import DataError, ParameterError
from tactogram.evaluation import log_spectral_distance, save_figure, spectrograms_figure
from tactogram.signal import Image, Signal
from tactogram.training import Run
from tactogram.workflows import ProgressCallback, generate, recorded
from tactogram_benchmark.experiments.artifacts import (
    Training,
    facts_of,
    find_or_simulate,
    kind_of,
    materials_of,
    trained_runs,
)

FIGURES = {
    "figure-7": ("artificial-grass", "carpet", "tile"),
    "figure-8": ("cloth", "cork-sheet", "punched-plastic-sheet"),
    "figure-9": ("luncheon-mat-01", "luncheon-mat-02", "luncheon-mat-03"),
}
"""Three textures each. The text names only Tile as one of the three in Figure 7."""
STROKES = 8
"""Strokes of a texture, so that two are kept apart and the floor is that of one to the other."""


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    model: str = "stroke_gan",
    recipes: str = "",
    batch_size: int = 0,
    on: str = "",
    processes: int | None = None,
) -> dict[str, Any]:
    """Return the figures' files, and each texture's distance between generated and recorded strokes.

    Parameters
    ----------
    data : str
        Store with the nine textures; default: simulated.
    model : str
        Any generator conditioned on ``material``.
    recipes : str
        Recipes, separated by commas, each trained once; default: ``paper``, or ``quick`` for the bench.
    batch_size : int
        Signals per update; 0 for the recipe's.
    """
    store = find_or_simulate(folder / "data", "stroking9", given=data, progress=progress)
    materials = materials_of(store)
    counts = Counter(info.material for info in store.index)
    if (least := min(counts[material] for material in materials.values())) < STROKES:
        problem = (
            f"must have {STROKES} strokes of each texture, of which a fifth is kept apart; got {least} of one"
        )
        raise DataError(store.path, problem)
    runs: dict[str, Training] = {}
    for recipe in (recipes or ("paper" if paper else "quick")).split(","):
        name = f"{model}-{recipe}{f'-batch-{batch_size}' * bool(batch_size)}"
        changes = {"config.batch_size": batch_size} if batch_size else {}
        runs[name] = Training(model, store.path, folder / name, {"recipe": recipe, "changes": changes})
    files: dict[str, str] = {}
    rows: dict[str, dict[str, Any]] = {}
    real: dict[str, list[Signal]] = {}
    for name, out in trained_runs(runs, on=on, processes=processes, progress=progress):
        real = real or {texture: recorded(out, material) for texture, material in materials.items()}
        generated = {texture: _signals(out, materials[texture], strokes) for texture, strokes in real.items()}
        drawn = _draw(folder, name, real, generated, kind_of(store))
        files |= drawn
        distances = {
            texture: {other: log_spectral_distance(generated[texture], real[other]) for other in real}
            for texture in generated
        }
        rows[name] = {
            **runs[name].options,
            "notes": Run.open(out).facts()["notes"],
            "distances_db": {texture: row[texture] for texture, row in distances.items()},
            "nearest": {
                texture: min(row, key=lambda other: row[other]) for texture, row in distances.items()
            },
        }
    result = {
        "figures": files,
        "model": model,
        **facts_of(store),
        "held_out": {texture: len(strokes) for texture, strokes in real.items()},
        "trainings": rows,
        "floor_db": {name: log_spectral_distance(part[::2], part[1::2]) for name, part in real.items()},
        "ceiling_db": {
            name: log_spectral_distance([s for n, part in real.items() if n != name for s in part], strokes)
            for name, strokes in real.items()
        },
    }
    return result | {"text": _text(result, kind_of(store))}


def _draw(
    folder: Path,
    name: str,
    real: Mapping[str, Sequence[Signal]],
    generated: Mapping[str, Sequence[Signal]],
    kind: str,
) -> dict[str, str]:
    """Draw Figs. 7 to 9 of one training on both scales; return their files."""
    files = {}
    for figure, textures in FIGURES.items():
        groups = {item: {"recorded": real[item][0], "generated": generated[item][0]} for item in textures}
        for scale in ("0-1", "dB"):
            drawn = spectrograms_figure(groups, scale=scale, title=f"{name}, trained on {kind}")
            files[f"{name}-{figure}-{scale}"] = str(
                save_figure(folder / f"{name}-{figure}-{scale}.png", drawn)
            )
    return files


def _text(result: Mapping[str, Any], kind: str) -> str:
    rows, floor, ceiling = result["trainings"], result["floor_db"], result["ceiling_db"]
    table = [("texture", "floor", "ceiling", *rows)]
    for texture in floor:
        values = (floor[texture], ceiling[texture], *(row["distances_db"][texture] for row in rows.values()))
        table.append((texture, *(f"{value:.2f}" for value in values)))
    every = (floor, ceiling, *(row["distances_db"] for row in rows.values()))
    table.append(("mean", *(f"{mean(row.values()):.2f}" for row in every)))
    own = (sum(name == other for name, other in row["nearest"].items()) for row in rows.values())
    table.append(("own, of 9", "", "", *map(str, own)))
    lines = [
        f"Generated to held-out {kind}, log-spectral distance, dB. Floor: one half of these to the other;",
        "ceiling: other textures. Own: textures that are nearest to their own strokes, by chance 1 of 9.",
        columns(table),
    ]
    lines += [f"{name}: {note}" for name, row in rows.items() for note in row["notes"]]
    return "\n".join(lines)


def _signals(run: Path, material: str, strokes: Sequence[Signal]) -> list[Signal]:
    """Return one generated signal per recorded one, all as long as the first."""
    signals = []
    for signal in generate(run, {"material": material}, seconds=strokes[0].seconds, count=len(strokes)):
        if isinstance(signal, Image):
            raise ParameterError(f"{run.name} gives images; choose a model that gives signals")
        signals.append(signal)
    return signals
