"""A texture of each model on each display, with what was scaled, clipped or cannot be reached.

Not a published table: a check that what any model makes comes out of any display, at a stated level, and of what each
display takes from it. All models are trained briefly on simulated data, so the textures are no measure of the models.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from textwrap import shorten
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tactogram.datasets import Store
from tactogram.errors import DataError, ParameterError, UnitError
from tactogram.evaluation.report import save_figure
from tactogram.models import ModelInfo, available, find
from tactogram.rendering.displays.catalogue import open_display, shipped
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.fit import Drive, fit
from tactogram.rendering.figures import drive_figure
from tactogram.rendering.level import parse_level
from tactogram.signal import Image, Signal
from tactogram.signal.io import write_signal
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train
from tactogram_benchmark.experiments.artifacts import find_or_simulate

DATA: Mapping[str, tuple[str, dict[str, Any]]] = {
    "material": ("stroking9", {"photographs": 9, "per_class": 8}),
    "image": ("stroking9", {"photographs": 9, "per_class": 8}),
    "words": ("ultrasonic", {}),
}
"""The simulated set that a model learns from, by what it needs."""
OWN_DATA: Mapping[str, tuple[str, dict[str, Any]]] = {"frictgan": ("fabrics", {})}
"""Models that learn from another one."""
TRAINED: Mapping[str, str] = {"ar_texture": "quick", "replay": "quick", "nearest_photo": "quick"}
"""Recipes of models that are trained in no time; all others are ``tiny`` unless asked otherwise."""
LEVELS = ("sensation", "physical", "peak=0.8")
"""The first that has a meaning for signal and display is taken, and said."""
FRICTION = ("frictgan",)
"""Models whose signals of unit 1 are coefficients of friction; those of others are in parts of a display's full scale,
and have no physical level on another."""
SECONDS = 1.0
SPEED_MM_S = 50.0
"""Of the finger, where a model or a signal needs one."""


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    models: str = "",
    shown: str = "",
    recipe: str = "",
    runs: str = "",
) -> dict[str, Any]:
    """Return the report of every model's texture on every display; drives and figures are in ``folder``.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``paper`` trains by the recipe ``quick`` instead of ``tiny``.
    models : str
        Which, joined by commas; by default all that generate signals.
    shown : str
        Displays, by name or TOML file, joined by commas; by default all that come with the package.
    recipe : str
        Of all models.
    runs : str
        Trained runs to take instead, as ``MODEL=FOLDER`` joined by commas.
    """
    given = dict(part.split("=", 1) for part in runs.split(",") if "=" in part)
    textures, simulated = {}, []
    for name in _chosen(models):
        own = recipe or ("quick" if paper else TRAINED.get(name, "tiny"))
        textures[name], learned = _texture(folder, find(name), given.get(name), own, progress)
        simulated.append(learned)
    wanted = [open_display(name.strip()) for name in shown.split(",") if name.strip()]
    displays = {d.name: d for d in wanted or map(open_display, shipped())}
    drives: dict[str, dict[str, Drive]] = {}
    for model, texture in textures.items():
        drives[model] = {name: _rendered(model, texture, display) for name, display in displays.items()}
        for name, drive in drives[model].items():
            place = folder / "drives" / model / f"{name}.wav"
            write_signal(place, drive.signal, metadata={"display": name, "simulated": all(simulated)})
            write_text(place.with_suffix(".report.json"), json.dumps(drive.report.as_json(), indent=1) + "\n")
    figures = {"overview": str(save_figure(folder / "overview.png", overview_figure(drives, displays)))}
    for name, display in displays.items():
        model = _fitting(drives, name)
        asked = drives[model][name].report.level["asked"]
        title = f"{display.title}\n{model}, learned from simulated data; level {asked}"
        drawn = drive_figure(drives[model][name], display, title=title)
        figures[name] = str(save_figure(folder / f"{name}.png", drawn))
    return {
        "simulated": all(simulated),
        "figures": figures,
        "reports": {m: {d: drive.report.as_json() for d, drive in row.items()} for m, row in drives.items()},
        "text": _text(drives, displays),
    }


def overview_figure(drives: Mapping[str, Mapping[str, Drive]], displays: Mapping[str, Display]) -> Figure:
    """Return the drive of every model (rows) on every display (columns), each within the display's limits."""
    figure = Figure(figsize=(1.5 * len(displays) + 1, 0.8 * len(drives) + 1), layout="constrained")
    grid: Any = figure.subplots(len(drives), len(displays), squeeze=False)
    for cells, (model, row) in zip(grid, drives.items(), strict=True):
        for axes, (name, display) in zip(cells, displays.items(), strict=True):
            drive = row[name]
            for channel in drive.signal.samples:
                _draw(axes, channel)
            axes.set_ylim(1.08 * display.floor - 0.04 * display.limit, 1.08 * display.limit)
            axes.set_xticks([])
            axes.set_yticks([])
            axes.set_title(drive.report.level["asked"], fontsize=6, pad=1.5)
        cells[0].set_ylabel(model, fontsize=7, rotation=0, ha="right", va="center")
    for axes, name in zip(grid[-1], displays, strict=True):
        axes.set_xlabel(name, fontsize=7)
    figure.suptitle(
        "Drives within each display's limits, and the level asked for; models trained briefly on simulated data",
        fontsize=9,
    )
    return figure


