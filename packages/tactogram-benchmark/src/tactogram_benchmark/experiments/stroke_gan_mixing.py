"""Saga et al., Figures 15 to 18: Tile mixed with each of the other eight textures, measured.

The paper mixes labels in two ways and inspects spectrograms: Place Mat 03 (here luncheon-mat-03) at 1 with Tile from
0 to 1 (Figure 15), and Tile with each of the others, weights summing to 1 (Figures 16 to 18). They see the mix change
"especially on the X-axis", and Tile's feature where its weight is over 0.4, except with Cloth and Carpet.

Here each step is located between the two ends (`evaluation.mixing.placement`), in several trainings with different
seeds. The default recordings are simulated; which texture dominates depends on them as much as on the model. Where a
network's own pure textures cannot be distinguished there is nothing between them: such a pair has no ladder.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tactogram.cli.printing import columns
from tactogram.evaluation import IndistinctEndsError
from tactogram.workflows import ProgressCallback, mixing_ladder
from tactogram_benchmark.experiments.artifacts import (
    Training,
    facts_of,
    find_or_simulate,
    kind_of,
    materials_of,
    spread,
    trained_runs,
)

END = "tile"
ADDED_TO = "luncheon-mat-03"
SEEN = dict.fromkeys(
    ("artificial-grass", "cork-sheet", "punched-plastic-sheet", "luncheon-mat-01", "luncheon-mat-02", ADDED_TO),
    "Tile seen where over 0.4",
) | dict.fromkeys(("cloth", "carpet"), "not yet at 0.4")  # fmt: skip
"""Section V: the authors' observations in the spectrograms of Figures 16 to 18."""
SEEN_ADDED = "ever more of both, above all on X"
"""Section V, Figure 15."""

NOTES = """\
Half way: weight of Tile at which a mix is half way between the textures, ± sd over trainings (*: over those that
reach it; –: undefined). No level: by the shape of spectra and envelopes alone, as in pictures scaled from 0 to
1. One way: trainings in which the position rises, up to chance. Drop: the largest fall. Off: the largest distance
from the line between the ends, relative to theirs. Pure: position of the generated pure materials between their
recordings, 0 and 1."""

SECONDS = 8.0
"""Length of each measured signal."""
SIGNALS = {"bench": 6, "paper": 20}
"""Per step."""
STEPS = 11


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    model: str = "stroke_gan",
    recipe: str = "",
    batch_size: int = 0,
    trainings: int = 3,
    baselines: str = "ar_texture,replay",
    on: str = "",
    processes: int | None = None,
) -> dict[str, Any]:
    """Return for every pair the positions of the steps, whether they are monotone, and where Tile takes over.

    Parameters
    ----------
    data : str
        Store with the nine textures; default: simulated.
    model : str
        Generators conditioned on ``material``, separated by commas.
    recipe : str
        Of these; default: ``paper``, or ``quick`` for the bench.
    batch_size : int
        Signals per update of these; 0 for the recipe's.
    trainings : int
        Number of seeds, each with its own split.
    baselines : str
        Models to compare with, separated by commas, trained once each; may be empty.
    """
    store = find_or_simulate(folder / "data", "stroking9", given=data, progress=progress)
    materials = materials_of(store)
    default = "paper" if paper else "quick"
    chosen = model.split(",")
    changed = {"config.batch_size": batch_size} if batch_size else {}
    settings = {"steps": STEPS, "signals": SIGNALS["paper" if paper else "bench"], "seconds": SECONDS}
    lines = dict.fromkeys(chosen, range(trainings)) | {
        name: range(1) for name in baselines.split(",") if name and name not in chosen
    }
    recipes = {name: (recipe if name in chosen else "") or default for name in lines}
    runs = {
        (name, seed): Training(
            name,
            store.path,
            folder / f"{name}-{seed}",
            {"recipe": recipes[name], "changes": {"seed": seed} | (changed if name in chosen else {})},
        )
        for name, seeds in lines.items()
        for seed in seeds
    }
    pairs = [(other, "sum") for other in SEEN] + [(ADDED_TO, "add")]
    ladders_of: dict[str, dict[str, list[dict[str, Any]]]] = {name: {} for name in lines}
    for (name, seed), out in trained_runs(runs, on=on, processes=processes, progress=progress):
        for other, mode in pairs:
            options: dict[str, Any] = {**settings, "mode": mode, "seed": seed, "reuse": True}
            options["out"] = folder / "ladders" / f"{name}-{seed}" / f"{other}-{mode}"
            try:
                ladder = mixing_ladder(out, materials[other], materials[END], **options, progress=progress)
            except IndistinctEndsError as error:
                ladder = {"refused": str(error)}
            ladders_of[name].setdefault(f"{other} ({mode})", []).append(ladder)
    models: dict[str, Any] = {
        name: {pair: summary(ladders) for pair, ladders in held.items()} for name, held in ladders_of.items()
    }
    return {
        "figures": "15-18",
        **facts_of(store),
        "recipes": recipes,
        "changes": changed,
        "measured": settings,
        "seen_in_the_paper": SEEN,
        "models": models,
        "text": "\n\n".join(
            [NOTES, *(_text(name, rows, recipes[name], kind_of(store)) for name, rows in models.items())]
        ),
    }


