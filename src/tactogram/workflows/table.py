"""Published results and ours, from each model's results.toml."""

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
    """Name of the figure, with its unit."""
    published: float | None = None
    """Value printed in the publication, if any."""
    where: str = ""
    """Table or section of the publication."""
    ours: float | None = None
    """Measured value, if any."""
    sd: float | None = None
    """Standard deviation of ours over seeds or folds."""
    data: str = ""
    """Data of our value, with "simulated" if it was."""
    split: str = ""
    seeds: int = 1
    recipe: str = ""
    note: str = ""
    """Reason for the difference, above all in data."""


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
