"""VibViz: 120 vibrations designed by hand, and what people said of them.

H. Seifi, K. Zhang, K. E. MacLean, "VibViz: Organizing, visualizing and navigating vibration libraries", IEEE World
Haptics 2015. CC BY 4.0.

Read from ``vibrationAnnotations*.csv`` and the WAV files it names (``ID.wav``, beside it or in a folder). These are
effects, not recordings of materials: ``material`` is empty, ``labels["effect"]`` is the id. Ratings are means in -3..3.
Rates and channels differ between files; samples are full scale 1. An effect without a file is no error: public
copies hold 100 of the 120. Checked on real files.
"""

from __future__ import annotations

import csv
from pathlib import Path

import soundfile

from tactogram.datasets.importer import Item
from tactogram.datasets.recording import Recording
from tactogram.errors import DataError
from tactogram.signal.io import read_signal

NAME = "vibviz"
TITLE = "VibViz vibration library (designed effects with ratings)"
LICENCE = "CC-BY-4.0"
DESCRIPTION = (
    "vibrationAnnotations*.csv and ID.wav: vibration (full scale, 8-48 kHz, one or two channels) with mean ratings "
    "of energy, tempo, roughness, pleasantness and arousal in -3..3. Checked on real files."
)

RATINGS = ("energy", "tempo", "roughness", "pleasantness", "arousal")
TAGS = ("sensationTags", "emotionTags", "metaphors", "usageExamples")


def find(folder: Path) -> list[Item]:
    """Return an item per WAV file; each needs its row of annotations."""
    tables = sorted(folder.glob("vibrationAnnotations*.csv"))
    if len(tables) != 1:
        raise DataError(f"{folder}: must hold one vibrationAnnotations*.csv, got {len(tables)}")
    with tables[0].open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader(file))
    if not rows or not {"id", *RATINGS} <= rows[0].keys():
        raise DataError(f"{tables[0]}: needs columns id, {', '.join(RATINGS)}")
    annotations = {row["id"]: row for row in rows}
    items = []
    for path in sorted(p for p in folder.rglob("*.wav") if not p.name.startswith(".")):
        name = path.relative_to(folder).as_posix()
        if path.stem not in annotations:
            raise DataError(f"{name}: has no row in {tables[0].name}")
        items.append(Item(name, (path,), annotations[path.stem]))
    return items


def read(item: Item) -> list[Recording]:
    """Return one effect."""
    [path] = item.paths
    try:
        channels = soundfile.info(path).channels
    except soundfile.LibsndfileError as error:
        raise DataError(f"{path}: not a readable WAV file: {error.error_string}") from error
    axes = ("left", "right") if channels == 2 else None
    ratings = {}
    for name in RATINGS:
        try:
            ratings[name] = float(item.info[name])
        except ValueError as error:
            raise DataError(f"{item.name}: {name} must be a number, got {item.info[name]!r}") from error
    return [
        Recording(
            streams={"vibration": read_signal(path, unit="1", axes=axes)},
            ratings=ratings,
            labels={"effect": item.info["id"]} | {tag: item.info[tag] for tag in TAGS if item.info.get(tag)},
            source=item.name,
            history=("designed effect, not a recording of a material", "full scale 1"),
        )
    ]
