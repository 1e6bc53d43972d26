"""Photographs that a run was trained on, described in its ``photographs.json``."""

from __future__ import annotations

from collections.abc import Iterable

from tactogram.errors import RunError
from tactogram.features.photo_descriptor import PhotoNovelty, distinct_photographs
from tactogram.model import Example
from tactogram.training.run import Run

FILE = "photographs.json"
MOST = 10
"""Photographs of a material that are described."""


def save_photographs(run: Run, examples: Iterable[Example]) -> None:
    """Describe the photographs of ``examples`` in ``run``; nothing is written if they are of too few materials."""
    members: dict[str, list[Example]] = {}
    for example in examples:
        members.setdefault(str(example.material), []).append(example)
    photographs = {name: distinct_photographs(each, MOST) for name, each in members.items()}
    if (novelty := PhotoNovelty.of(photographs)) is not None:
        run.write_json(FILE, novelty.facts())


def known_photographs(run: Run) -> PhotoNovelty | None:
    """Return the photographs of ``run``; None if it describes none.

    Raises
    ------
    RunError
        If the file is damaged.
    """
    if not (run.folder / FILE).is_file():
        return None
    try:
        return PhotoNovelty.from_facts(run.read_json(FILE, dict))
    except (KeyError, TypeError, ValueError) as error:
        raise RunError(
            f"{run.folder / FILE}: lacks or misspells {error}; it is damaged, delete it"
        ) from error
