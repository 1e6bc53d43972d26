"""Draft of a study: the tables of its file, changed by place, and its check."""

from __future__ import annotations

import copy
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomli_w

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.signal.io import atomic_write, write_text
from tactogram.text_files import parse_toml, read_text
from tactogram.validation import Fault, place_of
from tactogram_studio.study_draft.fields import Place
from tactogram_studio.workspace.folder import Workspace
from tactogram_study.study_file import NAME, Study, shipped_studies
from tactogram_study.workflows.stimuli import stimulus_place
from tactogram_study.workflows.studies import check_loaded

STUDIES = "studies"
"""Folder of the workspace for copies of shipped studies."""
NO_TABLE = "each line must be NAME = VALUE as in the study's file, texts in quotes"


@dataclass
class StudyDraft:
    """Values of a study's file as edited; ``base`` is the hash of the file that they began with."""

    path: Path
    values: dict[str, Any]
    base: str

    @classmethod
    def open(cls, path: Path, stored: Mapping[str, Any] | None = None) -> StudyDraft:
        """Return the draft of a file, or the one ``stored`` by `to_store`.

        Raises `TactogramError` if the file is no valid study: the editor edits valid ones only.
        """
        Study.load(path)
        text = read_text(path)
        if stored:
            return cls(path, json.loads(stored["values"]), stored["base"])
        return cls(path, _normalised(parse_toml(text, path), path), _hash(text))

    def to_store(self) -> dict[str, str]:
        """Return the draft as texts that JSON can hold."""
        return {"values": json.dumps(self.values), "base": self.base}

    def get(self, place: Place, default: Any = None) -> Any:
        """Return the value at a place; ``default`` if there is none."""
        value: Any = self.values
        for key in place:
            try:
                value = value[key]
            except (KeyError, IndexError, TypeError):
                return default
        return value

    def set(self, place: Place, value: Any) -> None:
        """Change the value at a place, with the tables on the way; None removes it."""
        table: Any = self.values
        for key in place[:-1]:
            table = table.setdefault(key, {}) if isinstance(table, dict) else table[key]
        if value is not None:
            table[place[-1]] = value
        elif isinstance(table, dict):
            table.pop(place[-1], None)
        else:
            del table[place[-1]]

    @property
    def languages(self) -> list[str]:
        """Languages of the study."""
        return list(self.values["languages"])

    def text(self, place: Place, language: str, default: Any = None) -> str:
        """Return a text in one language, "" if there is none; ``default`` is that of the model."""
        return text_in(self.get(place, default), language)

    def set_text(self, place: Place, language: str, text: str, default: Any = None) -> None:
        """Change a text in one language; the others stay, those of the ``default`` included."""
        before = self.get(place, default)
        others = {tag: text_in(before, tag) for tag in dict.fromkeys((*self.languages, *_own(before)))}
        self.set(place, {tag: other for tag, other in {**others, language: text}.items() if other})

    @property
    def toml(self) -> str:
        """Content of the file to be saved."""
        return tomli_w.dumps(self.values, multiline_strings=True)

    @property
    def changed(self) -> bool:
        """Whether the draft differs from the file."""
        return self.values != _normalised(parse_toml(read_text(self.path), self.path), self.path)

    @property
    def overtaken(self) -> bool:
        """Whether the file was changed elsewhere since the draft began."""
        return _hash(read_text(self.path)) != self.base

    @property
    def has_comments(self) -> bool:
        """Whether the file was written by hand, so that saving loses its comments or layout."""
        text = read_text(self.path)
        return tomli_w.dumps(parse_toml(text, self.path), multiline_strings=True) != text

    def save(self) -> None:
        """Write the file beside its place and rename it; raise `ParameterError` for an invalid study."""
        Study.of(self.values, where=self.path.name)
        text = self.toml
        write_text(self.path, text)
        self.base = _hash(text)