def _draw(axes: Axes, channel: NDArray[np.float32]) -> None:
    per_column = -(-len(channel) // 400)
    if per_column < 50:
        steps = "steps-post" if len(channel) < 1000 else "default"
        axes.plot(np.linspace(0, 1, len(channel)), channel, linewidth=0.4, drawstyle=steps)
        return
    cut = channel[: len(channel) // per_column * per_column].reshape(-1, per_column)
    axes.fill_between(np.linspace(0, 1, len(cut)), cut.min(axis=1), cut.max(axis=1), linewidth=0.4, alpha=0.8)


def _chosen(models: str) -> list[str]:
    known = [
        name for name, facts in available().items() if facts.task == "generation" and facts.gives == "signal"
    ]
    chosen = [name.strip() for name in models.split(",") if name.strip()] or known
    for name in chosen:
        if name not in known:
            raise ParameterError(f"models must be of {', '.join(known)}, got {name!r}")
    return chosen


def _texture(
    folder: Path, facts: ModelInfo, run_folder: str | None, recipe: str, progress: ProgressCallback
) -> tuple[Signal, bool]:
    """Return a texture that a model made, and whether it learned from simulated data."""
    store = _store(folder, facts, progress)
    out = Path(run_folder) if run_folder else folder / "runs" / f"{facts.name}-{recipe}"
    if run_folder is None:
        resume = (out / "recipe.toml").exists()
        train(facts.name, store.path, recipe=recipe, out=out, resume=resume, progress=progress)
    loaded = load_run(out)
    condition = _condition(store, facts)
    over_time = "speed_mm_s" in facts.takes and facts.needs == ("image",)
    if over_time:
        condition["speed_mm_s"] = SPEED_MM_S
    (made,) = generate(loaded, condition, seconds=SECONDS)
    if isinstance(made, Image):
        raise ParameterError(f"{facts.name} gives an image")
    return made, bool(loaded.simulated)


def _store(folder: Path, facts: ModelInfo, progress: ProgressCallback) -> Store:
    name, options = OWN_DATA.get(facts.name, DATA[facts.needs[0]])
    return find_or_simulate(folder / name, name, progress=progress, **options)


def _condition(store: Store, facts: ModelInfo) -> dict[str, Any]:
    """Return a condition of the kind that a model needs, from what it learned from."""
    match facts.needs[0]:
        case "material":
            return {"material": {min(info.material for info in store.index if info.material): 1.0}}
        case "image":
            return {"image": store.photograph(store.photograph_keys()[0])}
        case _:
            ratings = store.ratings
            if ratings is None:
                raise DataError(f"{store.path}: no ratings to go by")
            return {
                "words": dict.fromkeys(ratings.words, float(np.mean([ratings.scale.low, ratings.scale.high])))
            }


def _rendered(model: str, texture: Signal, display: Display) -> Drive:
    """Return the drive of a texture at the first of `LEVELS` that has a meaning."""
    speed = SPEED_MM_S if texture.domain == "displacement" else None
    for level in LEVELS if texture.unit != "1" or model in FRICTION else LEVELS[-1:]:
        try:
            return fit(texture, display, level=parse_level(level), speed_mm_s=speed)
        except UnitError:
            continue
    raise ParameterError(f"{display.name}: no level of {', '.join(LEVELS)} has a meaning for {texture.unit}")


def _fitting(drives: Mapping[str, Mapping[str, Drive]], display: str) -> str:
    """Return the model whose texture a display renders at a level that keeps the signal's own, if there is one."""
    for level in LEVELS:
        for model, row in drives.items():
            if row[display].report.level["asked"] == level:
                return model
    raise ParameterError("there is nothing to show")


def _text(drives: Mapping[str, Mapping[str, Drive]], displays: Mapping[str, Display]) -> str:
    lines = [
        "Models trained briefly on simulated data. Largest drive in % of the display's limit; dB by which the limit",
        "made it weaker than asked; how much cannot be reached. All of it: drives/MODEL/DISPLAY.report.json.",
        f"{'model':20}{'display':22}{'level':12}{'drive %':>8}{'weaker dB':>11}  cannot be reached",
    ]
    for model, row in drives.items():
        for name, drive in row.items():
            report = drive.report
            share = 100 * report.drive["peak"] / displays[name].limit
            limiting = report.facts.get("limiting")
            weaker = f"{20 * np.log10(1 / limiting):.1f}" if limiting else "-"
            lost = shorten("; ".join(report.unreachable) or "-", 90, placeholder=" …")
            lines.append(f"{model:20}{name:22}{report.level['asked']:12}{share:8.1f}{weaker:>11}  {lost}")
    return "\n".join(lines)
