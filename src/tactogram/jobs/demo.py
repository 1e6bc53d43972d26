"""The main job on simulated surfaces: make them, name them, search them, give them a voice, and report."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets import Store, open_store
from tactogram.errors import RunError
from tactogram.evaluation.figures import confusion_figure, photos_figure, signal_figure, spectra_figure
from tactogram.evaluation.measures import log_spectral_distance
from tactogram.evaluation.report import Block, Picture, Section, Sound, Table, Text, write_report
from tactogram.jobs.classify import classify
from tactogram.jobs.evaluate import evaluate
from tactogram.jobs.generate import generate
from tactogram.jobs.progress import Progress, silent
from tactogram.jobs.search import search
from tactogram.jobs.simulate import simulate_to_store
from tactogram.jobs.training import LoadedRun, load_run, test_part, train
from tactogram.signal import Image, Signal
from tactogram.signal.io import write_signal

MARK = "made-by-tactogram-demo"
UNKNOWN = "cork-sheet"
"""The surface that is left out of training, to see whether "none of these" is said."""
PER_CLASS, STEPS = 16, 220
MIX = ("tile", "carpet")


def demo(out: Path | str = "runs/demo", *, seed: int = 0, progress: Progress = silent) -> dict[str, Any]:
    """Run the whole chain on simulated surfaces and write ``OUT/report.html``.

    A demo that is already there is replaced.

    Returns
    -------
    dict
        ``report``, ``recording_accuracy``, ``window_accuracy``, ``none_of_these``, ``voice`` (log-spectral
        distances in dB by material), ``recognised`` (share of generated signals that the classifier names
        rightly), ``simulated`` (always true).
    """
    folder = _fresh(Path(out))
    simulate_to_store("stroking9", folder / "data", seed=seed, per_class=PER_CLASS, progress=progress)
    store = open_store(folder / "data")
    shared: dict[str, Any] = {"where": {"material": f"!{UNKNOWN}"}, "progress": progress}
    changes = {"config.steps": STEPS, "seed": seed}
    train("stroke_cnn", folder / "data", changes=changes, out=folder / "stroke_cnn", **shared)
    train("ar_texture", folder / "data", changes={"seed": seed}, out=folder / "ar_texture", **shared)
    classifier, voice = load_run(folder / "stroke_cnn"), load_run(folder / "ar_texture")
    judged = evaluate(classifier, unknown=True, progress=progress)

    _, split = test_part(classifier.run)
    tests = {segment.id: store.info(segment.id) for segment in split.test}
    real: dict[str, list[Signal]] = {}
    for id, info in tests.items():
        stream = voice.recipe.prepare.stream_of(store.streams_of(id))
        real.setdefault(str(info.material), []).append(voice.prepare(store.signal(id, stream)))
    made = {
        name: list(
            generate(voice, {"material": name}, seconds=members[0].seconds, seed=seed, count=len(members))
        )
        for name, members in real.items()
    }
    distances = {
        name: (
            log_spectral_distance(made[name], members),
            log_spectral_distance(members[::2], members[1::2]) if len(members) > 1 else None,
            log_spectral_distance([s for n, part in real.items() if n != name for s in part], members),
        )
        for name, members in real.items()
    }
    named = [classify(classifier, s)["material"] == name for name, part in made.items() for s in part]
    recognised = float(np.mean(named))
    ladder = {
        weight: next(
            generate(voice, {"material": {MIX[0]: 1 - weight, MIX[1]: weight}}, seconds=3.0, seed=seed)
        )
        for weight in (0.0, 0.25, 0.5, 0.75, 1.0)
    }
    for weight, signal in ladder.items():
        share = f"{MIX[0]}-{1 - weight:g}-{MIX[1]}-{weight:g}"
        write_signal(folder / "sounds" / f"{share}.wav", signal, metadata={"simulated": True})

    report = write_report(
        folder / "report.html",
        title="Nine surfaces, stroked, named, searched and given a voice",
        summary=(
            f"{len(store)} simulated strokes over nine surfaces. A classifier names "
            f"{100 * judged['recording_accuracy']:.0f} % of the strokes that it was not trained on; a surface that it "
            f"has never met is refused {_percent(judged['none_of_these']['unknown_rejected'])} of the time; "
            f"autoregressive textures give each surface a voice of any length, and mixtures of two."
        ),
        simulated=True,
        sections=[
            _surfaces(store),
            _classified(classifier, judged),
            _searched(classifier, store, tests),
            _voices(real, made, distances, recognised),
            _mixed(ladder),
            Section("What made this", [Text(_how(seed))]),
        ],
    )
    return {
        "report": str(report),
        "recording_accuracy": judged["recording_accuracy"],
        "window_accuracy": judged["window_accuracy"],
        "none_of_these": judged["none_of_these"],
        "voice": {
            name: dict(zip(("model", "floor", "ceiling"), row, strict=True))
            for name, row in distances.items()
        },
        "recognised": recognised,
        "simulated": True,
    }


def _fresh(folder: Path) -> Path:
    """Return an empty folder in place of an earlier demo; refuse to touch anything else."""
    if folder.exists() and any(folder.iterdir()):
        if not (folder / MARK).exists():
            raise RunError(f"{folder}: holds something else than an earlier demo; give another --out")
        for inner in folder.iterdir():
            if inner.is_dir():
                shutil.rmtree(inner)
            elif inner.name != MARK:  # last to stay: what a kill leaves here is still a demo's
                inner.unlink()
    folder.mkdir(parents=True, exist_ok=True)
    (folder / MARK).touch()
    (folder / "sounds").mkdir()
    return folder


def _surfaces(store: Store) -> Section:
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
        Text(
            "Each surface is a height field from a formula; the photograph is rendered from it and the finger is "
            "dragged over it. The accelerometer on the finger feels gravity, friction and the texture."
        ),
        Picture(photos_figure(photos), "Rendered from the simulated height fields."),
        Picture(
            signal_figure(shown[name]),
            f"A stroke over {name}: three axes of acceleration and their spectrogram.",
        ),
    ]
    blocks += [Sound(signal, name) for name, signal in shown.items()]
    return Section("The surfaces", blocks)


def _classified(classifier: LoadedRun, judged: dict[str, Any]) -> Section:
    low, high = judged["recording_accuracy_95"]
    rows = [
        ("strokes", judged["recording_accuracy"], f"{low:.2f} – {high:.2f}", judged["recordings"]),
        (
            f"windows of {classifier.model.config.window} samples",
            judged["window_accuracy"],
            "–",
            judged["windows"],
        ),
        ("chance", judged["chance"], "–", "–"),
    ]
    counts = np.array(judged["confusion_windows"])
    return Section(
        "What is it?",
        [
            Text(
                "The network of Saga et al. (2020): six 1 x 5 convolutions that treat the three axes alike. It is "
                f"judged on strokes that it was not trained on; {UNKNOWN} was left out altogether."
            ),
            Table(("named rightly", "share", "95 % interval (Wilson)", "of"), rows),
            Picture(
                confusion_figure(counts, judged["materials"]),
                "Windows of each surface (row), and what they were taken for (column).",
            ),
        ],
    )


def _searched(classifier: LoadedRun, store: Store, tests: dict[str, Any]) -> Section:
    known = next(iter(tests))
    unknown = next(info.id for info in store.index if info.material == UNKNOWN)
    rows = []
    for id, name in ((known, tests[known].material), (unknown, UNKNOWN)):
        found = search(classifier, store.signal(id, "acceleration"), count=3)
        nearest = ", ".join(f"{n['material']} ({n['distance']:.3f})" for n in found["nearest"])
        rows.append((name, nearest, "none of these" if found["none_of_these"] else "known"))
    facts = _none_of_these_text(classifier)
    return Section(
        "What is it like?",
        [
            Text(
                "A search engine for surfaces: a new stroke is embedded by the network and its nearest neighbours are "
                "looked up. What is farther from everything than the calibrated threshold is none of these."
            ),
            Table(("touched", "nearest (cosine distance)", "verdict"), rows, facts),
        ],
    )


def _none_of_these_text(classifier: LoadedRun) -> str:
    """Return a sentence on how well "none of these" works in the run's last evaluation."""
    facts = classifier.run.read_json("evaluation.json")["none_of_these"]
    return (
        f"{_percent(facts['known_kept'])} of {facts['known']} strokes over known surfaces pass, "
        f"{_percent(facts['unknown_rejected'])} of {facts['unknown']} over {UNKNOWN} are refused; "
        f"area under the ROC curve {facts['auroc']:.2f}. The threshold was set on {facts['calibrated_on']} strokes."
    )


