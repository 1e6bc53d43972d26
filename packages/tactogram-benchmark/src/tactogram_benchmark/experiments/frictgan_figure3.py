"""Cai et al. 2020, Figure 3 and Section 4: friction of five fabrics from their photographs, and its squared error.

Adds what the paper calls future work (Sec. 5): the Geometry Score, models without critic or L1 distance, texture-free
models of friction, and mixes of fabrics. The paper's five fabrics of HapTex are not named; `--data` takes a store of
them, or of the authors' own windows (`tactogram data import frictgan`), whose parts are kept. Distances are blind to
phase, see `tactogram.models.frictgan.fabric_evaluation`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import torch
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from torch import Tensor

from tactogram.cli.printing import columns
from tactogram.datasets import Examples, Segment, Store, part_examples
from tactogram.errors import MissingExtraError, ParameterError
from tactogram.evaluation import COLOURS, save_figure
from tactogram.features import FrictionBatch
from tactogram.model import Example
from tactogram.models.frictgan import MODELS, FrictGANLearner, compare_fabrics, fabric_windows, summary
from tactogram.workflows import ProgressCallback, load_run, test_part
from tactogram_benchmark.experiments.artifacts import (
    Training,
    cached_result,
    facts_of,
    find_or_simulate,
    listed,
    spread,
    trained_runs,
)
from tactogram_benchmark.experiments.geometry_score import geometry_score
from tactogram_benchmark.experiments.picture_cells import text_of

PUBLISHED = (0.006, 0.005, 0.014, 0.005, 0.005)
"""Sec. 4: mean squared error of the fabrics of Figure 3, from top to bottom; "averagely 0.035" is their sum."""
FABRICS = 5
PART, TEST = "part", "test"
"""Label and value of the published test windows (`tactogram_benchmark.importers.frictgan`)."""
PROPOSED = "frictgan"
ABLATIONS: Mapping[str, Mapping[str, Any]] = {
    "without critic": {"config.adversarial": 0.0},
    "without L1": {"config.l1": 0.0},
}
"""Changes of the recipe."""
MEASURES = {
    "mse": "MSE",
    "mse_recording": "of recording",
    "level_error": "level",
    "ripple_ratio": "ripple",
    "distance_db": "distance, dB",
    "geometry_score": "geometry",
}
"""Figures of a method, and their headings."""
REFERENCE = ("mse_flat", "floor_db", "ceiling_db", "inversion_db")
KNOWN = 128
"""Training windows per fabric that a texture-free model knows."""
SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Of the second fabric in a mix."""
WAYS = ("in_the_network", "of_the_spectra")
CYCLES = slice(5, 51)
"""Bins by whose mean level a mix is placed; see `fabric_evaluation.BAND_HZ`."""
RANGE_DB = 100.0
"""Of the colours, below the largest magnitude."""

