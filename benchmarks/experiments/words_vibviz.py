"""Vibrations from words on VibViz: texture_flow trained on some effects, asked for the scores of others.

The effects are drawn into thirds. One trains the generator, one a rater model, and the mean ratings of the third are
asked; every third is asked once. The rater model so knows neither what the generator learned from nor what is asked. A
second rater model also knows the generator's effects, and twice as many.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import RecordingInfo, Store, open_store
from tactogram.errors import DataError, ParameterError
from tactogram.evaluation.ratings.reproduction import label_fidelity
from tactogram.signal import Signal
from tactogram.workflows.data.stores import import_store
from tactogram.workflows.evaluation.ratings import predicted_ratings
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.loaded_run import LoadedRun, load_run
from tactogram_benchmark.experiments.artifacts import spread, trained_run
from tactogram_benchmark.experiments.picture_cells import text_of

PARTS = 3
LEAST_S = 0.16
"""Shorter effects do not hold two windows of the recipe `rated`."""
KINDS = {
    "generated": "texture_flow, given the scores",
    "nearest": "the generator's effect nearest in words",
    "itself": "the effect itself",
    "random": "a random one of the generator's",
}
RATERS = {"other": "a third that nobody else saw", "both": "that third and the generator's"}
FIGURES = ("correlation", "slope", "error")


def run(
    folder: Path, *, paper: bool, progress: ProgressCallback, data: str = "", drawings: int = 3
) -> dict[str, Any]:
    """Return how closely the scores of each kind of signal follow those asked, by each rater model.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``paper`` changes nothing.
    data : str
        Store of VibViz, or the folder of its files.
    drawings : int
        Drawings of the thirds, each with its own seed of the trainings.
    """
    if not data:
        raise ParameterError("data must be a store of VibViz, or the folder of its files")
    try:
        store = open_store(data)
    except DataError:
        made = folder / "data"
        if not (made / "dataset.json").is_file():
            import_store("vibviz", data, made, progress=progress)
        store = open_store(made)
    effects = {
        info.labels["item"]: info
        for info in store.index
        if store.length(info.id, "vibration") / store.rate(info.id, "vibration") >= LEAST_S
    }
    found: dict[str, dict[str, list[dict[str, Any]]]] = {by: {kind: [] for kind in KINDS} for by in RATERS}
    for seed in range(drawings):
        shuffled = np.random.default_rng(seed).permutation(sorted(effects)).tolist()
        thirds = [shuffled[part::PARTS] for part in range(PARTS)]
        for number, asked in enumerate(thirds):
            known, others = (thirds[(number + step) % PARTS] for step in (1, 2))
            place = folder / "runs" / f"{seed}-{number}"
            learned: dict[str, Any] = {"split": "all", "changes": {"seed": seed}, "progress": progress}
            generator = load_run(
                trained_run(
                    "texture_flow", store, place / "generator",
                    recipe="rated", label="item", where={"item": "|".join(known)}, **learned,
                )
            )  # fmt: skip
            signals = _signals(generator, store, effects, known, asked, np.random.default_rng([seed, number]))
            targets = _means(store, asked)
            for by, items in {"other": others, "both": [*others, *known]}.items():
                rater = trained_run(
                    "rater", store, place / by, recipe="vibviz", where={"item": "|".join(items)}, **learned
                )
                for kind, given in signals.items():
                    said = predicted_ratings(rater, given)
                    scores = np.array([said.means[said.items.index(item)] for item in asked])
                    found[by][kind].append(label_fidelity(targets, scores[:, None]).as_dict())
    rows = {
        by: {kind: _summary(parts, drawings) for kind, parts in kinds.items()} for by, kinds in found.items()
    }
    words = store.ratings.words if store.ratings else ()
    result = {
        "simulated": store.simulated,
        "data": store.name,
        "data_sha256": store.sha256,
        "effects": len(effects),
        "split": f"{PARTS} parts by item: generator, rater model, asked; each asked once",
        "drawings": drawings,
        "recipe": "rated",
        "words": list(words),
        "by": rows,
    }
    return result | {"text": _text(result)}


def _signals(
    generator: LoadedRun,
    store: Store,
    effects: Mapping[str, RecordingInfo],
    known: Sequence[str],
    asked: Sequence[str],
    rng: np.random.Generator,
) -> dict[str, dict[str, Signal]]:
    """Return the signals of each kind, by the item asked."""
    recorded = {item: store.signal(effects[item].id, "vibration") for item in (*known, *asked)}
    wanted, rated = _means(store, asked), _means(store, known)
    words = generator.kind.words
    nearest = [known[int(((rated - row) ** 2).sum(1).argmin())] for row in wanted]
    made = {
        item: generator.generator.generate({"words": dict(zip(words, row, strict=True))}, seed=number)
        for number, (item, row) in enumerate(zip(asked, wanted.tolist(), strict=True))
    }
    return {
        "generated": {item: signal for item, signal in made.items() if isinstance(signal, Signal)},
        "nearest": {item: recorded[name] for item, name in zip(asked, nearest, strict=True)},
        "itself": {item: recorded[item] for item in asked},
        "random": {item: recorded[str(rng.choice(known))] for item in asked},
    }


def _means(store: Store, items: Sequence[str]) -> NDArray[np.float64]:
    """Return the mean scores of items, on their scale, shape (item, word)."""
    if store.ratings is None:
        raise ParameterError(f"{store.path}: has no ratings")
    return np.array([store.ratings.scale.from_unit(store.ratings.rated(item).means) for item in items])


def _summary(parts: Sequence[Mapping[str, Any]], drawings: int) -> dict[str, Any]:
    """Return mean and sd over drawings of the means over their parts; correlations are means over words."""
    per_word = np.array([part["by_word"] for part in parts]).reshape(drawings, PARTS, -1).mean(1)
    values = {name: np.array([part[name] for part in parts]) for name in ("slope", "error")}
    means = {name: held.reshape(drawings, PARTS).mean(1).tolist() for name, held in values.items()}
    return {
        "correlation": spread(per_word.mean(1).tolist()),
        **{name: spread(held) for name, held in means.items()},
        "correlation_by_word": per_word.mean(0).tolist(),
    }


def _text(result: Mapping[str, Any]) -> str:
    lines = [f"Scores asked and predicted, {result['data']}, {result['effects']} effects, {result['split']}"]
    for by, kinds in result["by"].items():
        lines.append(f"{'rater model of ' + RATERS[by]:42}" + "".join(f"{name:>18}" for name in FIGURES))
        lines += [
            f"{KINDS[kind]:42}" + "".join(f"{text_of(row[name], digits=2):>18}" for name in FIGURES)
            for kind, row in kinds.items()
        ]
    return "\n".join(lines)
