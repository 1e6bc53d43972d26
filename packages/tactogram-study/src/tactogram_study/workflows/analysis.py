"""Studies analysed as JSON, text, figures and a report."""

from __future__ import annotations

import io
import json
import math
import re
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactogram.datasets import SEVEN_POINT, read_cells, read_table, scale_of
from tactogram.errors import DataError, ParameterError
from tactogram.parameters import checked
from tactogram.signal.io import atomic_write, check_writable, write_text
from tactogram_study.analysis.findings import AnalysisSection, Finding
from tactogram_study.answers import Answers, Targets
from tactogram_study.designs import designs, find_design
from tactogram_study.planned import AnalysisPlan
from tactogram_study.practice import MARK
from tactogram_study.study_analysis import StudyAnalysis, analyse
from tactogram_study.study_file import Study
from tactogram_study.workflows.answers import open_answers, study_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tactogram.datasets import Scale

JSON_FILE, TEXT_FILE, REPORT_FILE = "analysis.json", "analysis.txt", "report.html"


@checked
def analyse_study(
    source: Path | str,
    out: Path | str,
    *,
    design: str | None = None,
    margins: Mapping[str, float] | None = None,
    alpha: float | None = None,
    practice: bool = False,
    targets: Path | str | None = None,
    targets_scale: str | Scale = "7-point",
    reference: str | None = None,
    columns: Mapping[str, str] | None = None,
    constants: Mapping[str, str] | None = None,
    encoding: str = "",
    draws: int = 2000,
    seed: int = 0,
    figures: bool = True,
    language: str = "",
) -> dict[str, Any]:
    """Analyse answers, as published and with repeated measures, with intervals and verdicts.

    All is computed before anything is written. Obsolete figures of an earlier analysis in the folder are removed.
    ``analysis.json`` and ``analysis.txt`` keep the keys of items and conditions in every language. Figures use the
    names where a font with their letters is installed; else English names, or keys.

    Parameters
    ----------
    source : Path or str
        A table of answers (.csv, .tsv, .parquet), or a session's folder.
    out : Path or str
        Folder for report.html, analysis.json, analysis.txt and the figures.
    design : str, optional
        Only rows of this design; for a foreign table the design of all its rows: see `study designs`.
    margins : mapping from str to float, optional
        Margin of equivalence that replaces the study file's, e.g. which=0.1; reported as set afterwards.
    alpha : float, optional
        Significance level that replaces the study file's; likewise reported.
    practice : bool
        Analyse the practice trials instead of those that count.
    targets : Path or str, optional
        Target scores: ratings, or answers to a study of words.
    targets_scale : str
        Scale of the target scores.
    reference : str, optional
        Condition whose mean scores are the targets instead.
    columns : mapping from str to str, optional
        Foreign table: heading of one of our columns, e.g. participant=subject.
    constants : mapping from str to str, optional
        Foreign table: value of a column in every row, e.g. question=which.
    encoding : str, optional
        Encoding of a foreign table (default: detected).
    draws : int
        Draws of the bootstraps.
    seed : int
        Seed of the bootstraps.
    figures : bool
        Write figures as PNG, also into the report.
    language : str, optional
        Language of item and condition names in the report; by default English, or the study's first.

    Returns
    -------
    dict
        The content of ``analysis.json``, with ``out``, ``files`` and ``text``.

    Raises
    ------
    TactogramError
        In one line: what is wrong with the table, the margins or the targets, or why ``out`` cannot be written to.
    """
    from tactogram_study.workflows.report import StudyData, write_study_report

    folder = Path(out)
    check_writable(folder, folder=True)
    answers = _opened(Path(source), design, columns, constants, encoding)
    if practice:
        answers = practice_of(answers)
    study = study_of(Path(source))
    scale = scale_of(targets_scale) if isinstance(targets_scale, str) else targets_scale
    plan = AnalysisPlan.of(
        None if study is None else study.planned,
        margins,
        alpha=alpha,
        targets=None if targets is None else targets_of(Path(targets), scale=scale),
        reference=reference,
        seed=seed,
        draws=draws,
    )
    names = {} if study is None else study.names_in(_report_language(study, language))
    analysis = analyse(answers, plan=plan)
    drawn = _figures(analysis, answers, names, study) if figures else [{} for _ in analysis.sections]
    pictures = {f"{name}.png": _png(figure) for own in drawn for name, figure in own.items()}
    result = analysis.as_dict() | {
        "source": str(source),
        "notes": [*answers.notes],
        "targets": None if targets is None else str(targets),
        "files": [JSON_FILE, TEXT_FILE, REPORT_FILE, *pictures],
    }
    folder.mkdir(parents=True, exist_ok=True)
    _remove_earlier(folder, kept=pictures)
    write_text(folder / JSON_FILE, json.dumps(result, ensure_ascii=False, indent=1, allow_nan=False) + "\n")
    write_text(folder / TEXT_FILE, analysis.text())
    for name, picture in pictures.items():
        with atomic_write(folder / name) as part:
            part.write_bytes(picture)
    data = StudyData.of(Path(source), answers, study)
    named = replace(analysis, sections=tuple(named_section(section, names) for section in analysis.sections))
    write_study_report(folder / REPORT_FILE, named, data, drawn, practice=practice)
    return result | {"out": str(out), "text": analysis.text()}


def _remove_earlier(folder: Path, *, kept: Collection[str]) -> None:
    """Remove the figures that an earlier analysis in the folder lists and the next does not write."""
    with suppress(OSError, ValueError, KeyError, TypeError):
        for name in json.loads((folder / JSON_FILE).read_text(encoding="utf-8"))["files"]:
            if re.fullmatch(r"[\w-]+\.png", name) and name not in kept:
                (folder / name).unlink(missing_ok=True)


