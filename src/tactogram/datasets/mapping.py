"""Mapping file: layouts of tables in TOML, proposed by a preview, edited by hand and used by imports."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Self

import tomli_w
from pydantic import Field, model_validator

from tactogram.errors import ParameterError
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.io.content import TableLayout
from tactogram.text_files import read_toml
from tactogram.validation import DescribedModel, validated


class TableMapping(DescribedModel):
    """Layouts of the tables in a folder."""

    layout: Annotated[tuple[TableLayout, ...], Field(min_length=1)]
    """Layouts, each of tables with other columns, or of another stream in the same tables."""

    @model_validator(mode="after")
    def _distinct(self) -> Self:
        for columns, alike in layouts_by_columns(self.layout).items():
            streams = [layout.stream for layout in alike]
            if len(alike) > 1 and (None in streams or len(set(streams)) < len(streams)):
                raise ValueError(
                    f"two layouts have the columns {', '.join(columns)}; keep one of them, or name their streams"
                )
        return self


def layouts_by_columns(layouts: Sequence[TableLayout]) -> dict[tuple[str, ...], list[TableLayout]]:
    """Return the layouts of the same tables together: one for each stream in them."""
    grouped: dict[tuple[str, ...], list[TableLayout]] = {}
    for layout in layouts:
        grouped.setdefault(layout.columns, []).append(layout)
    return grouped


def read_mapping(path: Path) -> TableMapping:
    """Return the mapping in a file; `DataError` or `ParameterError` in one line if it is not valid."""
    return validated(TableMapping, read_toml(path), where=str(path))


def write_mapping(path: Path, layouts: Sequence[TableLayout]) -> None:
    """Write a mapping to a new file; `ParameterError` if there are no layouts."""
    if not layouts:
        raise ParameterError(f"{path}: there is no table whose columns could be mapped; nothing was written")
    values = [
        {name: value for name, value in layout.model_dump(mode="json").items() if value not in (None, {})}
        for layout in layouts
    ]
    with atomic_write(path) as part:
        part.write_text(tomli_w.dumps({"layout": values}), encoding="utf-8")
