"""Report as one self-contained HTML file: text, tables, figures and sounds."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment
from matplotlib.figure import Figure

from tactogram.signal import Signal
from tactogram.signal.io.atomic import atomic_write, write_text
from tactogram.signal.listening import wav_bytes

SIMULATED = "Simulated data: made by formulas, not recorded from real surfaces."

EMPTY = "–"
NUMERIC = re.compile(rf"{EMPTY}|[±<\N{{MINUS SIGN}} ]*[\d,]*\.?\d+(e.\d+)?( %)?")
"""Cells of a column that is right-aligned."""
HYPHENS = re.compile(r"(?<![\w-])-(?=\.?\d)")
"""Hyphens in place of a minus sign."""


@dataclass(frozen=True)
class ReportText:
    """A paragraph."""

    text: str


@dataclass(frozen=True)
class ReportTable:
    """A table; columns of numbers are right-aligned. With a title in ``folded`` it is collapsed under that title."""

    header: Sequence[str]
    rows: Sequence[Sequence[object]]
    caption: str = ""
    folded: str = ""


@dataclass(frozen=True)
class ReportFigure:
    """A figure with a caption; one given by a function is drawn when the page is written, and not kept.

    Named in ``file`` it is also written beside the page, as PNG.
    """

    figure: Figure | Callable[[], Figure]
    caption: str = ""
    file: str = ""


@dataclass(frozen=True)
class ReportSound:
    """A signal to listen to: one axis, resampled to an audible rate and normalised (noted in the caption)."""

    signal: Signal
    caption: str = ""


Block = ReportText | ReportTable | ReportFigure | ReportSound


@dataclass(frozen=True)
class ReportSection:
    """A heading with its content."""

    title: str
    blocks: Sequence[Block]


def write_report(
    path: Path,
    *,
    title: str,
    summary: str,
    sections: Sequence[ReportSection],
    simulated: bool | str,
) -> Path:
    """Write the report to ``path``, atomically, and return the path.

    ``simulated`` is whether any of the data was simulated, or a text that names it, shown at the top of the page.
    """
    page = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(
        files("tactogram.evaluation").joinpath("report.html.jinja").read_text(encoding="utf-8")
    )
    text = page.render(
        title=title,
        summary=summary,
        simulated=SIMULATED if simulated is True else simulated,
        sections=[(s.title, [_render(block) for block in s.blocks]) for s in sections],
    )
    for block in (block for section in sections for block in section.blocks):
        if isinstance(block, ReportFigure) and block.file:
            save_figure(path.with_name(block.file), _drawn(block))
    write_text(path, text)
    return path


def save_figure(path: Path, figure: Figure) -> Path:
    """Write ``figure`` as PNG to ``path``, atomically, and return the path."""
    with atomic_write(path) as part:
        figure.savefig(part, format="png", dpi=150)
    return path


def _render(block: Block) -> dict[str, object]:
    if isinstance(block, ReportText):
        return {"kind": "text", "text": block.text}
    if isinstance(block, ReportTable):
        rows = [[_cell(value) for value in row] for row in block.rows]
        numeric = [all(NUMERIC.fullmatch(text) for text in column) for column in zip(*rows, strict=True)]
        columns = list(zip(block.header, numeric or [False] * len(block.header), strict=True))
        facts = {"columns": columns, "rows": rows, "caption": block.caption, "folded": block.folded}
        return {"kind": "table", **facts}
    if isinstance(block, ReportFigure):
        picture = io.BytesIO()
        _drawn(block).savefig(picture, format="png", dpi=130)
        data = base64.b64encode(picture.getvalue()).decode()
        return {"kind": "picture", "data": data, "caption": block.caption}
    return {
        "kind": "sound",
        "data": base64.b64encode(wav_bytes(block.signal)).decode(),
        "caption": block.caption,
    }


def _drawn(block: ReportFigure) -> Figure:
    return block.figure if isinstance(block.figure, Figure) else block.figure()


def _cell(value: object) -> str:
    if value is None:
        return EMPTY
    text = f"{value:.3g}" if isinstance(value, float) else str(value)
    return HYPHENS.sub("\N{MINUS SIGN}", text)
