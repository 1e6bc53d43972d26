"""Columns of a table of ratings: their headings, and what their cells mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from tactogram.datasets.ratings.words import WORDS, word_of
from tactogram.errors import ParameterError

NAMED = ("rater", "item", "word", "score", "order", "session")
MISSING = ("", "na", "n/a", "nan", "none", "null", "-", "–")
"""Cells that hold no score, in any case."""


@dataclass(frozen=True)
class RatingColumns:
    """Columns of a table of ratings.

    Parameters
    ----------
    named : mapping from str to str
        The table's heading of ``rater``, ``item``, ``word``, ``score``, ``order``, ``session`` or of a word.
    words : tuple of str
        Words of the study; by default the ten words. In the wide form each must have a column.
    ignored : tuple of str
        Headings of other columns, such as an age; ``*`` are all that are not known.
    without : tuple of str
        Items whose rows are left out, as those of a practice.
    item : str
        Format of an item's name in the store: ``plate{:0>2}`` makes ``7`` ``plate07``.
    answers : tuple of str
        Texts of the answers of a questionnaire, from the lowest to the highest score.
    encoding : str
        Of a CSV or TSV file; detected if empty.
    """

    named: Mapping[str, str] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    ignored: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    item: str = "{}"
    answers: tuple[str, ...] = ()
    encoding: str = ""

    def __post_init__(self) -> None:
        for name in self.named:
            if name not in (*NAMED, *self.vocabulary):
                raise ParameterError(
                    f"a column must be one of {', '.join((*NAMED, *self.vocabulary))}, got {name!r}; "
                    "words=A,B names other words"
                )
        try:
            "".encode(self.encoding or "utf-8")  # refuses codecs that are not for text
        except LookupError:
            raise ParameterError(f"encoding must be one that Python knows, got {self.encoding!r}") from None
        try:
            self.item.format("1")
        except (IndexError, KeyError, ValueError):
            raise ParameterError(
                f"item must have a place for the cell, such as plate{{:0>2}}, got {self.item!r}"
            ) from None

    @property
    def vocabulary(self) -> tuple[str, ...]:
        """Words of the study, or the ten words."""
        return self.words or WORDS

    def word(self, text: str) -> str | None:
        """Return the word that a heading or a cell means, or None."""
        text = text.strip()
        word = text if text in self.vocabulary else word_of(text)
        return word if word in self.vocabulary else None

    def ignores(self, heading: str) -> bool:
        """Return whether a heading is ignored; one with commas may be given in parts."""
        return heading in self.ignored or {part.strip() for part in heading.split(",")} <= set(self.ignored)
