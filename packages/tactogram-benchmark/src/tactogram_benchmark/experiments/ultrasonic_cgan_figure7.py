"""Hatori & Takemura 2023, Figure 7: errors of word ratings of generated signals against the plates', groups A to E.

The raters are simulated people who took no part in the training data, and a rater model trained on
the display signals; every figure and table states which. ``ratings=FILE`` makes the figure from real answers
about the signals of this experiment (listed in ``items.csv``). A further condition is the
display signal nearest in words, which a model must outperform.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.cli.printing import columns
from tactogram.datasets import Ratings, Store, read_table, write_table
from tactogram.errors import ParameterError
from tactogram.evaluation import (
    NEAREST,
    STRAIGHT,
    one_rater_error,
    save_figure,
    split_half_error,
)
from tactogram.signal import Signal
from tactogram.workflows import (
    ProgressCallback,
    crossval,
    evaluate_reproduction,
    generate_rated_surfaces,
    predicted_ratings,
)
from tactogram_benchmark.experiments.artifacts import (
    facts_of,
    find_or_simulate,
    listed,
    spread,
    trained_run,
    write_items,
)
from tactogram_benchmark.experiments.word_map import distances_to_targets, word_map_figure
from tactogram_simulate import draw_people, score_vibrations

GROUPS = {"A": 1, "B": 2, "C": 3, "D": 4, "E": 12}
"""Clusters of the plates in each group. Sec. IV-B."""
SIGNIFICANT = ("B", "C", "D")
"""Published: errors below those of the sensor's signal, p < 0.01, but not for A; E's training failed. No means are
given. Sec. V-A."""
PEOPLE = 20
"""Different people from those of the training data. Sec. V-A."""
SIMULATED_RATERS = "simulated raters"


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    ratings: str = "",
    groups: str = "A,B,C,D,E",
    trainings: int = 1,
    recipe: str = "",
) -> dict[str, Any]:
    """Return the errors of each group by raters, and the figures' files.

    Parameters
    ----------
    data : str
        Store of rated plates and display signals; default: the simulated study.
    ratings : str
        Table of answers about the items in ``items.csv``: CSV, TSV or Parquet.
    groups : str
        Names, separated by commas.
    trainings : int
        Seeds per group. The first is rated; the others show the variation between trainings.
    recipe : str
        Recipe of the generators; default: ``paper``, or ``quick`` for the bench.
    """
    store = find_or_simulate(folder / "data", "ultrasonic", given=data, progress=progress)
    chosen = chosen_groups(groups)
    recipe = recipe or ("paper" if paper else "quick")
    results = {
        name: [
            _group(folder, store, name, seed=seed, recipe=recipe, progress=progress)
            for seed in range(trainings)
        ]
        for name in chosen
    }
    first = next(iter(results.values()))[0]
    conditions = (STRAIGHT, NEAREST, *chosen)
    rated = {STRAIGHT: first.straight, NEAREST: first.nearest}
    rated |= {name: held[0].signals for name, held in results.items()}
    signals = {f"{name}/{item}": signal for name, held in rated.items() for item, signal in held.items()}
    items = write_items(folder, signals)
    plates = first.ratings.select(items=list(first.targets))
    rater, own = _rater(folder, store, progress)
    tables = _tables(folder, store, signals, rater=rater, ratings=ratings, words=plates.words)
    human = {
        "one_rater_mae": float(np.nanmean(one_rater_error(plates.cube))),
        "split_half_mae": float(np.nanmean(split_half_error(plates.cube, rng=np.random.default_rng(0)))),
    }
    of_people = {"one rater of the plates, the others": human["one_rater_mae"]}
    of_model = {
        "half of the plates' raters, other half": human["split_half_mae"],
        "the rater model itself": own["mean"]["mae"],
    }
    told = {
        by: evaluate_reproduction(
            table,
            first.targets,
            conditions=conditions,
            told_by=by,
            out=folder / f"figure7-{by.replace(' ', '-')}.png",
            beside=of_model if by.startswith(RATER_MODEL) else of_people,
        )
        for by, table in tables.items()
    }
    shown_by = next((by for by in ("people", SIMULATED_RATERS) if by in tables), next(iter(tables)))
    result: dict[str, Any] = {
        "figure": 7,
        **facts_of(store),
        "recipe": recipe,
        "split": f"rated surfaces by session; the sensor's recordings: {first.recordings}",
        "trainings": trainings,
        "failed": {name: dict(held[0].failed) for name, held in results.items() if held[0].failed},
        "told_by": told,
        "spread_over_trainings": _spread(results, rater, first.targets) if trainings > 1 else {},
        "rater": {
            "error": own["mean"],
            "per_word": own["per_word"],
            "split": own["split"],
            "described_by": own["described_by"],
        },
        "human": human,
        "word_map": _word_map(folder, tables[shown_by], shown_by, first, told[shown_by], tuple(chosen)),
        "items": str(items),
        "published": {"below_sensor_p_001": list(SIGNIFICANT), "not": ["A"], "failed": ["E"]},
    }
    return result | {"text": figure7_text(result, conditions)}


def chosen_groups(groups: str) -> list[str]:
    """Return the named groups in the paper's order."""
    names = listed(groups, GROUPS, "groups")
    if not names:
        raise ParameterError.must("groups", f"be some of {', '.join(GROUPS)}, got none")
    return [name for name in GROUPS if name in names]