def _voices(
    real: dict[str, list[Signal]],
    made: dict[str, list[Signal]],
    distances: dict[str, tuple[float, float | None, float]],
    recognised: float,
) -> Section:
    blocks: list[Block] = [
        Text(
            "An autoregressive model per surface, fitted to the training strokes, synthesises as much as one likes. "
            f"The classifier names {_percent(recognised)} of the synthesised strokes rightly."
        ),
        Table(
            ("surface", "synthesised", "floor", "ceiling"),
            [(name, *row) for name, row in distances.items()],
            "Log-spectral distance in dB to strokes kept apart; lower is better. Floor: one half of those strokes "
            "against the other half. Ceiling: strokes over the other surfaces.",
        ),
    ]
    for name, members in real.items():
        blocks.append(Picture(spectra_figure({"stroked": members, "synthesised": made[name]}), name))
        blocks += [Sound(members[0], f"{name}, stroked"), Sound(made[name][0], f"{name}, synthesised")]
    return Section("A voice for each", blocks)


def _mixed(ladder: dict[float, Signal]) -> Section:
    blocks: list[Block] = [
        Text(
            f"From {MIX[0]} to {MIX[1]}, mixed through line spectral frequencies: every step is a stable texture."
        )
    ]
    for weight, signal in ladder.items():
        caption = f"{1 - weight:.0%} {MIX[0]}, {weight:.0%} {MIX[1]}"
        blocks += [Picture(signal_figure(signal, seconds=1.0), caption), Sound(signal, caption)]
    return Section("Mixtures", blocks)


def _how(seed: int) -> str:
    return (
        f"tactogram data simulate stroking9 --per-class {PER_CLASS} --seed {seed}; tactogram train stroke_cnn "
        f"--where 'material=!{UNKNOWN}' --set config.steps={STEPS}; tactogram train ar_texture; tactogram evaluate. "
        "Sounds are played at full scale: their level is lost in the loudspeaker, not in the files beside this report."
    )


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"