def text_in(value: Any, language: str) -> str:
    """Return a text of a study's file in one language; a plain string is in all."""
    if isinstance(value, str):
        return value
    texts = value or {}
    return str(next((texts[key] for key in (language, language.partition("-")[0], "*") if key in texts), ""))


def copy_study(workspace: Workspace, source: Path | str, name: str, *, languages: Sequence[str] = ()) -> Path:
    """Copy a study under another name and return the file: in ``studies/``, or beside a file of the workspace.

    ``languages`` are those of the copy, by default all; the other texts stay in the file.

    Raises `ParameterError` or `DataError` if the name is invalid or taken, or the source is no valid study.
    """
    name = name.strip()
    if not re.fullmatch(NAME, name):
        raise ParameterError.must(
            "name", "be 1 to 40 lower-case letters, digits and _, beginning with a letter or digit", name[:60]
        )
    shipped = shipped_studies().get(str(source))
    original = shipped or Path(source)
    target = (workspace.inside(STUDIES) if shipped else original.parent) / f"{name}.toml"
    values = _normalised(parse_toml(read_text(original), original), original) | {"name": name}
    values["languages"] = list(languages) or values["languages"]
    Study.of(values, where=original.name)
    if target.exists():
        raise DataError(f"{workspace.name_of(target)} exists; choose another name")
    with atomic_write(target, over=False) as part:
        part.write_text(tomli_w.dumps(values, multiline_strings=True), encoding="utf-8")
    return target


def free_name(workspace: Workspace, source: Path | str) -> str:
    """Return an unused name for a copy of a study."""
    stem = Path(str(source)).stem.replace("-", "_").removeprefix("my_")
    shipped = str(source) in shipped_studies()
    folder = workspace.inside(STUDIES) if shipped else Path(source).parent
    names = (f"my_{stem}"[:37] + (f"_{number}" if number > 1 else "") for number in range(1, 1000))
    return next(name for name in names if not (folder / f"{name}.toml").exists())


def _normalised(values: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """Return values with the name, languages and table of the design, which a file may leave to defaults."""
    study = copy.deepcopy(dict(values))
    if isinstance(study.get("design"), str):
        study["design"] = {"kind": study["design"]}
    study.setdefault("name", path.stem.replace("-", "_"))
    if "languages" not in study:
        study["languages"] = list(Study.of(study, where=path.name).languages)
    return study


def _own(value: Any) -> list[str]:
    return [] if value is None or isinstance(value, str) else [tag for tag in value if tag != "*"]


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


@dataclass(frozen=True)
class DraftCheck:
    """Faults of a draft; without any, its facts as `check_study` returns them."""

    faults: tuple[Fault, ...]
    facts: Mapping[str, Any] | None = None


def check_draft(draft: StudyDraft, *, stimuli: bool = False) -> DraftCheck:
    """Return what `study check` says of a draft, with ``stimuli`` after making and rendering each."""
    faults = tuple(map(_in_lines, Study.faults(draft.values)))
    if faults:
        return DraftCheck(faults)
    study = Study.of(draft.values)
    try:
        return DraftCheck((), check_loaded(study, draft.path.parent, stimuli=stimuli))
    except TactogramError as error:
        return DraftCheck((Fault(_place(error, study), str(error)),))


def _in_lines(fault: Fault) -> Fault:
    """Return a fault of a table of the grid, which the editor shows as lines, in those words."""
    if fault.place[:1] != ("grid",) or fault.kind not in ("dict_type", "model_type"):
        return fault
    return Fault(fault.place, f"{'.'.join(map(str, fault.place))}: {NO_TABLE}")


def _place(error: TactogramError, study: Study) -> Place:
    """Return the place of what an error of a study's check names: a stimulus, those of the grid, or a key."""
    place = error.message.place
    for number, stimulus in enumerate(study.all_stimuli):
        if error.message.place_in(stimulus_place(stimulus.name)) != place:
            return ("stimuli", number) if number < len(study.stimuli) else ("grid",)
    return place_of(error, Study)