def _group(
    folder: Path,
    store: Store,
    name: str,
    *,
    seed: int,
    recipe: str,
    progress: ProgressCallback,
) -> Any:
    changes = {"config.clusters": GROUPS[name], "seed": seed}
    options: dict[str, Any] = {"recipe": recipe, "by": "session", "changes": changes}
    out = folder / "runs" / f"{name}-{seed}"
    trained_run("ultrasonic_cgan", store, out, **options, progress=progress)
    return generate_rated_surfaces(out, seed=seed)


def _tables(
    folder: Path,
    store: Store,
    signals: Mapping[str, Signal],
    *,
    rater: Path,
    ratings: str,
    words: Sequence[str],
) -> dict[str, Ratings]:
    """Return the ratings of ``signals`` by simulated raters, by the rater model and by people."""
    tables: dict[str, Ratings] = {}
    if store.simulated:
        people = draw_people(PEOPLE, seed=1, prefix="judge")
        tables[SIMULATED_RATERS] = score_vibrations(signals, people, seed=0).in_words(words)
        write_table(folder / "simulated-answers.csv", tables[SIMULATED_RATERS])
    of = " of simulated raters" if store.simulated else ""
    tables[RATER_MODEL + of] = predicted_ratings(rater, signals)
    if ratings:
        tables["people"] = read_table(Path(ratings)).ratings.in_words(words)
    return tables


def _rater(folder: Path, store: Store, progress: ProgressCallback) -> tuple[Path, dict[str, Any]]:
    """Return a rater model of all display signals, and its cross-validated error."""
    changes = {"prepare.stream": "drive"}
    options: dict[str, Any] = {"recipe": "quick", "split": "all", "changes": changes}
    out = trained_run("rater", store, folder / "runs" / "rater", **options, progress=progress)
    own = crossval(
        "rater",
        store.path,
        changes=changes,
        folds=10,
        repeats=1,
        out=folder / "rater-crossval",
        progress=progress,
    )
    return out, own


def _spread(results: Mapping[str, list[Any]], rater: Path, targets: Mapping[str, Any]) -> dict[str, Any]:
    """Return each group's error according to the rater model, mean and sd over trainings."""
    spreads = {}
    for name, trained in results.items():
        errors = []
        for training in trained:
            if training.signals:
                said = predicted_ratings(rater, training.signals)
                away = said.means - np.array([targets[item] for item in said.items])
                errors.append(float(np.nanmean(np.abs(away))))
        spreads[name] = spread(errors) | {"plates": [len(training.signals) for training in trained]}
    return spreads


