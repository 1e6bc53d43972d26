"""VibViz: 120 designed vibrations with word ratings.

H. Seifi, K. Zhang, K. E. MacLean, "VibViz: Organizing, visualizing and navigating vibration libraries", IEEE World
Haptics 2015. CC BY 4.0.

Read from ``vibrationAnnotations*.csv`` and the WAV files it names (``ID.wav``, beside it or in a folder). These are
effects, not recordings of materials: ``material`` is empty, ``labels["effect"]`` and ``labels["item"]`` are the id.
Ratings are means in -3..3 over raters whose number the table does not state (its fractions fit 7 to 13). One rater,
``mean``, therefore stands for all of them, and reliability cannot be computed. The table's other columns (dimensions of
the tags) are left out. Rates and channels differ between files; samples are full scale 1. An effect without a file is
no error: public copies hold 100 of the 120. Checked on real files.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tactogram.datasets import ImportItem, Ratings, Recording, Scale, finite_number
from tactogram.errors import DataError
from tactogram.signal.io import read_signal
from tactogram.text_files import read_table

TITLE = "VibViz vibration library (designed effects with ratings)"
LICENCE = "CC-BY-4.0"
DESCRIPTION = (
    "vibrationAnnotations*.csv and ID.wav: vibration (full scale, 8-48 kHz, one or two channels) with mean ratings "
    "of energy, tempo, roughness, pleasantness and arousal in -3..3. Checked on real files."
)

RATINGS = ("energy", "tempo", "roughness", "pleasantness", "arousal")
SCALE = Scale("7-point bipolar, means", -3.0, 3.0)
"""Means of whole numbers lie anywhere between."""
TAGS = ("sensationTags", "emotionTags", "metaphors", "usageExamples")


def find(folder: Path) -> list[ImportItem]:
    """Return an item per WAV file, each of which needs a row of annotations."""
    table, rows = _annotations(folder)
    annotations = {row["id"]: row for row in rows}
    items = []
    for path in sorted(p for p in folder.rglob("*.wav") if not p.name.startswith(".")):
        name = path.relative_to(folder).as_posix()
        if path.stem not in annotations:
            raise DataError(name, f"has no row in {table.name}")
        items.append(ImportItem(name, (path,), annotations[path.stem]))
    return items


def read(item: ImportItem) -> list[Recording]:
    """Return one effect."""
    [path] = item.paths
    vibration = read_signal(path, unit="1")
    if len(vibration.axes) == 2:
        vibration = replace(vibration, axes=("left", "right"))
    scores = {name: finite_number(item.name, name, item.info[name]) for name in RATINGS}
    return [
        Recording(
            streams={"vibration": vibration},
            ratings=scores,
            labels={"effect": item.info["id"], "item": item.info["id"]}
            | {tag: item.info[tag] for tag in TAGS if item.info.get(tag)},
            source=item.name,
            history=("designed effect, not a recording of a material", "full scale 1"),
        )
    ]


def ratings(folder: Path) -> Ratings:
    """Return the mean ratings of all effects in the table, with or without a file."""
    table, rows = _annotations(folder)
    names = [(row["id"], word) for row in rows for word in RATINGS]
    scores = [
        finite_number(f"{table.name}: {row['id']}", word, row[word]) for row in rows for word in RATINGS
    ]
    return Ratings(
        ("mean",) * len(names),
        tuple(item for item, _ in names),
        tuple(word for _, word in names),
        np.array(scores),
        SCALE,
        words=RATINGS,
    )


def _annotations(folder: Path) -> tuple[Path, list[dict[str, str]]]:
    tables = sorted(folder.glob("vibrationAnnotations*.csv"))
    if len(tables) != 1:
        raise DataError(folder, f"must hold one vibrationAnnotations*.csv, got {len(tables)}")
    rows = [row for _, row in read_table(tables[0], needed=("id", *RATINGS))]
    if not rows:
        raise DataError(tables[0], "no rows below the heading")
    return tables[0], rows