NOTES = """\
Windows of parts of the photographs that were not trained on; mean ± sd over trainings, or draws. MSE: both after
Griffin-Lim from the same phases, as published; of recording: against the recording itself (flat line at its level
{mse_flat:.4f}). Level: absolute error of the mean coefficient. Ripple: standard deviation, as a share of the recorded.
Distance: log-spectral (recorded to recorded {floor_db:.2f}, other fabrics {ceiling_db:.2f}, phase recovery alone
{inversion_db:.2f}). Geometry: Geometry Score of the spectrograms as learned, 0 to 2."""


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    fabrics: str = "",
    ablations: str = ",".join(ABLATIONS),
    trainings: int = 3,
    on: str = "",
    processes: int | None = None,
) -> dict[str, Any]:
    """Return figures of FrictGAN, of its ablations and of texture-free models; draw Figure 3 and the mixes.

    Parameters
    ----------
    data : str
        Store of friction with photographs; default: simulated fabrics.
    fabrics : str
        Materials, separated by commas; default: the first five.
    ablations : str
        Names of `ABLATIONS`, separated by commas; may be empty.
    trainings : int
        Seeds of each model.
    """
    store = find_or_simulate(folder / "data", "fabrics", given=data, progress=progress)
    names = fabrics_of(store, fabrics)
    of, protocol = {"material": "|".join(names)}, dict[str, Any]()
    if any(info.labels.get(PART) == TEST for info in store.index):
        of, protocol = of | {PART: f"!{TEST}"}, {"config.protocol": "examples"}
    methods: dict[str, list[dict[str, Any]]] = {}
    runs = {
        (method, seed): Training(
            "frictgan",
            store.path,
            folder / "runs" / f"{method.replace(' ', '-')}-{seed}",
            {
                "recipe": "paper" if paper else "quick",
                "changes": {**protocol, **ABLATIONS.get(method, {}), "seed": seed},
                "where": of,
                "split": "all",
            },
        )
        for method in (PROPOSED, *listed(ablations, tuple(ABLATIONS), "ablations"))
        for seed in range(trainings)
    }
    for (method, seed), run in trained_runs(runs, on=on, processes=processes, progress=progress):
        for name in (method, *(MODELS if method == PROPOSED else ())):
            methods.setdefault(name, []).append(_cell(folder, run, name, seed))
    learner, _, tested = _loaded(folder / "runs" / "frictgan-0")
    windows = fabric_windows(learner, tested, "test")
    said = f"{store.name}, {learner.config.protocol}"
    save_figure(folder / "figure3.png", _figure3(learner, windows, said))
    save_figure(folder / "mixing.png", _mixing_figure(learner, windows, said))
    cells = methods[PROPOSED]
    result: dict[str, Any] = {
        "figures": ["figure3.png", "mixing.png"],
        **facts_of(store),
        "trainings": trainings,
        "protocol": f"published {PART}s" if protocol else learner.config.protocol,
        "published_mse": PUBLISHED,
        "published_mse_mean": sum(PUBLISHED) / len(PUBLISHED),
        "fabrics": {
            name: {key: spread([cell["fabrics"][name][key] for cell in cells]) for key in ("mse", "distance_db")}
            for name in names
        },
        "methods": {
            method: {
                key: spread([cell["mean"][key] for cell in trainings_of_method])
                for key in (*MEASURES, "mse_sum")
                if key in trainings_of_method[0]["mean"]
            }
            for method, trainings_of_method in methods.items()
        },
        "reference": {key: cells[0]["mean"][key] for key in REFERENCE},
        "missing": cells[0]["missing"],
        "mixes": [_mix(learner, windows, one, two) for one, two in zip(names, names[1:] + names[:1], strict=True)],
    }  # fmt: skip
    return result | {"text": _text(result)}


def fabrics_of(store: Store, text: str) -> list[str]:
    """Return the materials named, separated by commas; by default the store's first five."""
    known = sorted({str(info.material) for info in store.index if info.material})
    names = listed(text, known, "fabrics") or known[:FABRICS]
    if len(names) < 2:
        raise ParameterError.must("fabrics", f"be at least two of {', '.join(known)}", text)
    return names


def _loaded(run: Path) -> tuple[FrictGANLearner, Sequence[Example], Sequence[Example]]:
    """Return a model, its training recordings, and what it is tested on: the published test part, or other windows."""
    loaded = load_run(run)
    store, split = test_part(loaded.run)
    trained = part_examples(store, split, "train", loaded.as_trained, label=loaded.run.data["label"])
    materials = loaded.model.kind.materials
    published = [
        Segment(info.id)
        for info in store.index
        if info.labels.get(PART) == TEST and info.material in materials
    ]
    tested = Examples(store, published, loaded.as_trained) if published else trained
    return cast("FrictGANLearner", loaded.model), trained, tested


