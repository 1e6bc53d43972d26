"""Cells of the tables of Neshov et al. 2026: one training each, its figures, and their comparison."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast, get_args

from scipy.stats import ttest_rel

from tactogram.datasets import Store
from tactogram.errors import DataError, ParameterError
from tactogram.evaluation import PictureWeights
from tactogram.features import Protocol
from tactogram.nn import ALEXNET, DENSENET201, INCEPTION, VGG19, weight_file
from tactogram.recipe import Preparation
from tactogram.workflows import ProgressCallback, evaluate_pictures, train
from tactogram_benchmark.experiments.artifacts import cached_result, facts_of, find_or_simulate, spread

MEASURES = (
    "lpips",
    "fid",
    "efficientnet_lite0_distance",
    "efficientnet_lite0_frechet_distance",
    "log_spectral_distance_db",
    "level_difference_db",
    "l1",
)
"""Measures of a cell; lower is better. Those whose networks are not available are left out."""
SIMULATED = "stroking9"
PERCEPTUAL, PREDICTING = ("pix2pixhd", "residue_fusion_gan"), ("visual_tactile_gan", "residue_fusion_gan")
"""Models with a perceptual loss; with a label predictor."""
WEIGHTS = {"alexnet": ALEXNET, "inception": INCEPTION, "vgg19": VGG19, "densenet201": DENSENET201}
"""Published weights by the option that names their file."""
EVALUATED = 128
"""Pairs of the test part of each cell."""
EVALUATED_PAPER = 900
"""Pairs of the published test part, 100 of each of nine materials (Sec. 4.1)."""
DATA = {"photographs": 9}
"""Simulated data: photographs of each surface, without overlap, of 224 x 224 pixels."""
DATA_PAPER = {"photographs": 4, "rate": 10_000.0, "seconds": 4.8, "per_class": 10}
"""As LMT-108 (Sec. 4.1): ten recordings of 4.8 s at 10 kHz of each surface. There is room for four photographs of
336 x 336 pixels, which the published crops of 256 fit into; LMT-108 has ten of 320 x 480."""


@dataclass(frozen=True)
class TableSettings:
    """Size, protocol of pairs and weights of all cells of a table (`table_settings`)."""

    paper: bool
    protocol: Protocol
    weights: Mapping[str, str]
    """File by network, of those that are there."""
    missing: Mapping[str, str]
    """Reason by network, of those that are not."""

    @property
    def recipe(self) -> str:
        """Recipe of every training."""
        return "paper" if self.paper else "bench"

    def weight_changes(self, model: str) -> dict[str, Any]:
        """Return the changes of a model's recipe that name its files of weights."""
        files = {"config.lpips_weights": ALEXNET, "config.predictor.trunk_weights": DENSENET201}
        if not self.paper:
            files = {}  # bench chooses by row statistics, and its label predictor has another network
        elif model not in PREDICTING:
            del files["config.predictor.trunk_weights"]
        if model in PERCEPTUAL:
            files["config.vgg_weights"] = VGG19
        return {
            key: self.weights[file.network] for key, file in files.items() if file.network in self.weights
        }

    def split(self, store: Store) -> str:
        """Return the split of recordings: 80/10/10 at the published size, all where the protocol splits crops."""
        if self.protocol != "source-split":
            return "all"
        if not self.paper:
            return ""
        fewest = min(Counter(info.material for info in store.index).values())
        return f"last={max(1, round(fewest / 10))}"

    def run_name(self, name: str, model: str) -> str:
        """Return the name of a row's runs, another one for settings that train differently."""
        protocol = [] if self.protocol == "source-split" else [self.protocol]
        perceptual = ["perceptual"] * (model in PERCEPTUAL and VGG19.network in self.weights)
        return "-".join([name.lower().replace(" ", "-"), *protocol, *perceptual])


def table_settings(*, paper: bool, protocol: str, progress: ProgressCallback, **files: str) -> TableSettings:
    """Return the settings of a table; missing weights are reported now, before anything is trained.

    An empty ``protocol`` is the paper's for ``paper``, otherwise ours. ``files`` are some of `WEIGHTS`, searched in
    torch's cache where empty.

    Raises `ParameterError` if there is no such protocol; `DataError` if a given file does not exist, or a published
    training needs a network that is missing.
    """
    protocol = protocol or ("crop-split" if paper else "source-split")
    if protocol not in get_args(Protocol):
        raise ParameterError.one_of("protocol", get_args(Protocol), protocol)
    paths, missing = dict[str, str](), dict[str, str]()
    for option, file in files.items():
        weights = WEIGHTS[option]
        if weights is DENSENET201 and not paper:
            continue
        try:
            paths[weights.network] = str(weight_file(file, weights, option=option))
        except DataError as error:
            if file or weights is DENSENET201:
                raise
            missing[weights.network] = str(error)
            progress(f"weights of {weights.network}", 1, 1, str(error))
    return TableSettings(paper, cast(Protocol, protocol), paths, missing)


def data_of(folder: Path, data: str, *, paper: bool, progress: ProgressCallback) -> Store:
    """Return the store at ``data``, or simulated surfaces: for ``paper`` in the layout of LMT-108."""
    name, options = ("data-paper", DATA_PAPER) if paper else ("data", DATA)
    return find_or_simulate(folder / name, SIMULATED, given=data, progress=progress, **options)


