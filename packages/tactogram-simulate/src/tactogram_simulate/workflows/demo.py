"""Demo on simulated surfaces: simulate, classify, search, generate, mix and report."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from tactogram.datasets import Store, open_store
from tactogram.errors import RunError
from tactogram.evaluation import (
    Block,
    ReportFigure,
    ReportSection,
    ReportSound,
    ReportTable,
    ReportText,
    confusion_figure,
    write_report,
)
from tactogram.parameters import checked
from tactogram.signal import Image, Signal, signal_figure
from tactogram.signal.io import check_writable, write_signal, write_text
from tactogram.workflows import ProgressCallback, silent
from tactogram_simulate.workflows.simulate import simulate_to_store

if TYPE_CHECKING:
    from tactogram.workflows import LoadedRun

MARK = "made-by-tactogram-demo"
UNKNOWN = "cork-sheet"
"""Surface left out of training, to test "none of these"."""
PER_CLASS, GENERATOR_STEPS = 16, 100
EVALUATION = {"steps": 200}
MIX = ("tile", "carpet")
NAMED = (
    "recording_accuracy",
    "recording_accuracy_95",
    "recordings",
    "window_accuracy",
    "windows",
    "none_of_these",
)
"""Figures of the classifier's evaluation in the result."""


@checked
def demo(
    out: Path | str = "runs/demo", *, seed: int = 0, progress: ProgressCallback = silent
) -> dict[str, Any]:
    """Simulate, classify, search, generate and evaluate surfaces, and write a report.

    Parameters
    ----------
    out : Path or str
        Folder for everything it makes, ``report.html`` and ``result.json`` among it; an earlier demo there is replaced.
    seed : int
        Seed of the simulation and of the trainings.

    Returns
    -------
    dict
        ``report``; ``recording_accuracy``, ``recording_accuracy_95``, ``recordings``, ``window_accuracy``, ``windows``,
        ``none_of_these`` of the classifier, ``measures`` and ``positions`` of the generator, as in `evaluate`;
        ``mixing`` (the measure of the ladder, in words), ``simulated`` (always true).

    Raises
    ------
    RunError
        If the folder holds something else.
    """
    from tactogram.workflows import evaluate, evaluate_run, load_run, mix_ladder, test_part, train

    folder = _fresh(Path(out))
    simulate_to_store("stroking9", folder / "data", seed=seed, per_class=PER_CLASS, progress=progress)
    store = open_store(folder / "data")

    def trained(model: str, **changes: int) -> LoadedRun:
        changes["seed"] = seed
        others = {"material": f"!{UNKNOWN}"}
        train(model, folder / "data", changes=changes, where=others, out=folder / model, progress=progress)
        return load_run(folder / model)

    classifier = trained("stroke_statistics")
    classified = evaluate(classifier, unknown=True, progress=progress)
    generator = trained("texture_gan", **{"config.steps": GENERATOR_STEPS})
    generated, generated_sections = evaluate_run(generator, evaluation=EVALUATION, progress=progress)
    mixes = mix_ladder(generator, *MIX, steps=5, signals=4, seconds=3.0, seed=seed, progress=progress)
    for step, signal in enumerate(mixes.shown):
        name = f"{step}-{mixes.caption(step).replace(', ', '-').replace(' ', '-')}.wav"
        write_signal(folder / "sounds" / name, signal, metadata={"simulated": True})

    _, split = test_part(classifier.run)
    tests = {segment.id: store.info(segment.id) for segment in split.test}
    report = write_report(
        folder / "report.html",
        title="Nine surfaces, stroked, classified, searched and generated",
        summary=(
            f"{len(store)} simulated strokes over nine surfaces. A classifier recognises "
            f"{100 * classified['recording_accuracy']:.0f} % of the strokes that it was not trained on, and rejects "
            f"{_percent(classified['none_of_these']['unknown_rejected'])} of those over an unknown surface. A small "
            f"generative adversarial network, trained for {GENERATOR_STEPS} steps, generates signals of any length for "
            "eight of the surfaces and mixes them; it is compared with other strokes, other surfaces and two baselines."
        ),
        simulated=True,
        sections=[
            _surfaces(store),
            _classified(classifier, classified),
            _searched(classifier, store, tests),
            *generated_sections,
            mixes.section(f"Mixtures: from {MIX[0]} to {MIX[1]}"),
            ReportSection("Commands", [ReportText(_how(seed))]),
        ],
    )
    result = {
        "report": str(report),
        **{name: classified[name] for name in NAMED},
        "measures": generated["measures"],
        "positions": generated["positions"],
        "mixing": mixes.in_words(),
        "simulated": True,
    }
    write_text(folder / "result.json", json.dumps(result, ensure_ascii=False))
    return result


def _fresh(folder: Path) -> Path:
    """Return an empty folder in place of an earlier demo; refuse to touch anything else."""
    check_writable(folder, folder=True)
    if folder.exists() and any(folder.iterdir()):
        if not (folder / MARK).exists():
            raise RunError(f"{folder}: is not an earlier demo; choose another folder")
        for inner in folder.iterdir():
            if inner.is_dir():
                shutil.rmtree(inner)
            elif inner.name != MARK:  # removed last, so that an interrupted demo remains one
                inner.unlink()
    folder.mkdir(parents=True, exist_ok=True)
    (folder / MARK).touch()
    (folder / "sounds").mkdir()
    return folder


