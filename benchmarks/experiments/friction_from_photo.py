"""Friction of fabrics from photographs by texture_flow, in the protocol of `frictgan_figure3`.

It is trained on the regions that FrictGAN trains on, and measured on the same windows, whose photographs it is given.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import torch
from torch import Tensor

from tactogram import models
from tactogram.datasets import Store, create_store, open_store
from tactogram.datasets.recording import Recording
from tactogram.features.registered_pairs import FrictionBatch, PhotoWindows
from tactogram.model import Example, SignalKind
from tactogram.models.frictgan.fabric_evaluation import compare_fabrics, fabric_windows, summary
from tactogram.models.frictgan.learner import FrictGANLearner
from tactogram.models.texture_flow.signal_learner import SignalFlowLearner
from tactogram.recipe import Recipe
from tactogram.signal import Image
from tactogram.signal.resampling import resample
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.loaded_run import LoadedRun, load_run
from tactogram_benchmark.experiments.artifacts import find_or_simulate, spread, trained_run
from tactogram_benchmark.experiments.frictgan_figure3 import MEASURES, REFERENCE, fabrics_of
from tactogram_benchmark.experiments.picture_cells import text_of

METHOD = "texture_flow"


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    fabrics: str = "",
    trainings: int = 3,
) -> dict[str, Any]:
    """Return figures of texture_flow, and the share of windows whose fabric it names by the photograph.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``paper`` changes nothing.
    data, fabrics, trainings
        As of `tactogram_benchmark.experiments.frictgan_figure3`.
    """
    store = find_or_simulate(folder / "data", "fabrics", given=data, progress=progress)
    names = fabrics_of(store, fabrics)
    frictgan = untrained_frictgan(store, names)
    recordings = [store.read(info.id) for info in store.index if info.material in names]
    examples = [
        Example(
            r.id,
            r.streams["friction"],
            r.material,
            {"image": r.image} if r.image else {},
            _photographs(store, r),
        )
        for r in recordings
    ]
    frictgan.mm_per_pixel = frictgan.pairs(examples).mm_per_pixel
    windows = fabric_windows(frictgan, examples, "test")
    known = _regions(folder / "regions", store, recordings, examples, frictgan.windows)
    cells, shares = [], []
    for seed in range(trainings):
        place = trained_run(
            METHOD, known, folder / "runs" / str(seed),
            recipe="friction", changes={"seed": seed}, split="all", progress=progress,
        )  # fmt: skip
        loaded = load_run(place)
        made = {name: _made(loaded, frictgan, batch, seed) for name, batch in windows.items()}
        recorded = {name: batch.friction for name, batch in windows.items()}
        figures = compare_fabrics(frictgan.spectrogram, recorded, made, seed=seed)
        cells.append((figures, summary(figures)))
        shares.append(_named(loaded, frictgan, windows))
    keys = [key for key in MEASURES if key in cells[0][1]]
    result: dict[str, Any] = {
        "simulated": store.simulated,
        "data": store.name,
        "data_sha256": store.sha256,
        "trainings": trainings,
        "protocol": frictgan.config.protocol,
        "fabrics": {
            name: {key: spread([asdict(figures[name])[key] for figures, _ in cells]) for key in keys}
            for name in windows
        },
        "mean": {key: spread([mean[key] for _, mean in cells]) for key in keys},
        "reference": {key: cells[0][1][key] for key in REFERENCE},
        "named": spread(shares),
    }
    rows = [("", *(MEASURES[key] for key in keys))]
    rows += [
        (name, *(text_of(row[key], digits=3) for key in keys))
        for name, row in (*result["fabrics"].items(), ("mean", result["mean"]))
    ]
    lines = [f"{row[0]:16}" + "".join(f"{cell:>20}" for cell in row[1:]) for row in rows]
    said = ", ".join(f"{key} {value:.4g}" for key, value in result["reference"].items())
    return result | {
        "text": "\n".join([*lines, said, f"named by the photograph: {text_of(result['named'], digits=2)}"])
    }


def untrained_frictgan(store: Store, names: Sequence[str]) -> FrictGANLearner:
    """Return an untrained model, which knows the windows of the protocol."""
    info = models.find("frictgan")
    config = info.config(Recipe.load(info.folder / "recipes" / "quick.toml").config)
    stream = store.streams["friction"]
    rates = {store.rate(item.id, "friction") for item in store.index}
    kind = SignalKind(rates.pop(), stream.unit, stream.axes, tuple(names), store.simulated, "displacement")
    return cast("FrictGANLearner", info.build(config, kind, seed=0))


def _photographs(store: Store, recording: Recording) -> Sequence[Image]:
    keys = store.photographs_of(str(recording.material))
    return () if recording.image else [store.photograph(key) for key in keys]


def _regions(
    path: Path,
    store: Store,
    recordings: Sequence[Recording],
    examples: Sequence[Example],
    windows: PhotoWindows,
) -> Store:
    """Return a store of the training regions alone: of the photograph, and of the friction beneath it."""
    if (path / "dataset.json").is_file():
        return open_store(path)
    share = windows.shares[0]

    def cut(recording: Recording, example: Example) -> Recording:
        image = recording.image or example.photographs[0]
        signal = recording.streams["friction"]
        width, length = image.pixels.shape[1], len(signal)
        if image.mm_per_pixel is not None and signal.domain == "displacement":
            width = min(width, int(length / signal.rate / image.mm_per_pixel))
            length = round(width * image.mm_per_pixel * signal.rate)
        return replace(
            recording,
            streams={"friction": signal.cut(0, round(share * length))},
            image=image.cut(right=round(share * width)),
            id="",
        )

    return create_store(
        path,
        (cut(*pair) for pair in zip(recordings, examples, strict=True)),
        name=f"{store.name}, training regions",
        licence=store.licence,
        simulated=store.simulated,
    )


def _made(loaded: LoadedRun, frictgan: FrictGANLearner, batch: FrictionBatch, seed: int) -> Tensor:
    """Return windows made from the photographs of recorded ones, (window, axis, samples)."""
    count = batch.friction.shape[-1]
    rows = []
    for number, image in enumerate(_images(frictgan, batch)):
        rate = frictgan.rate_of(image)
        signal = cast("SignalFlowLearner", loaded.model).generate({"image": image}, seed=1000 * seed + number)
        rows.append(resample(signal, rate).samples[:, :count])
    return torch.from_numpy(np.stack(rows))


def _images(frictgan: FrictGANLearner, batch: FrictionBatch) -> list[Image]:
    pixels = batch.photo.add(1).mul(127.5).round().byte().permute(0, 2, 3, 1).numpy()
    return [Image(each, frictgan.mm_per_pixel) for each in pixels]


def _named(loaded: LoadedRun, frictgan: FrictGANLearner, windows: dict[str, FrictionBatch]) -> float:
    found = [
        cast("SignalFlowLearner", loaded.model).classify_photograph(image)[0] == name
        for name, batch in windows.items()
        for image in _images(frictgan, batch)
    ]
    return float(np.mean(found))
