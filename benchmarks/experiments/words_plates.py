"""Vibrations from words on simulated plates: texture_flow trained on rated display signals, asked for plates' scores.

Simulated people score twelve metal plates and some display signals. The generator is trained on the display signals and
given the mean scores of each plate. Other simulated people score what it makes, beside the sensor's signal played
straight and the display signal nearest in words, all in one sitting; and, in another, the plates themselves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import mean
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Ratings, Store
from tactogram.datasets.simulate.materials import PLATES
from tactogram.datasets.simulate.raters import SimulatedRater, draw_people, score_plates, score_vibrations
from tactogram.errors import ParameterError
from tactogram.evaluation.ratings.reproduction import NEAREST, STRAIGHT, label_fidelity, reproduction
from tactogram.signal import Signal
from tactogram.signal.crest_factor import straight_to_display
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.loaded_run import load_run
from tactogram_benchmark.experiments.artifacts import find_or_simulate, spread, trained_run
from tactogram_benchmark.experiments.picture_cells import text_of

SIGNALS = (39, 400, 4000)
PEOPLE = 100
"""Simulated people who took no part in the training data. Of the 20 of Sec. V-A of Hatori & Takemura 2023, one sitting
differs from the next by 0.02 points."""
SECONDS = 4.0
"""Length of what is generated: the display plays it once, without the seam of a loop."""
CHANGES = {"prepare.stream": "drive", "config.window_s": 0.2, "config.frames": 16}
"""Of the recipe `rated`: display signals are steady, and longer windows resolve their tones."""
GENERATED = "texture_flow"
CLUSTERS = {"1": (1, 2), "2": (3, 4, 5, 6, 7), "3": (8, 9, 10, 12), "4": (11,)}
"""Plates of the clusters of the group D of ultrasonic_cgan."""
TITLES = {
    STRAIGHT: "sensor's signal, unchanged",
    NEAREST: "display signal nearest in words",
    GENERATED: "texture_flow, given the scores",
}
FIGURES = ("error", "correlation", "slope")


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    signals: Sequence[int] = SIGNALS,
    trainings: int = 3,
    steps: int = 0,
) -> dict[str, Any]:
    """Return error, correlation and slope of each kind of signal, for each number of rated display signals.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``paper`` changes nothing.
    signals : sequence of int
        Numbers of rated display signals.
    trainings : int
        Seeds of the generator, each with a group of simulated people of its own.
    steps : int
        Of each training; 0 for the recipe's.
    """
    changes = CHANGES | ({"config.steps": steps} if steps else {})
    rows: dict[int, dict[str, Any]] = {}
    stores: dict[int, Store] = {}
    for count in signals:
        store = find_or_simulate(folder / f"data-{count}", "ultrasonic", signals=count, progress=progress)
        cells = [_cell(folder, store, count, changes | {"seed": seed}, progress) for seed in range(trainings)]
        stores[count] = store
        rows[count] = {kind: _summary([cell[kind] for cell in cells]) for kind in cells[0]}
    ratings = _rated(stores[signals[0]])
    plates = [item for item in ratings.items if item.startswith("plate")]
    touched = [
        _figures(
            {plate: _means(ratings, [plate])[0] for plate in plates},
            score_plates(PLATES, _people(seed), seed=seed),
            "",
        )
        for seed in range(trainings)
    ]
    result: dict[str, Any] = {
        "simulated": True,
        "data": "ultrasonic (simulated)",
        "data_sha256": {count: store.sha256 for count, store in stores.items()},
        "told_by": f"{PEOPLE} other simulated raters, others in each training",
        "trainings": trainings,
        "recipe": "rated",
        "changes": changes,
        "rows": rows,
        "plates": _summary(touched),
    }
    return result | {"text": _text(result)}


def _people(seed: int) -> tuple[SimulatedRater, ...]:
    return draw_people(PEOPLE, seed=1 + seed, prefix="judge")


def _cell(
    folder: Path, store: Store, count: int, changes: Mapping[str, Any], progress: ProgressCallback
) -> dict[str, dict[str, Any]]:
    """Return the figures of each kind of signal, of one training."""
    seed = changes["seed"]
    place = trained_run(
        "texture_flow", store, folder / "runs" / f"{count}-{seed}",
        recipe="rated", label="item", where={"material": ""}, split="all",
        changes=changes, progress=progress,
    )  # fmt: skip
    loaded = load_run(place)
    ratings = _rated(store)
    recorded: dict[str, dict[str, str]] = {"plate": {}, "signal": {}}
    for info in store.index:
        item = info.labels.get("item") or str(info.material)
        recorded["plate" if info.material else "signal"].setdefault(item, info.id)
    plates, shown = list(recorded["plate"]), list(recorded["signal"])
    targets = dict(zip(plates, _means(ratings, plates), strict=True))
    drives = {item: store.signal(recorded["signal"][item], "drive") for item in shown}
    scores = _means(ratings, shown)
    made: dict[str, Signal] = {}
    for number, (plate, asked) in enumerate(targets.items()):
        sensor = store.signal(recorded["plate"][plate], "strain")
        first = next(iter(drives.values()))
        made[f"{STRAIGHT}/{plate}"] = straight_to_display(sensor, rate=first.rate, axes=first.axes)
        made[f"{NEAREST}/{plate}"] = drives[shown[int(((scores - asked) ** 2).sum(1).argmin())]]
        words = dict(zip(ratings.words, asked.tolist(), strict=True))
        signal = loaded.generator.generate({"words": words}, seconds=SECONDS, seed=number)
        if not isinstance(signal, Signal):
            raise ParameterError(f"{place}: must generate signals")
        made[f"{GENERATED}/{plate}"] = signal
    said = score_vibrations(made, _people(seed), seed=seed)
    return {kind: _figures(targets, said, kind) for kind in TITLES}


def _figures(targets: Mapping[str, NDArray[np.float64]], said: Ratings, kind: str) -> dict[str, Any]:
    """Return the error of all scores of one kind of signal from the targets', and how the mean scores follow them."""
    if kind:
        errors = reproduction(said, targets, conditions=(kind,), told_by="").errors[kind]
        names = [f"{kind}/{plate}" for plate in targets]
    else:
        names = list(targets)
        errors = np.abs(said.select(items=names).cube - np.array(list(targets.values()))[:, None])
    fidelity = label_fidelity(np.array(list(targets.values())), _means(said, names)[:, None])
    by_plate = np.nanmean(errors, axis=(1, 2))
    return {
        "error": float(np.nanmean(errors)),
        "correlation": fidelity.correlation,
        "slope": fidelity.slope,
        "error_by_cluster": {
            name: float(np.mean([by_plate[number - 1] for number in numbers]))
            for name, numbers in CLUSTERS.items()
        },
    }


