"""Tables of ratings, added to a store and exported from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace as replace_field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram.errors import DataError, Message, MissingExtraError, ParameterError, Remedy
from tactogram.parameters import Settings, checked

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from tactogram.datasets import Ratings, Scale
    from tactogram.datasets.ratings.questions import RatingColumns
    from tactogram.datasets.ratings.table import RatingsTable
    from tactogram.statistics.reliability import Level

SETTINGS = ("words", "ignore", "without", "answers", "item", "encoding")


@checked
def rate_store(
    path: Path | str,
    files: Sequence[Path | str],
    *,
    scale: str = "7-point",
    replace: bool = False,
    options: Settings | None = None,
) -> dict[str, Any]:
    """Add tables of ratings to a store, of one scale and the same words: all of them, or none.

    Parameters
    ----------
    path : Path or str
        A store.
    files : sequence of Path or str
        A row per score, or a column per word; or an export of PsychoPy, jsPsych, Qualtrics or Google Forms.
    scale : str
        7-point, evoked, LOW:HIGH or LOW:HIGH:STEP.
    replace : bool
        Replace existing ratings.
    options : dict, optional
        column.rater=HEADING (or item, word, score, order, session, a word), words=A,B, ignore=A,B (columns to read and
        to leave out), without=A,B (items to leave out), answers=A,B (texts, from the lowest to the highest score),
        item=plate{:0>2} (or one for each file, separated by commas), encoding=cp932.

    Returns
    -------
    dict
        ``path``, ``files``, ``replaced``, ``scale``, ``words``, ``items``, ``raters``, ``scores``, ``blank`` (cells
        without a score, by rater), ``unrated`` (items of the store without ratings), ``notes`` (what each file was read
        as, and what was left out), ``sha256`` (of the store).

    Raises
    ------
    ParameterError
        If a setting is unknown, or there is no file.
    DataError
        As `tactogram.datasets.ratings.table.read_table` and `tactogram.datasets.add_ratings`.
    """
    from tactogram.datasets import add_ratings, item_of, join_ratings, open_store
    from tactogram.datasets.ratings.ratings import scale_of
    from tactogram.datasets.ratings.table import read_table

    store = open_store(path)
    if not files:
        raise ParameterError("a table of ratings must be given, got none")
    if store.facts.ratings is not None and not replace:
        # Before tables are read, which may take a while.
        raise DataError(
            path,
            f"has ratings already ({store.facts.ratings.rows} scores)",
            remedy=Remedy("to put these in their place, give", "replace"),
        )
    chosen, columns = scale_of(scale), _columns(options or {}, len(files))
    known = {name for name in map(item_of, store.index) if name} | set(store.facts.photographs)
    tables = [
        read_table(Path(file), scale=chosen, columns=how, items=known)
        for file, how in zip(files, columns, strict=True)
    ]
    ratings = join_ratings([table.ratings for table in tables])
    rated = add_ratings(store, ratings, replace=replace)
    blank: dict[str, int] = {}
    for table in tables:
        for rater, count in table.blank.items():
            blank[rater] = blank.get(rater, 0) + count
    return {
        "path": str(path),
        "files": [str(file) for file in files],
        "replaced": store.facts.ratings is not None,
        "scale": asdict(ratings.scale),
        "words": list(ratings.words),
        "items": len(ratings.items),
        "raters": len(ratings.raters),
        "scores": len(ratings),
        "blank": blank,
        "unrated": sorted(known.difference(ratings.items)),
        "notes": _notes(files, tables),
        "sha256": rated.sha256,
    }


@checked
def export_ratings(path: Path | str, out: Path | str, *, wide: bool = False) -> dict[str, Any]:
    """Write the ratings of a store as a table that `rate_store` reads again.

    Parameters
    ----------
    path : Path or str
        A store.
    out : Path or str
        A table: .csv, .tsv or .parquet.
    wide : bool
        One row per rater and item and one column per word, instead of one row per score.

    Returns
    -------
    dict
        ``file``, ``scale``, ``scores``, ``items``, ``raters``, ``words``.

    Raises
    ------
    DataError
        If the store has no ratings.
    ParameterError
        If the file has another suffix.
    """
    from tactogram.datasets import open_store
    from tactogram.datasets.ratings.table import write_table

    ratings = open_store(path).ratings
    if ratings is None:
        raise DataError(f"{path} has no ratings; add a table of them (`data rate`)")
    write_table(Path(out), ratings, form="wide" if wide else "long")
    return {
        "file": str(out),
        "scale": asdict(ratings.scale),
        "scores": len(ratings),
        "items": len(ratings.items),
        "raters": len(ratings.raters),
        "words": list(ratings.words),
    }


def _notes(files: Sequence[Path | str], tables: Sequence[RatingsTable]) -> list[str]:
    """Return each note once, with the file that it is about, or the number of files."""
    about: dict[str, list[str]] = {}
    for file, table in zip(files, tables, strict=True):
        for note in table.notes:
            about.setdefault(note, []).append(str(file))
    return [
        Message(note, place=own[0] if len(own) == 1 else f"{len(own)} files") for note, own in about.items()
    ]


def _columns(settings: Mapping[str, Any], files: int) -> list[RatingColumns]:
    """Return how to read each of ``files`` tables."""
    from tactogram.datasets.ratings.questions import RatingColumns

    named = {key.removeprefix("column."): str(value) for key, value in settings.items() if "." in key}
    for key in settings:
        if not key.startswith("column.") and key not in SETTINGS:
            raise ParameterError(f"a setting must be column.NAME, {', '.join(SETTINGS)}, got {key!r}")
    items = _names(settings.get("item", "{}"))
    if len(items) not in (1, files):
        raise ParameterError.must("item", f"be given once, or once for each of {files} files", len(items))
    known = RatingColumns(
        named=named,
        words=_names(settings.get("words")),
        ignored=_names(settings.get("ignore")),
        without=_names(settings.get("without")),
        answers=_names(settings.get("answers")),
        encoding=str(settings.get("encoding", "")),
    )
    return [replace_field(known, item=item) for item in (items * files if len(items) == 1 else items)]


def _names(value: Any) -> tuple[str, ...]:
    parts = value if isinstance(value, list) else str(value or "").split(",")
    return tuple(str(part).strip() for part in parts if str(part).strip())


def ratings_info(ratings: Ratings) -> dict[str, Any]:
    """Return the content of ratings, the missing scores, and the agreement of raters.

    Keys of the result: ``scale``, ``words``, ``items``, ``raters``, ``scores``; ``missing``: ``blank`` (words without a
    score where the rater scored others of the item, in all), ``blank_by_rater``, and ``not_met`` (pairs of a rater and
    an item without any score); ``reliability``: ``level``, ``words``: of each ``mean``, ``sd``, ``alpha``,
    ``icc_single``, ``icc_average``, ``icc_items``, ``icc_raters`` (null where it cannot be computed);
    ``alpha_missing``: why no alpha is there, without the extra ``statistics``.
    """
    import numpy as np

    cube = ratings.cube
    rated = np.asarray(~np.isnan(cube))
    met = np.asarray(rated.any(axis=2))
    blank = (~rated & met[:, :, None]).sum((0, 2))
    level, missing = _level(ratings.scale), _alpha_missing()
    return {
        "scale": asdict(ratings.scale),
        "words": list(ratings.words),
        "items": len(ratings.items),
        "raters": len(ratings.raters),
        "scores": len(ratings),
        "missing": {
            "blank": int(blank.sum()),
            "blank_by_rater": {
                name: int(count) for name, count in zip(ratings.raters, blank, strict=True) if count
            },
            "not_met": int((~met).sum()),
        },
        "reliability": {
            "level": level,
            "words": {
                word: _word(cube[:, :, column], level, missing) for column, word in enumerate(ratings.words)
            },
            **({"alpha_missing": missing} if missing else {}),
        },
    }


def _word(scores: NDArray[np.float64], level: Level, missing: str) -> dict[str, float | int | None]:
    import numpy as np

    from tactogram.statistics.reliability import intraclass_correlation, krippendorff_alpha

    scored = scores[~np.isnan(scores)]
    known: dict[str, float | int | None] = {
        "mean": float(scored.mean()) if scored.size else None,
        "sd": float(scored.std(ddof=1)) if scored.size > 1 else None,
        "alpha": None if missing else krippendorff_alpha(scores, level=level),
    }
    agreement = intraclass_correlation(scores)
    return known | {
        "icc_single": None if agreement is None else agreement.single,
        "icc_average": None if agreement is None else agreement.average,
        "icc_items": None if agreement is None else agreement.items,
        "icc_raters": None if agreement is None else agreement.raters,
    }


def _alpha_missing() -> str:
    """Return what is to be installed for Krippendorff's alpha; empty if it can be computed."""
    from tactogram.statistics.reliability import alpha_library

    try:
        alpha_library()
    except MissingExtraError as error:
        return str(error)
    return ""


def _level(scale: Scale) -> Level:
    """Return the level of measurement: nominal for two answers, ordinal for points, interval for a continuum."""
    if scale.step is None:
        return "interval"
    return "nominal" if scale.high - scale.low <= scale.step else "ordinal"
