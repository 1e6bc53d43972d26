"""Published results beside ours, from each model's results.toml."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict

from tactogram import models
from tactogram.validation import validated


class PublishedResult(BaseModel):
    """A line of a results.toml: one figure, published and ours."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    what: str
    """Which figure, with its unit."""
    published: float | None = None
    """As printed in the publication; none where it gives no such figure."""
    where: str = ""
    """Table or section of the publication."""
    ours: float | None = None
    """As measured; none where it was not."""
    sd: float | None = None
    """Standard deviation of ours over seeds or folds."""
    data: str = ""
    """What ours was measured on; says "simulated" where it was."""
    split: str = ""
    seeds: int = 1
    recipe: str = ""
    note: str = ""
    """Why the two differ, above all in data."""


def table(model_folders: Sequence[Path] = ()) -> list[dict[str, Any]]:
    """Return one row per figure of every model: ``model`` and the fields of `PublishedResult`."""
    rows = []
    for name, facts in models.available(model_folders).items():
        file = facts.folder / "results.toml"
        if file.exists():
            lines = tomllib.loads(file.read_text(encoding="utf-8")).get("result", [])
            results = [validated(PublishedResult, line, where=str(file)) for line in lines]
            rows += [{"model": name, **result.model_dump()} for result in results]
    return rows