def _rated(store: Store) -> Ratings:
    if store.ratings is None:
        raise ParameterError(f"{store.path}: has no ratings")
    return store.ratings


def _means(ratings: Ratings, items: Sequence[str]) -> NDArray[np.float64]:
    """Return the mean scores of items, on their scale, shape (item, word)."""
    return np.array([ratings.scale.from_unit(ratings.rated(item).means) for item in items])


def _summary(cells: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    return {name: spread([cell[name] for cell in cells]) for name in FIGURES} | {
        "error_by_cluster": {
            name: mean(cell["error_by_cluster"][name] for cell in cells) for name in CLUSTERS
        }
    }


def _text(result: Mapping[str, Any]) -> str:
    heads = [*FIGURES, *(f"cluster {name}" for name in CLUSTERS)]
    lines = [
        f"Simulated plates, scored by {result['told_by']}",
        f"{'':34}{'signals':>8}" + "".join(f"{head:>16}" for head in heads),
    ]
    rows = [
        (TITLES[kind], count, row) for count, kinds in result["rows"].items() for kind, row in kinds.items()
    ]
    for title, count, row in [*rows, ("the plates themselves", "", result["plates"])]:
        cells = [text_of(row[name], digits=3) for name in FIGURES]
        cells += [f"{row['error_by_cluster'][name]:.3f}" for name in CLUSTERS]
        lines.append(f"{title:34}{count:>8}" + "".join(f"{cell:>16}" for cell in cells))
    return "\n".join(lines)