def _cell(folder: Path, run: Path, method: str, seed: int) -> dict[str, Any]:
    """Return the figures of one training, or of a texture-free model of its training windows, cached."""
    learner, examples, tested = _loaded(run)
    facts = {"run_id": load_run(run).run.data["run_id"], "method": method}

    def evaluated() -> dict[str, Any]:
        windows = fabric_windows(learner, tested, "test")
        recorded = {name: batch.friction for name, batch in windows.items()}
        if method in MODELS:
            trained = fabric_windows(learner, examples, "train", most=KNOWN)
            generated = {
                name: MODELS[method](trained[name].friction, len(real), seed)
                for name, real in recorded.items()
            }
        else:
            generated = {
                name: learner.spectrogram.decode(learner.spectra(batch, seed=seed)[0], seed=seed)
                for name, batch in windows.items()
            }
        recovered = None if method in MODELS else generated
        figures = compare_fabrics(learner.spectrogram, recorded, generated, recovered=recovered, seed=seed)
        mean, missing = summary(figures), {}
        points = [
            learner.as_learned(torch.cat(list(signals.values()))).flatten(1).double().numpy()
            for signals in (recorded, generated)
        ]
        try:
            mean["geometry_score"] = geometry_score(*points, seed=seed)
        except (MissingExtraError, ParameterError) as error:
            missing["geometry_score"] = str(error)
        return {
            "fabrics": {name: asdict(each) for name, each in figures.items()},
            "mean": mean,
            "missing": missing,
        }

    name = run.name if method not in MODELS else f"{method}-{seed}"
    return cached_result(folder / "cells" / f"{name}.json", facts, evaluated)


def _mix(
    learner: FrictGANLearner, windows: Mapping[str, FrictionBatch], first: str, second: str
) -> dict[str, Any]:
    """Return the mean coefficient and the place of the steps of a mix between the fabrics' recorded spectra, 0 to 1."""
    ends = [_shape(learner.spectrogram.encode(windows[name].friction)) for name in (first, second)]
    across = ends[1] - ends[0]
    photos = [windows[name].photo for name in (first, second)]
    count = min(map(len, photos))
    pure = [learner.mixed(photo[:count]) for photo in photos]
    networks = [learner.mixed(photos[0][:count], photos[1][:count], share) for share in SHARES]
    steps = dict(zip(WAYS, (networks, [pure[0].lerp(pure[1], share) for share in SHARES]), strict=True))
    return {
        "fabrics": [first, second],
        "shares": SHARES,
        "recorded_level": [float(windows[name].friction.mean()) for name in (first, second)],
        **{
            way: {
                "place": [float((_shape(spectra) - ends[0]) @ across / (across @ across)) for spectra in row],
                "level": [float(learner.spectrogram.decode(spectra).mean()) for spectra in row],
            }
            for way, row in steps.items()
        },
    }


def _shape(magnitude: Tensor) -> Tensor:
    """Return the mean logarithmic spectrum, shape (axis times bin,)."""
    return magnitude[:, :, CYCLES].clamp_min(1e-9).log().mean((0, 3)).flatten()


def _figure3(learner: FrictGANLearner, windows: Mapping[str, FrictionBatch], said: str) -> Figure:
    """Draw a row per fabric: photograph, generated and recorded amplitude spectrogram of its middle window."""
    rows = []
    for name, batch in windows.items():
        generated, real = learner.spectra(batch)
        middle = len(real) // 2
        rows.append((name, batch.photo[middle], (generated[middle, 0], real[middle, 0])))
    return _spectrograms(learner, rows, ("generated", "recorded"), f"Fig. 3, {said}")


def _mixing_figure(learner: FrictGANLearner, windows: Mapping[str, FrictionBatch], said: str) -> Figure:
    """Draw a row per pair of neighbouring fabrics: the first one's photograph, and the steps towards the second."""
    rows = []
    for (first_name, first), (second_name, second) in pairwise(windows.items()):
        steps = [learner.mixed(first.photo[:1], second.photo[:1], share)[0, 0] for share in SHARES]
        rows.append((f"{first_name}\nto {second_name}", first.photo[0], steps))
    return _spectrograms(learner, rows, [f"{share:.0%}" for share in SHARES], f"Mixed fabrics, {said}")


