"""Page of all results: one self-contained HTML file that sorts, filters, draws intervals and plays sounds."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from markupsafe import escape

from tactogram.signal import Signal, audible, strongest_axis
from tactogram.signal.io import read_signal
from tactogram_benchmark.ranking import RankedModel
from tactogram_benchmark.result import REAL_FOLDER, RECORDED
from tactogram_benchmark.table import (
    NOTES,
    OTHERS,
    TaskTable,
    about_text,
    data_text,
    heading,
    mean_of,
    mean_text,
    span_text,
    training_text,
    value_text,
)
from tactogram_benchmark.task import BenchmarkTask
from tactogram_benchmark.task_kind import kind_of

LISTENING_PEAK = 0.7
"""Of the loudest of the sounds of one item, all of which are scaled alike: their levels compare."""
HEARD_S = 2.0
PICTURE = (112, 56)
"""Pixels of a spectrogram."""
RANGE_DB = 60.0


def html(tables: Sequence[TaskTable], folders: Sequence[Path]) -> str:
    """Return the page; sounds and pictures are those kept beside the results in ``folders``."""
    loader = jinja2.Environment(
        loader=jinja2.PackageLoader("tactogram_benchmark", "."),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    template = loader.get_template("page.html.jinja")
    return template.render(tasks=[_task(table, folders) for table in tables], notes=_marked(NOTES))


def _marked(text: str) -> str:
    """Return Markdown of strong words and code as HTML."""
    strong = re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", str(escape(text)), flags=re.DOTALL)
    return re.sub("`(.+?)`", r"<code>\1</code>", strong)


def _task(table: TaskTable, folders: Sequence[Path]) -> dict[str, Any]:
    task, kind = table.task, kind_of(table.task.kind)
    first = table.ranked[0].results[0]
    others = list(first.figures)[1 : 1 + OTHERS]
    return {
        "name": task.name,
        "title": task.title,
        "data": data_text(task),
        "simulated": task.data.simulated,
        "given": kind.given_in(task),
        "asked": kind.asked,
        "figure": first.main.title,
        "unit": first.main.unit,
        "better": first.main.better,
        "span": span_text(first.main),
        "best": [
            (entry.model, about_text(entry), value_text(entry), ", ".join(entry.not_told_apart))
            for entry in (table.ranked[0], table.best_new)
            if entry
        ],
        "columns": [(heading(key), first.figures[key].title) for key in others],
        "rows": [_row(entry, table, others) for entry in table.ranked],
        "failed": [(r.model, r.failed) for r in table.failed],
        "shown": _shown(task, [entry.model for entry in table.ranked], folders),
    }


def _row(entry: RankedModel, table: TaskTable, others: Sequence[str]) -> dict[str, Any]:
    return {
        "rank": entry.rank_text,
        "place": entry.best_rank,
        "model": entry.model,
        "about": about_text(entry),
        "text": value_text(entry),
        "value": entry.value,
        "bar": _bar(entry, table),
        "cells": [(mean_text(entry, key), mean_of(entry, key)) for key in others],
        "seeds": len(entry.results),
        "training": training_text(entry),
        "tied": ", ".join(entry.not_told_apart),
        "notes": " ".join(entry.results[0].notes),
    }


def _bar(entry: RankedModel, table: TaskTable) -> dict[str, float]:
    """Return value, interval, floor and ceiling in pixels of one scale for the whole task, -1 where unknown."""
    main = table.ranked[0].results[0].main
    ends = [main.floor, main.ceiling]
    for other in table.ranked:
        ends += [other.value, other.low, other.high]
    known = [end for end in ends if end is not None]
    low, span = min(known), max(max(known) - min(known), 1e-9)

    def place(value: float | None) -> float:
        return -1.0 if value is None else round(6 + 188 * (value - low) / span, 1)

    return {
        "value": place(entry.value),
        "low": place(entry.low),
        "high": place(entry.high),
        "floor": place(main.floor),
        "ceiling": place(main.ceiling),
    }


def _shown(task: BenchmarkTask, models: Sequence[str], folders: Sequence[Path]) -> list[dict[str, Any]]:
    """Return the items with sounds or pictures: what was recorded, and each model's."""
    files: dict[str, dict[str, Path]] = {}
    for folder in folders:
        for root in (folder / task.name / "shown", folder / REAL_FOLDER / task.name / "shown"):
            for model in (RECORDED, *models):
                for file in sorted((root / model).glob("*.*")):
                    if file.suffix in (".flac", ".png"):
                        files.setdefault(file.stem, {})[model] = file
    items = []
    for item, by_model in files.items():
        signals = {model: read_signal(file) for model, file in by_model.items() if file.suffix == ".flac"}
        sounds = {model: audible(_beginning(signal)) for model, signal in signals.items()}
        peak = max((float(np.abs(sound.samples).max()) for sound in sounds.values()), default=0.0)
        entries = [
            {"model": model, "sound": _flac(sounds[model], peak), "picture": _spectrogram(signals[model])}
            if model in sounds
            else {"model": model, "sound": "", "picture": base64.b64encode(file.read_bytes()).decode()}
            for model, file in by_model.items()
        ]
        items.append({"item": item, "entries": entries})
    return items


def _beginning(signal: Signal) -> Signal:
    return signal.cut(0, round(HEARD_S * signal.rate))


def _flac(sound: Signal, peak: float) -> str:
    """Return a sound as FLAC in base64, scaled by the peak that all sounds of an item share."""
    import soundfile

    samples = sound.samples[0] * (LISTENING_PEAK / max(peak, 1e-12))
    file = io.BytesIO()
    soundfile.write(file, np.clip(samples, -1, 1), round(sound.rate), format="FLAC", subtype="PCM_16")
    return base64.b64encode(file.getvalue()).decode()


def _spectrogram(signal: Signal) -> str:
    """Return a small spectrogram as PNG in base64: time to the right, frequency up, 60 dB."""
    from matplotlib import colormaps
    from PIL import Image as Picture
    from scipy.signal import spectrogram

    heard = strongest_axis(_beginning(signal)).samples[0]
    window = max(16, min(256, len(heard) // 8))
    power = spectrogram(heard, signal.rate, nperseg=window, noverlap=window // 2)[2]
    level = 10 * np.log10(np.maximum(power, 1e-20))
    scaled = np.clip(1 + (level - level.max()) / RANGE_DB, 0, 1)[::-1]
    pixels = (255 * colormaps["magma"](scaled)[..., :3]).astype(np.uint8)
    file = io.BytesIO()
    Picture.fromarray(pixels).resize(PICTURE).save(file, "PNG", optimize=True)
    return base64.b64encode(file.getvalue()).decode()