def _report_language(study: Study, language: str) -> str:
    """Return the language of the names in a report; raise `ParameterError` if the study lacks it."""
    if not language:
        return "en" if "en" in study.languages else study.languages[0]
    if language not in study.languages:
        raise ParameterError.one_of("language", study.languages, language[:20])
    return language


def _png(figure: Figure) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=130)
    return buffer.getvalue()


def practice_of(answers: Answers) -> Answers:
    """Return the practice trials as trials of their design; `DataError` if there are none."""
    kept = answers.where(design=MARK)
    if not len(kept):
        raise DataError("answers hold no practice trials")
    return Answers(tuple(replace(row, design=row.more.get(MARK, "")) for row in kept))


def _figures(
    analysis: StudyAnalysis, answers: Answers, names: Mapping[str, str], study: Study | None
) -> list[dict[str, Figure]]:
    """Return each section's figures by name, labelled with names in an available font, English names, or keys."""
    from tactogram_study.analysis.figures import DEFAULT_FONT, font_with, letter

    drawable, font = {}, DEFAULT_FONT
    for offered in (names, {} if study is None else study.names_in("en")):
        if (candidate := font_with(offered.values())) is not None:
            drawable, font = dict(offered), candidate
            break
    drawn = []
    for section in analysis.sections:
        own = named_answers(answers.where(design=section.design), drawable)
        drawn.append(find_design(section.design).figures(named_section(section, drawable), own))
    if font != DEFAULT_FONT:
        for figure in (drawing for figures in drawn for drawing in figures.values()):
            letter(figure, font)
    return drawn


def targets_of(path: Path, *, scale: Scale = SEVEN_POINT) -> Targets:
    """Return the mean score of each item and word, of a table of ratings on ``scale``, or of answers.

    Of a session folder or a table of answers, those whose design ``gives_targets`` are used.

    Raises `DataError` if the table is broken, or has an item without a score for one of its words.
    """
    if not path.exists():
        raise DataError(path, "no such table of target ratings")
    if path.is_dir() or {"participant", "question"} <= set(read_cells(path).headings):
        return _mean_answers(path)
    ratings = read_table(path, scale=scale).ratings
    for indices in np.argwhere(np.isnan(ratings.means)):
        item, word = ratings.items[indices[0]], ratings.words[indices[1]]
        raise DataError(path, f"item {item!r} must have a score for {word!r}, got none")
    return {
        item: dict(zip(ratings.words, map(float, row), strict=True))
        for item, row in zip(ratings.items, ratings.means, strict=True)
    }


def _mean_answers(path: Path) -> Targets:
    kinds = [kind for kind, design in designs().items() if design.gives_targets]
    scores = open_answers(path).where(lambda row: math.isfinite(row.value), design=kinds)
    if not len(scores):
        raise DataError(path, f"must have answers of the design {' or '.join(kinds)} to be targets, got none")
    conditions = scores.unique("condition")
    if len(conditions) > 1:
        raise DataError(path, f"targets must be of one condition, got {', '.join(conditions)}")
    return {
        item: {word: float(of_word.numbers().mean()) for word, of_word in of_item.by("question").items()}
        for item, of_item in scores.by("stimulus").items()
    }


def _opened(
    source: Path,
    design: str | None,
    columns: Mapping[str, str] | None,
    constants: Mapping[str, str] | None,
    encoding: str,
) -> Answers:
    constant = dict(constants or {})
    mapped = (
        columns
        or constants
        or (source.is_file() and "design" not in read_cells(source, encoding=encoding).headings)
    )
    if design is not None and mapped and "design" not in (columns or {}):
        constant.setdefault("design", design)
    answers = open_answers(source, columns=columns, constants=constant, encoding=encoding)
    if design is None:
        return answers
    kept = replace(answers.where(design=design), notes=answers.notes)
    if not len(kept):
        raise DataError(
            source, f"has no rows of design {design!r}, but {', '.join(answers.unique('design'))}"
        )
    return kept


NAMED_COLUMNS = ("texture", "item", "stimulus", "image", "condition")
"""Columns of any design's tables that hold keys."""
TABLE_PARTS = (" n", " mean", " se")
"""Suffixes of a condition in the heading of a column."""


def named_section(section: AnalysisSection, names: Mapping[str, str]) -> AnalysisSection:
    """Return a section whose findings and tables have the names of items and conditions, by key."""
    if not names:
        return section
    # Longest first, and whole words only: tile is not part of tile-2.
    keys = "|".join(re.escape(key) for key in sorted(names, key=len, reverse=True))
    pattern = re.compile(rf"(?<![\w-])(?:{keys})(?![\w-])")

    def named(text: str) -> str:
        return pattern.sub(lambda match: names[match.group()], text)

    def finding(original: Finding) -> Finding:
        return replace(original, of=named(original.of), measure=named(original.measure))

    key_columns = {*NAMED_COLUMNS, *find_design(section.design).key_columns}

    def cell(column: str, value: Any) -> Any:
        return named(value) if column in key_columns and isinstance(value, str) else value

    def heading(column: str) -> str:
        return named(column) if column.endswith(TABLE_PARTS) else column

    tables = {
        title: [{heading(column): cell(column, value) for column, value in row.items()} for row in rows]
        for title, rows in section.tables.items()
    }
    return replace(
        section,
        title=named(section.title) if ":" in section.title else section.title,
        findings=tuple(finding(original) for original in section.findings),
        tables=tables,
    )


def named_answers(answers: Answers, names: Mapping[str, str]) -> Answers:
    """Return answers with named conditions, for figures that draw single answers of a named section."""
    if not names:
        return answers
    return Answers(tuple(replace(row, condition=names.get(row.condition, row.condition)) for row in answers))