def _word_map(
    folder: Path, table: Ratings, told_by: str, first: Any, told: Mapping[str, Any], groups: tuple[str, ...]
) -> dict[str, Any]:
    """Draw plates, display signals and the best group's signals by their scores; return all distances to targets."""
    scores = dict(zip(table.items, table.means, strict=True))
    targets = {item: np.array(row) for item, row in first.targets.items()}
    distances = distances_to_targets(scores, targets)
    means = dict(zip(first.ratings.items, first.ratings.means, strict=True))
    known = [name for name in groups if name in told["conditions"] and name not in told["incomplete"]]
    kinds = {"plates": targets, "display signals": {n: m for n, m in means.items() if n not in targets}}
    lines: dict[str, str] = {}
    best = min(known, key=lambda name: told["conditions"][name]["mae"]) if known else None
    for name in (STRAIGHT, *([best] if best else [])):
        kind = "sensor's signal" if name == STRAIGHT else f"generated, group {name}"
        kinds[kind] = {i: scores[f"{name}/{i}"] for i in targets if f"{name}/{i}" in scores}
        if name == best:
            lines = {f"{kind}:{item}": f"plates:{item}" for item in kinds[kind]}
    title = (
        f"Words of plates, display signals and generated signals ({told_by}); line: rms distance to its plate"
    )
    figure = word_map_figure(kinds, table.words, targets=lines, title=title)
    return {
        "figure": str(save_figure(folder / "word-map.png", figure)),
        "told_by": told_by,
        "drawn": best,
        "distance_to_target": {name: away for name, (_, away) in distances.items()},
    }


RATER_MODEL = "a rater model"
KNOWS_NEAREST = (
    "The rater model was trained on the display signals, so its error is smaller for the nearest of them, or a copy, "
    "than for a new signal."
)
HEADER = ("condition", "MAE", "SE", "n", "plates", "p as printed", "p by rater", "p by plate")


def figure7_text(result: Mapping[str, Any], conditions: tuple[str, ...]) -> str:
    """Return the errors of each condition (a row each, in this order) by raters, from the result of ``run``."""
    lines = [
        f"Figure 7 on {result['data']}, recipe {result['recipe']}; p against the sensor's signal. "
        "Published: B, C and D below it with p < 0.01, A not, E failed."
    ]
    for by, told in result["told_by"].items():
        lines.append(f"Rated by {by}:")
        lines.append(
            columns([HEADER, *([_cell(value) for value in row] for row in _rows(result, by, conditions))])
        )
        lines += [f"  {name}: {value:.3f}" for name, value in told["beside"].items()]
        if by.startswith(RATER_MODEL):
            lines.append(f"  {KNOWS_NEAREST}")
    for name, row in result["spread_over_trainings"].items():
        if row["mean"] is not None:
            sd = "" if row["sd"] is None else f" ± {row['sd']:.3f}"
            lines.append(
                f"group {name} over {len(row['values'])} trainings, by the rater model: {row['mean']:.3f}{sd}"
            )
    for name, failed in result["failed"].items():
        lines += [f"group {name}, {item}: {why}" for item, why in failed.items()]
    return "\n".join(lines)


def _rows(result: Mapping[str, Any], by: str, conditions: tuple[str, ...]) -> list[tuple[Any, ...]]:
    """Return a row per condition: error, standard errors, n, p as printed and by rater, against the sensor."""
    told = result["told_by"][by]
    rows = []
    for name in conditions:
        row = told["conditions"].get(name)
        if row is None:
            rows.append((name, None, None, None, "failed", None, None, None))
            continue
        ps = [_p(told["tests"][test], name) for test in ("as_printed", "by_rater", "by_target")]
        rows.append((name, row["mae"], row["se"], row["n"], row["targets"], *ps))
    return rows


def _p(pairs: list[dict[str, Any]] | None, name: str) -> float | None:
    for pair in pairs or ():
        if {pair["first"], pair["second"]} == {STRAIGHT, name}:
            return pair["p"]  # type: ignore[no-any-return]
    return None


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.2g}" if abs(value) < 0.01 else f"{value:.3f}"
    return "-" if value is None else str(value)
