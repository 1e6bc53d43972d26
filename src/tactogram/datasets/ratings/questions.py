"""Questions of an export: the word and item of each column of answers, as rows of ratings; columns of ratings."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import pairwise

from tactogram.datasets.cells import Cells
from tactogram.datasets.ratings.questionnaires import Export
from tactogram.datasets.ratings.ratings import Scale
from tactogram.datasets.ratings.words import WORDS, names_in, word_of, words_in
from tactogram.errors import DataError, ParameterError

_CODE = r"[ _-]*(id|code|number|no|nr|pid|key)?"
_RATERS = (
    rf"(rater|participant|subject|person|respondent|prolific|worker|proband|vp){_CODE}",
    r".*\b(participant|subject)\b.*\b(id|code|number)\b.*|(参加者|被験者|teilnehmer|versuchsperson).*",
    r"responseid",
    r".*e-?mail.*|.*メールアドレス.*|user ?name|p?id|code",
)
_ITEM = rf"(item|stim(ulus)?|material|texture|surface|sample|object|image|sound)(name|file)?{_CODE}"
_MEDIA = re.compile(
    r"(?:.*[/\\])?([^/\\]+)\.(?:wav|mp3|ogg|flac|mp4|webm|png|jpe?g|gif|bmp|svg|tiff?|webp)", re.I
)
_SOURCE = re.compile(r"""<.*\bsrc\s*=\s*["']?([^"'> ]+)""")
_NUMBER = re.compile(r"\s*([-+]?\d+)(?:\s*[-–=:.)(]\s*\D*|\s+\D*)|\D*[\s(]([-+]?\d+)\)?\s*")
"""A number at the beginning or the end of a text: ``7 - very rough``, ``very rough (7)``."""
NAMED = ("rater", "item", "word", "score", "order", "session")
MISSING = ("", "na", "n/a", "nan", "none", "null", "-", "–")
"""Cells that hold no score, in any case."""


class Questions:
    """Columns of one export: ``place`` by role, ``asked`` the word and item of those of answers.

    ``items`` are names that questions and cells may mean. A `DataError` says what to set where a column can be read in
    two ways or in none.
    """

    def __init__(
        self, export: Export, columns: RatingColumns, scale: Scale, items: Collection[str] = ()
    ) -> None:
        self.export, self.columns, self.scale = export, columns, scale
        self.where = f"{export.path}: {export.program}"
        self.items = {item.casefold(): item for item in items}
        self.labels = [_plain(label) for label in export.labels]
        self.place: dict[str, int] = {}
        for name, heading in columns.named.items():
            if heading not in export.headings:
                raise DataError(export.path, f"has no column {heading!r}, but {', '.join(export.headings)}")
            self.place[name] = export.headings.index(heading)
        for name in ("rater", "session", *(("word", "score") if export.by_trial else ())):
            self._take(name, name)
        for form in _RATERS:
            self._take("rater", form)
        word_columns = {n: word for word, n in self.place.items() if word in columns.vocabulary}
        free = [n for n in export.asked if n in self._free()]
        asked = {n: self._meaning(n) for n in free} | {
            n: (word, self._meaning(n)[1]) for n, word in word_columns.items()
        }
        if export.by_trial and not any(word for word, _ in asked.values()):
            self._choose("word", lambda cells: all(map(columns.word, cells)))
        if "word" in self.place:
            asked = dict.fromkeys([self.place["score"]] if "score" in self.place else free, ("word", ""))
        if export.by_trial or not any(word and item for word, item in asked.values()):
            self._take("item", "item")
            rated = [n for n in asked if self._is_rated(n)]
            known = self._choose(
                "item", lambda cells: {*map(self._item, cells)} <= {*self.items.values()}, rated
            )
            if not known and not any(item for _, item in asked.values()):
                named = [n for n, name in enumerate(export.headings) if not re.fullmatch(_ITEM, name, re.I)]
                self._choose("item", bool, named)
        itemised = "item" in self.place
        self.asked = {n: (word, item) for n, (word, item) in asked.items() if word and (itemised or item)}
        self._check(asked)

    def _check(self, asked: Collection[int]) -> None:
        """Raise a `DataError` if columns can be read in two ways or in none."""
        headings = ", ".join(filter(None, self.export.headings))
        unclear = [n for n in asked if n not in self.asked and self._is_rated(n)]
        twice = [n for n, each in self.asked.items() if [*self.asked.values()].count(each) > 1]
        if (unclear and "*" not in self.columns.ignored) or twice or not self.asked:
            names = ((self.export.headings[n], self.labels[n]) for n in [*twice, *unclear][:6])
            listed = ", ".join(f"{name!r}" + f" ({label})" * (label != name) for name, label in names)
            raise DataError(
                self.where,
                f"of which item and word are the numbers in {listed or 'it'}? column.item=HEADING is the "
                "column of items, if the questions do not name them; words=A,B are other words, column.WORD=HEADING is "
                f"the column of one; ignore=HEADING (or *) leaves a column out; has {headings}",
            )
        several = "item" in self.place and not self.export.by_trial
        if "trial_index" in self.export.headings:
            index = self.export.headings.index("trial_index")
            trials = [int(row[index]) for _, row in self.export.rows if row[index].isdecimal()]
            several = any(after <= before for before, after in pairwise(trials))
        if several and "rater" not in self.place:
            raise DataError(
                self.where, f"which column names the people? column.rater=HEADING says it; has {headings}"
            )

    def _free(self) -> list[int]:
        taken = set(self.place.values())
        named = enumerate(self.export.headings)
        return [n for n, name in named if name and n not in taken and not self.columns.ignores(name)]

    def _take(self, name: str, form: str) -> None:
        """Give a role to the first column with such a heading or question, and with a cell."""
        for n in self._free() if name not in self.place else ():
            texts = (self.export.headings[n], self.labels[n])
            if any(re.fullmatch(form, text.strip(" ?:."), re.I) for text in texts) and self._cells(n):
                self.place[name] = n
                return

    def _choose(self, name: str, fits: Callable[[list[str]], bool], others: Collection[int] = ()) -> bool:
        """Give a role to the column whose cells fit, unless several differ; return whether one does."""
        cells = {n: self._cells(n) for n in self._free() if n not in others}
        fitting = {n: own for n, own in cells.items() if own and fits(own)}
        if name not in self.place and len({tuple(map(self._item, own)) for own in fitting.values()}) == 1:
            self.place[name] = min(fitting)
        return bool(fitting)

    def _cells(self, n: int) -> list[str]:
        """Return the cells of a column that hold something, in rows with an item and an answer."""
        item, asked = self.place.get("item"), self.export.asked
        rows = [row for _, row in self.export.rows if any(row[i].strip() for i in asked)]
        rows = [row for row in rows if item is None or self._item(row[item])]
        return [cell for row in rows if (cell := row[n].strip()).casefold() not in MISSING]

    def _meaning(self, n: int) -> tuple[str, str]:
        """Return the word and the item that a question names, "" where it names none or several."""
        label, words = self.labels[n], self.columns.words
        parts = [part.strip() for part in re.split(r"\s[-–—:|/]\s|[\[\]():]", label) if part.strip(" ?.")]
        own = {word for word in self.items.values() if len(word) > 2}
        items = {*map(self._item, parts)} & {*self.items.values()} or names_in(label, own)
        rest = [part for part in parts if not words_in(part, self.columns.vocabulary)]
        if not items and len(parts) == 2 and len(rest) == 1 and not self.export.by_trial:
            items = {self._item(rest[0])}
        item = items.pop() if len(items) == 1 else ""
        named = words_in(label, self.columns.vocabulary) or {*(words if item and len(words) == 1 else ())}
        return named.pop() if len(named) == 1 else "", item

    def _item(self, cell: str) -> str:
        """Return the item that a cell means: its text without markup, or the stem of a file's name."""
        text = source[1] if (source := _SOURCE.search(cell)) else _plain(cell)
        if text.casefold() not in self.items and (file := _MEDIA.fullmatch(text)):
            text = file[1]
        name = "" if text.casefold() in MISSING else self.columns.item.format(text)
        return self.items.get(name.casefold(), name)

    def _is_rated(self, n: int) -> bool:
        """Return whether all answers are numbers, and half of them on the scale."""
        numbers = [self._number(cell) for cell in self._cells(n)]
        on_scale = [self.scale.holds(float(number)) for number in numbers if number]
        return len(on_scale) == len(numbers) > 0 and 2 * sum(on_scale) >= len(numbers)

    def _number(self, text: str) -> str:
        """Return the number in an answer, "" if there is none."""
        low, high, answers = self.scale.low, self.scale.high, self.columns.answers
        if text in answers:
            if len(answers) - 1 != round((high - low) / (self.scale.step or high - low)):
                raise DataError(
                    self.where, f"answers must be one per point of {self.scale}, got {len(answers)}"
                )
            return f"{low + answers.index(text) * (high - low) / (len(answers) - 1):g}"
        with suppress(ValueError):
            float(text)
            return text
        match = _NUMBER.fullmatch(text)
        return match[1] or match[2] if match else ""

    def read(self) -> tuple[Cells, RatingColumns]:
        """Return the ratings in the long form, and how to read them."""
        export, place, stem = self.export, self.place, self.export.path.stem
        used = {*place.values(), *self.asked}
        unused = [name for n, name in enumerate(export.headings) if name and n not in used and self._cells(n)]
        empty = [number for number, row in export.rows if not any(row[n].strip() for n in self.asked)]
        export.leave_out("without an answer", empty)
        if "item" in place:
            lost = [number for number, row in export.rows if not self._item(row[place["item"]])]
            export.leave_out("with an answer, but without an item", lost)
        rows: list[tuple[int, list[str]]] = []
        texts: dict[str, None] = {}
        codes: dict[str, str] = {}
        for number, row in export.rows:
            cells = {name: row[n].strip() for name, n in place.items()}
            rater = cells.get("rater", stem if export.by_trial else f"{stem}-{number}")
            if "@" in rater:
                rater = codes.setdefault(rater, f"{stem}-{len(codes) + 1}")
            for n, (word, own) in self.asked.items():
                answer = "" if row[n].strip().casefold() in MISSING else row[n].strip()
                score = self._number(answer)
                if answer and not score:
                    texts[answer] = None
                item = self._item(cells["item"]) if "item" in cells else own
                named = self.columns.word(cells["word"]) or cells["word"] if "word" in cells else word
                long = [rater, item, named, score, cells.get("order", ""), cells.get("session", "")]
                rows.append((number, long))
        if texts:
            raise DataError(
                self.where,
                f"answers are texts: {', '.join(map(repr, texts))}; answers=A,B,… names them "
                "from the lowest score to the highest, ignore=HEADING leaves a question out",
            )
        by = {name: repr(export.headings[n]) for name, n in place.items()}
        people = by.get("rater", "each file" if export.by_trial else "each row")
        notes = [
            f"read as an export of {export.program}: rater of {people}, item of {by.get('item', 'the questions')}",
            *export.notes,
            *([f"columns left out: {', '.join(unused)}"] if unused else []),
            *(["e-mail addresses replaced by codes"] if codes else []),
        ]
        names = dict.fromkeys(row[2] for _, row in rows)
        words = self.columns.words or (
            *(w for w in WORDS if w in names),
            *(w for w in names if w not in WORDS),
        )
        return Cells([*NAMED], rows, notes), replace(
            self.columns, named={}, ignored=(), words=words, item="{}"
        )


def _plain(text: str) -> str:
    """Return a text without markup and line breaks."""
    return " ".join(html.unescape(re.sub("<[^>]*>", " ", text)).split())


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
            raise ParameterError.must("encoding", "be one that Python knows", self.encoding) from None
        try:
            self.item.format("1")
        except (IndexError, KeyError, ValueError):
            raise ParameterError.must(
                "item", "have a place for the cell, such as plate{:0>2}", self.item
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