def axis_of(store: Store) -> dict[str, Any]:
    """Return the change of the recipe that selects one of several axes: z, or the last (Sec. 4.1)."""
    name = Preparation().stream_of(tuple(store.streams))
    axes = store.streams[name].axes
    if len(axes) < 2:
        return {}
    return {"prepare.axes": ["z" if "z" in axes else axes[-1]]}


def table_cells(
    folder: Path,
    store: Store,
    rows: Mapping[str, tuple[str, Mapping[str, Any]]],
    *,
    settings: TableSettings,
    trainings: int,
    progress: ProgressCallback,
) -> dict[str, list[dict[str, Any]]]:
    """Return the figures of each row's trainings, one for each seed, cached in ``cells/NAME-SEED.json``.

    ``rows`` has the model of each, and the changes of its recipe. The seed determines weights, crops and split, so
    cells of one seed share a split and are paired.

    Returns
    -------
    dict
        Of each cell ``validation`` (used to select weights, not on the test part), ``values`` (`MEASURES`, test part),
        ``missing`` (reasons by measure), ``pictures`` (their number).
    """
    return {
        name: [
            _cell(folder, store, name, model, settings, changes, seed, progress) for seed in range(trainings)
        ]
        for name, (model, changes) in rows.items()
    }


def _cell(
    folder: Path,
    store: Store,
    name: str,
    model: str,
    settings: TableSettings,
    changes: Mapping[str, Any],
    seed: int,
    progress: ProgressCallback,
) -> dict[str, Any]:
    split, files = settings.split(store), settings.weights
    weights = PictureWeights(files.get(ALEXNET.network, ""), files.get(INCEPTION.network, ""))
    changes = {**axis_of(store), "config.pairs.protocol": settings.protocol, **changes}
    facts = {
        "model": model,
        "recipe": settings.recipe,
        "changes": changes,
        "seed": seed,
        "data_sha256": store.sha256,
    }
    facts |= {"split": split} if split else {}
    facts |= {"weights": sorted(files)} if files else {}
    name = settings.run_name(name, model)

    def evaluated() -> dict[str, Any]:
        run = run_of(folder, name, seed)
        trained = train(
            model,
            store.path,
            recipe=settings.recipe,
            changes=changes | settings.weight_changes(model) | {"seed": seed},
            split=split,
            out=run,
            resume=(run / "recipe.toml").exists(),
            progress=progress,
        )
        validation = trained.facts().get("validation", {})
        most = EVALUATED_PAPER if settings.paper else EVALUATED
        measured = evaluate_pictures(run, weights=weights, most=most, progress=progress)
        return {"validation": validation, **measured}

    return cached_result(folder / "cells" / f"{name}-{seed}.json", facts, evaluated)


def run_of(folder: Path, name: str, seed: int) -> Path:
    """Return the folder of a cell's run."""
    return folder / "runs" / f"{name}-{seed}"


def facts_of_cells(
    store: Store, settings: TableSettings, cells: Mapping[str, Sequence[Mapping[str, Any]]]
) -> dict[str, Any]:
    """Return the facts of a table in its result."""
    row = next(iter(cells.values()))
    facts = {"protocol": settings.protocol, "trainings": len(row)}
    return {**facts_of(store), **facts, "pictures": row[0]["pictures"], "missing": row[0]["missing"]}


def about_cells(result: Mapping[str, Any], chosen: str) -> str:
    """Return the data and the number of trainings of a table, and what p is against, in words."""
    kind = "simulated strokes" if result["simulated"] else "recordings"
    return (
        f"{result['data']}, {kind}, {result['protocol']}, {result['trainings']} trainings, {result['pictures']} test "
        f"pairs, mean ± sd [p against {chosen}]"
    )


def cell_texts(row: Mapping[str, Any], *, digits: int = 4) -> list[str]:
    """Return a row's figures on the test part, each with its p."""
    return [text_of(row["test"][key], digits=digits) + p_text(row["p"][key]) for key in row["test"]]


def shown(cells: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the measures available in every cell."""
    return [name for name in MEASURES if all(name in cell["values"] for cell in cells)]


def compared(cells: Mapping[str, Sequence[Mapping[str, Any]]], chosen: str) -> dict[str, dict[str, Any]]:
    """Return each row's figures on the test part: ``test``, and ``p`` against the row ``chosen``."""
    measures = shown([cell for row in cells.values() for cell in row])
    values = {
        name: {measure: [cell["values"][measure] for cell in row] for measure in measures}
        for name, row in cells.items()
    }
    return {
        name: {
            "test": {measure: spread(row[measure]) for measure in measures},
            "p": {
                measure: None if name == chosen else against(values[chosen][measure], row[measure])
                for measure in measures
            },
        }
        for name, row in values.items()
    }


def against(proposed: Sequence[float], other: Sequence[float]) -> float | None:
    """Return p of a two-sided paired t-test (Sec. 4.3); None for fewer than three pairs or equal values."""
    if len(proposed) < 3 or all(a == b for a, b in zip(proposed, other, strict=True)):
        return None
    return float(ttest_rel(proposed, other).pvalue)


def text_of(found: Mapping[str, Any], *, digits: int = 4) -> str:
    """Return mean ± sd in the paper's format."""
    sd = "" if found["sd"] is None else f" ± {found['sd']:.{digits}f}"
    return f"{found['mean']:.{digits}f}{sd}"


def p_text(p: float | None) -> str:
    """Return p in brackets, empty if there is none."""
    return "" if p is None else f" [{p:.2g}]"