def _surfaces(store: Store) -> ReportSection:
    photos: dict[str, Image] = {}
    shown: dict[str, Signal] = {}
    for info in store.index:
        name = str(info.material)
        image = store.image(info.id) if name not in photos else None
        if image is not None:
            photos[name] = image
            shown[name] = store.signal(info.id, "acceleration")
    name = MIX[1] if MIX[1] in shown else next(iter(shown))
    blocks: list[Block] = [
        ReportText(
            "Each surface is a computed height field; the photograph is rendered from it and the finger is "
            "dragged over it. The accelerometer on the finger measures gravity, friction and the texture."
        ),
        ReportFigure(photos_figure(photos), "Rendered from the simulated height fields."),
        ReportFigure(
            signal_figure(shown[name]),
            f"A stroke over {name}: three axes of acceleration and their spectrogram.",
        ),
    ]
    blocks += [ReportSound(signal, name) for name, signal in shown.items()]
    return ReportSection("The surfaces", blocks)


def photos_figure(photos: Mapping[str, Image]) -> Figure:
    """Draw photographs in a grid, each under its name."""
    columns = min(5, len(photos))
    rows = -(-len(photos) // columns)
    figure = Figure(figsize=(9, 1.95 * rows), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in grid:
        axes.axis("off")
    for axes, (name, image) in zip(grid, photos.items(), strict=False):
        axes.imshow(image.pixels)
        axes.set_title(name, fontsize=8)
    return figure


def _classified(classifier: LoadedRun, results: dict[str, Any]) -> ReportSection:
    low, high = results["recording_accuracy_95"]
    rows = [
        ("strokes", results["recording_accuracy"], f"{low:.2f} – {high:.2f}", results["recordings"]),
        (
            f"windows of {classifier.config.input_samples(classifier.kind.rate)} samples",
            results["window_accuracy"],
            "–",
            results["windows"],
        ),
        ("chance", results["chance"], "–", "–"),
    ]
    counts = np.array(results["confusion_windows"])
    return ReportSection(
        "Classification",
        [
            ReportText(
                "stroke_statistics: a linear discriminant on levels, fluctuations and distributions of each second. It "
                f"is tested on strokes that it was not trained on; {UNKNOWN} was left out."
            ),
            ReportTable(("classified correctly", "share", "95 % interval (Wilson)", "of"), rows),
            ReportFigure(
                confusion_figure(counts, results["materials"]),
                "Windows of each surface (row) and their classification (column).",
            ),
        ],
    )


def _searched(classifier: LoadedRun, store: Store, tests: dict[str, Any]) -> ReportSection:
    from tactogram.workflows import search

    known = next(iter(tests))
    unknown = next(info.id for info in store.index if info.material == UNKNOWN)
    rows = []
    for id, name in ((known, tests[known].material), (unknown, UNKNOWN)):
        result = search(classifier, store.signal(id, "acceleration"), count=3)
        nearest = ", ".join(f"{n['material']} ({n['distance']:.3f})" for n in result["nearest"])
        rows.append((name, nearest, "none of these" if result["none_of_these"] else "known"))
    facts = _none_of_these_text(classifier)
    return ReportSection(
        "What is it like?",
        [
            ReportText(
                "A search engine for surfaces: the classifier embeds a new stroke, and its nearest neighbours are "
                "listed. A stroke beyond the threshold of the nearest one's material is none of these."
            ),
            ReportTable(("touched", "nearest (distance)", "verdict"), rows, facts),
        ],
    )


def _none_of_these_text(classifier: LoadedRun) -> str:
    """Return a sentence on "none of these" in the run's last evaluation."""
    facts = classifier.run.read_json("evaluation.json", dict)["none_of_these"]
    return (
        f"{_percent(facts['known_kept'])} of {facts['known']} strokes over known surfaces pass, "
        f"{_percent(facts['unknown_rejected'])} of {facts['unknown']} over {UNKNOWN} are refused; "
        f"area under the ROC curve {facts['auroc']:.2f}. The thresholds were set on {facts['calibrated_on']} strokes."
    )


def _how(seed: int) -> str:
    others = f"--where 'material=!{UNKNOWN}'"
    return (
        f"tactogram data simulate stroking9 --per-class {PER_CLASS} --seed {seed} --out data; "
        f"tactogram train stroke_statistics --data data {others} --set seed={seed} "
        f"--out stroke_statistics; tactogram evaluate stroke_statistics --unknown; "
        f"tactogram train texture_gan --data data {others} --set config.steps={GENERATOR_STEPS} --set seed={seed} "
        f"--out texture_gan; tactogram evaluate texture_gan --evaluation steps={EVALUATION['steps']}; "
        f"tactogram mix texture_gan {' '.join(MIX)} --steps 5 --signals 4 --seconds 3 --seed {seed}. "
        "Sounds are played at full scale: their level is lost in the loudspeaker, not in the sound files."
    )


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"