def summary(ladders: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the figures of one pair over trainings: means and standard deviations, and each training's.

    A training with indistinguishable ends is listed under ``refused`` and excluded.
    """
    measured = [ladder for ladder in ladders if "refused" not in ladder]
    counts: dict[str, Any] = {
        "trainings": len(ladders),
        "measured": len(measured),
        "refused": [ladder["refused"] for ladder in ladders if "refused" in ladder],
    }
    if not measured:
        return counts
    parts = [ladder["ladder"] for ladder in measured]
    names = parts[0]["columns"]
    steps = range(len(parts[0]["weights"]))
    against = [ladder["against_recordings"] for ladder in measured]
    return counts | {
        "weights": parts[0]["weights"],
        "position": {
            name: [spread(part["position"][name][k] for part in parts) for k in steps] for name in names
        },
        "half_weight": {name: spread(part["half_weight"][name] for part in parts) for name in names},
        "half_weight_without_level": spread(
            ladder["without_level"]["half_weight"]["overall"] if ladder["without_level"] else None
            for ladder in measured
        ),
        "monotone": {name: sum(bool(part["monotone"][name]) for part in parts) for name in names},
        "largest_drop": {name: spread(part["largest_drop"][name] for part in parts) for name in names},
        "largest_rise": {name: spread(part["largest_rise"][name] for part in parts) for name in names},
        "largest_off_line": {
            name: spread(_largest(part["off_line"][name]) for part in parts) for name in names
        },
        "distance_db": {name: spread(part["distance_db"][name] for part in parts) for name in names},
        "first_and_last_between_recordings": [
            spread(part["position"]["overall"][k] if part else None for part in against) for k in (0, -1)
        ],
        "ladders": [ladder["figure"] for ladder in measured],
    }


def _largest(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return max(known) if known else None


def _text(model: str, rows: dict[str, Any], recipe: str, kind: str) -> str:
    count = next(iter(rows.values()))["trainings"]
    measured: Mapping[str, Any] = next((row["half_weight"] for row in rows.values() if row["measured"]), {})
    axes = [name for name in measured if name != "overall"]
    heads = ("half way at", "no level", *(f"on {name}" for name in axes), "one way", "drop", "off", "pure")
    table: list[tuple[str, ...]] = [("Tile and", *heads, "the paper saw (real strokes)")]
    for pair, row in rows.items():
        if not row["measured"]:
            said = f"indistinguishable ends in all {count} trainings: no ladder"
            table.append((pair, *("–" for _ in heads), said))
            continue
        half, apart = row["half_weight"], row["distance_db"]
        other, _, mode = pair.partition(" ")
        seen, pure = (SEEN[other], _pure(row)) if mode == "(sum)" else (SEEN_ADDED, "–")
        table.append(
            (
                pair, _cell(half["overall"], with_sd=True), _cell(row["half_weight_without_level"]),
                *(_cell(half[name]) if apart[name]["known"] else "–" for name in axes),
                f"{row['monotone']['overall']} of {row['measured']}", _cell(row["largest_drop"]["overall"]),
                _cell(row["largest_off_line"]["overall"]), pure, seen,
            )
        )  # fmt: skip
    return f"{model}, {recipe}, {count} training{'s' * (count > 1)}, {kind}\n{columns(table)}"


def _pure(row: dict[str, Any]) -> str:
    ends = row["first_and_last_between_recordings"]
    if ends[0]["mean"] is None:
        return "–"
    return " … ".join(f"{end['mean']:.2f}" for end in ends)


def _cell(facts: dict[str, Any], *, with_sd: bool = False) -> str:
    if facts["mean"] is None:
        return "never"
    sd = f" ± {facts['sd']:.2f}" if with_sd and facts["sd"] is not None else ""
    few = "*" if facts["known"] < len(facts["values"]) else ""
    return f"{facts['mean']:.2f}{sd}{few}"
