"""A surface that no model has met, from one stroke of it or from words: texture_flow beside baselines.

Simulated surfaces of a seed that it was not trained on, at the speeds and forces of their other strokes; and
recordings, given the first of each material and compared with the last two. Baselines are fitted to the same stroke.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets import RecordingInfo, Store, open_store
from tactogram.errors import DataError, ParameterError
from tactogram.evaluation.measures import (
    amplitude_distance,
    envelope_spectrum_distance,
    level_difference_db,
    log_spectral_distance,
    modulation_spectrum_distance,
)
from tactogram.signal import Signal
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.modulated_noise_synthesis import synthesise_modulated_noise
from tactogram.signal.resampling import resample
from tactogram.signal.synthesis import synthesise
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.loaded_run import LoadedRun, load_run
from tactogram_simulate import simulate_to_store

MEASURES: dict[str, Callable[[Sequence[Signal], Sequence[Signal]], float]] = {
    "spectrum": log_spectral_distance,
    "level": level_difference_db,
    "envelope": envelope_spectrum_distance,
    "modulation": modulation_spectrum_distance,
    "amplitude": amplitude_distance,
}
SURFACES, OTHERS, SEED = 40, 3, 1
LAST = 2
"""Recordings of a material that are compared with."""
SECONDS = 4.0
"""Length of what is generated."""
Make = Callable[[int], Signal]
"""A signal of a seed."""


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    generator: str = "texture_flow",
    surfaces: int = SURFACES,
    others: int = OTHERS,
    recorded: str = "",
    drawings: int = 3,
) -> dict[str, Any]:
    """Return the distances of what each method makes to the strokes, means over surfaces.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``paper`` changes nothing.
    generator : str
        Run of texture_flow, or the one that it comes with.
    surfaces, others : int
        Number of simulated surfaces, and of strokes of each besides the given one.
    recorded : str
        Stores of recordings with materials, separated by commas; "" for none.
    drawings : int
        Seeds of everything that is generated.
    """
    loaded = load_run(generator)
    try:
        store = open_store(folder / "surfaces")
    except DataError:
        simulate_to_store("surfaces", folder / "surfaces", seed=SEED, random=surfaces, progress=progress)
        store = open_store(folder / "surfaces")
    groups, rows = _by_material(store), []
    for number, group in enumerate(groups, 1):
        rows += _other_speeds(loaded, store, group[: others + 1], drawings)
        progress("surfaces", number, len(groups))
    strokes = means(rows)
    result: dict[str, Any] = {
        "generator": {"run_id": loaded.run.data["run_id"], "data": loaded.run.data.get("name")},
        "simulated": True,
        "data": store.name,
        "data_sha256": store.sha256,
        "drawings": drawings,
        "strokes": strokes,
        "recordings": {},
    }
    for real in map(open_store, filter(None, recorded.split(","))):
        rows = [_same_speed(loaded, real, group, drawings) for group in _by_material(real)]
        result["recordings"][real.name] = {"sha256": real.sha256, "simulated": real.simulated} | means(rows)
    return result | {"text": _text(result)}


def _by_material(store: Store) -> list[list[RecordingInfo]]:
    groups: dict[str, list[RecordingInfo]] = {}
    for info in store.index:
        groups.setdefault(str(info.material), []).append(info)
    return list(groups.values())


def _other_speeds(
    loaded: LoadedRun, store: Store, group: Sequence[RecordingInfo], drawings: int
) -> list[dict[str, dict[str, float]]]:
    """Return the distances to each other stroke of a surface, given the first and its speed and force, or words."""
    first, *others = group
    given = _prepared(loaded, store, first)
    baselines = {name: cache(make) for name, make in _baselines(given).items()}
    known = {"vibration_speed_mm_s": first.speed_mm_s, "vibration_force_n": first.force_n}
    described: dict[str, dict[str, Any]] = {
        "from the stroke": {"vibration": given, **known},
        "from the stroke, its speed unknown": {"vibration": given},
        "from ten words": {"words": _words(store, str(first.material))},
    }
    rows = []
    for wanted in others:
        at = {"speed_mm_s": wanted.speed_mm_s, "force_n": wanted.force_n}
        ratio = float(wanted.speed_mm_s or np.nan) / float(first.speed_mm_s or np.nan)
        made: dict[str, Make] = {
            **baselines,
            "replay, spectrum scaled with the speed": partial(_scaled, given, ratio),
            **{name: partial(generated, loaded, {**each, **at}) for name, each in described.items()},
        }
        rows.append(distances(made, [_prepared(loaded, store, wanted)], drawings))
    return rows


def _same_speed(
    loaded: LoadedRun, store: Store, group: Sequence[RecordingInfo], drawings: int
) -> dict[str, dict[str, float]]:
    """Return the distances to the last recordings of a material, given the first."""
    given, *others = (_prepared(loaded, store, info) for info in group)
    made: dict[str, Make] = {
        "other recordings": lambda seed: others[seed % (len(others) - LAST)],
        **_baselines(given),
        "from the stroke": partial(generated, loaded, {"vibration": given}),
    }
    return distances(made, others[-LAST:], drawings)


def _words(store: Store, item: str) -> dict[str, float]:
    """Return the mean scores of an item, on the scale of its ratings."""
    if store.ratings is None:
        raise ParameterError(f"{store.path}: has no ratings")
    low, high = store.ratings.scale.low, store.ratings.scale.high
    means = store.ratings.rated(item).means
    scored = zip(store.ratings.words, means, strict=True)
    return {word: low + float(mean) * (high - low) for word, mean in scored if np.isfinite(mean)}


def _prepared(loaded: LoadedRun, store: Store, info: RecordingInfo) -> Signal:
    return loaded.prepare_vibration(
        store.signal(info.id, loaded.recipe.prepare.stream_of(store.streams_of(info.id)))
    )


def generated(loaded: LoadedRun, condition: Mapping[str, Any], seed: int) -> Signal:
    return loaded.generator.generate(condition, seconds=SECONDS, seed=seed)  # type: ignore[return-value]


def _baselines(given: Signal) -> dict[str, Make]:
    fitted = fit_modulated_noise(given)
    model = fit_autoregressive(given)
    return {
        "replay": lambda seed: given,
        "ar_texture": lambda seed: synthesise(model, SECONDS, seed=seed),
        "texture_var": lambda seed: synthesise_modulated_noise(fitted, SECONDS, seed=seed),
    }


def _scaled(signal: Signal, ratio: float, seed: int) -> Signal:
    """Return a signal played faster by ``ratio``, at its own rate, again and again."""
    faster = resample(signal, signal.rate / ratio)
    times = int(np.ceil(SECONDS * signal.rate / len(faster)))
    return faster.with_samples(np.tile(faster.samples, times), rate=signal.rate)


def distances(made: Mapping[str, Make], real: Sequence[Signal], drawings: int) -> dict[str, dict[str, float]]:
    return {
        name: {
            measure: float(np.mean([distance([make(seed)], real) for seed in range(drawings)]))
            for measure, distance in MEASURES.items()
        }
        for name, make in made.items()
    }


def means(rows: Sequence[Mapping[str, Mapping[str, float]]]) -> dict[str, dict[str, float]]:
    return {
        name: {measure: float(np.mean([row[name][measure] for row in rows])) for measure in MEASURES}
        for name in rows[0]
    } | {"number": {"rows": len(rows)}}


def _text(result: Mapping[str, Any]) -> str:
    lines = []
    titles = {f"other strokes of {result['data']}": result["strokes"]}
    titles |= {f"the last recordings of {name}": part for name, part in result["recordings"].items()}
    for title, part in titles.items():
        lines += table(f"to {title}", part)
    return "\n".join(lines)


def table(title: str, rows: Mapping[str, Any]) -> list[str]:
    """Return lines of distances, as of `means`."""
    lines = [f"{title:42}" + "".join(f"{name:>12}" for name in MEASURES)]
    return lines + [
        f"{name:42}" + "".join(f"{row[measure]:>12.2f}" for measure in MEASURES)
        for name, row in rows.items()
        if name not in ("number", "sha256", "simulated")
    ]