def _spectrograms(
    learner: FrictGANLearner,
    rows: Sequence[tuple[str, Tensor, Sequence[Tensor]]],
    titles: Sequence[str],
    title: str,
) -> Figure:
    """Draw photographs and magnitudes (frequency, displacement) in dB on one scale."""
    pixels = learner.windows.pixels
    unit, length = ("mm", pixels * learner.mm_per_pixel) if learner.mm_per_pixel else ("window", 1.0)
    extent = (0, length, 0, learner.windows.samples / length / 2)
    columns = 1 + len(titles)
    layout = ConstrainedLayoutEngine(w_pad=0.15)  # inch; names of fabrics at the edge would be cut
    figure = Figure(figsize=(1.3 + 1.7 * columns, 1 + 1.5 * len(rows)), layout=layout)
    grid = figure.subplots(len(rows), columns, squeeze=False)
    high = max(20 * float(x.max().log10()) for *_, pictures in rows for x in pictures)
    for axes, (name, photo, pictures) in zip(grid, rows, strict=True):
        axes[0].imshow(((photo.permute(1, 2, 0) + 1) / 2).numpy().squeeze(), cmap="gray")
        axes[0].set_ylabel(name, fontsize=8)
        axes[0].set(xticks=[], yticks=[])
        for panel, x in zip(axes[1:], pictures, strict=True):
            image = panel.imshow(
                20 * x.clamp_min(1e-9).log10().numpy(), cmap=COLOURS, vmin=high - RANGE_DB, vmax=high,
                origin="lower", aspect="auto", extent=extent,
            )  # fmt: skip
            panel.tick_params(labelsize=6)
    for panel, text in zip(grid[0], ("photograph", *titles), strict=True):
        panel.set_title(text, fontsize=8)
    for panel in grid[-1, 1:]:
        panel.set_xlabel(f"displacement, {unit}", fontsize=7)
    for row in grid:
        row[1].set_ylabel(f"cycles per {unit}", fontsize=7)
    figure.colorbar(image, ax=grid, label="dB", shrink=0.6)
    figure.suptitle(title, fontsize=9)
    return figure


def _text(result: Mapping[str, Any]) -> str:
    stated = ", ".join(f"{value:g}" for value in PUBLISHED)
    lines = [
        f"Figure 3 and Sec. 4 on {result['data']}, {result['trainings']} training(s), {result['protocol']}",
        f"published MSE: {stated}, mean {result['published_mse_mean']:.3f}, for five fabrics of HapTex that are not "
        "named, in overlapping windows",
        NOTES.format(**result["reference"]),
    ]
    fabrics = [
        (name, text_of(row["mse"]), text_of(row["distance_db"], digits=2))
        for name, row in result["fabrics"].items()
    ]
    lines.append(columns([("fabric", "MSE", "distance, dB"), *fabrics]))
    names = [name for name in MEASURES if name in result["methods"][PROPOSED]]
    methods = [
        (method, *(text_of(row[name], digits=3) for name in names))
        for method, row in result["methods"].items()
    ]
    lines.append(columns([("", *(MEASURES[name] for name in names)), *methods]))
    lines.append(
        "Mixes: place between the recorded spectra, 0 and 1, at shares " + ", ".join(f"{s:g}" for s in SHARES)
    )
    for mix in result["mixes"]:
        ways = (f"{way.replace('_', ' ')} " + " ".join(f"{x:.2f}" for x in mix[way]["place"]) for way in WAYS)
        lines.append(f"{' - '.join(mix['fabrics']):32}" + "; ".join(ways))
    return "\n".join([*lines, *(f"{name}: {why}" for name, why in result["missing"].items())])
