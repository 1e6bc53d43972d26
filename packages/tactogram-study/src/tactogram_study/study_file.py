"""Study file: everything that determines a participant's session, as TOML."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, SerializeAsAny, field_validator, model_validator

from tactogram.errors import ParameterError
from tactogram.text_files import read_toml
from tactogram.validation import DescribedModel, Fault, FaultError, faults, validated, with_changes
from tactogram_study.designs import Design, designs
from tactogram_study.designs.catalogue import FOLDERS_VARIABLE
from tactogram_study.planned import PlannedAnalysis
from tactogram_study.practice import Practice
from tactogram_study.questions import Question
from tactogram_study.stimuli import Stimulus, StimulusGrid
from tactogram_study.trials import DesignContext, Rule
from tactogram_study.wording import Language, Wording, language_texts, wordings

NAME = r"^[a-z0-9][a-z0-9_]{0,39}$"
Name = Annotated[str, Field(pattern=NAME)]
PLAIN_TEXT_LANGUAGES: tuple[Language, ...] = ("en", "ja")
"""Languages of a study that neither lists any nor has a text in one."""


class Study(DescribedModel):
    """Content of a study's file. Unknown keys are errors."""

    name: Name
    """Part of every row and of file names; lower-case letters, digits and _."""
    title: Wording
    description: Wording = Wording()
    source: str = ""
    """Publication that is reproduced."""
    languages: tuple[Language, ...] = ()
    """Every text is required in each; the first is the default. By default those of its texts, in the order in which
    they first appear; English and Japanese if all texts are plain strings."""
    seed: int = Field(default=0, ge=0)
    """Decides every order and side that is drawn at random."""
    order: Rule = "random"
    """See `tactogram_study.trials.ordered`."""
    display: str = "audio"
    """Display of the stimuli, as `render` takes it."""
    played_by: Literal["browser", "server", "stream"] = "browser"
    """``browser`` sends the drive to the participant's device and plays it there as sound, in parts of full scale;
    ``server`` plays it on the display at the server; ``stream`` does, too, following the finger on the page."""
    level: str = "physical"
    """Level of the stimuli, as `render` takes it: physical, sensation=20, gain=2 …"""
    rest_every: int = Field(default=0, ge=0)
    """Trials after which a rest is offered; 0 for none."""
    consent: Wording
    """Text that a participant agrees to before the first question. The ethics board's text goes here."""
    before: tuple[Question, ...] = ()
    """Questions before the first trial. No names, no addresses."""
    after: tuple[Question, ...] = ()
    """Questions after the last trial."""
    practice: Practice | None = None
    """Trials before those that count."""
    analysis: PlannedAnalysis | None = None
    """Analysis decided before anybody answers."""
    design: SerializeAsAny[Design]
    stimuli: tuple[Stimulus, ...] = ()
    grid: StimulusGrid | None = None
    """Stimuli by item and condition, in addition to the listed ones."""
    names: dict[str, Wording] | None = None
    """Names of items, conditions and stimuli on pages and in reports, by their keys; rows keep the keys. The key
    ``grid.numbered`` names all of the grid's items, with ``{number}`` in its text."""

    @field_validator("before", "after")
    @classmethod
    def _once(cls, questions: tuple[Question, ...]) -> tuple[Question, ...]:
        ids = Counter(question.id for question in questions)
        if twice := [identifier for identifier, count in ids.items() if count > 1]:
            raise ValueError(f"question {twice[0]} appears twice")
        return questions

    @field_validator("languages")
    @classmethod
    def _different(cls, languages: tuple[Language, ...]) -> tuple[Language, ...]:
        if len(set(languages)) < len(languages):
            raise ValueError("languages must differ")
        return languages

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if not self.languages:
            stated = (language for _, text in wordings(self, stated=True) for language in text.languages)
            object.__setattr__(self, "languages", tuple(dict.fromkeys(stated)) or PLAIN_TEXT_LANGUAGES)
        if not self.all_stimuli:
            raise ValueError("a study needs stimuli, or a grid of them")
        names = Counter(stimulus.name for stimulus in self.all_stimuli)
        if twice := [name for name, count in names.items() if count > 1]:
            raise ValueError(f"names of stimuli must differ, got {twice[0]!r} twice")
        missing = [
            _missing_text((*keys, language))
            for keys, wording in wordings(self)
            for language in self.languages
            if wording and not wording.in_language(language)
        ]
        if missing:
            raise FaultError(*missing)
        self._check_names()
        self.design.check(self.setting)
        if self.practice is not None:
            self.practice.check(self.design, self.setting)
        self.design.check_margins(self.planned.values)
        return self

    @classmethod
    def load(cls, study: Path | str, *, changes: Mapping[str, Any] | None = None) -> Self:
        """Read a TOML file, or one of `shipped_studies` by name; ``changes`` are values by dotted key."""
        path = shipped_studies().get(str(study), Path(study))
        if not path.exists():
            names = ", ".join(shipped_studies())
            raise ParameterError(f"{study}: no such study; shipped ones are {names}")
        values = with_changes(read_toml(path), changes)
        values.setdefault("name", path.stem.replace("-", "_"))
        return cls.of(values, where=str(path))

    @classmethod
    def of(cls, values: Mapping[str, Any], *, where: str = "study") -> Self:
        """Return the study that ``values`` describe; raise `ParameterError`, naming the key, if they describe none."""
        language_texts()  # a wrong language file is reported as such, not as a wrong design
        kind, design = _design_of(values, where)
        valid_design = validated(kind, design, where=f"{where}: design")
        return validated(cls, {**values, "design": valid_design}, where=where)

    @classmethod
    def faults(cls, values: Mapping[str, Any]) -> tuple[Fault, ...]:
        """Return every fault of ``values``: those of the design alone if it has any.

        Raises `ParameterError` for an unknown design.
        """
        kind, design = _design_of(values, "study")
        if wrong := faults(kind, design, where="design"):
            return tuple(Fault(("design", *fault.place), fault.sentence) for fault in wrong)
        return faults(cls, {**values, "design": kind.model_validate(dict(design))}, where="")

    @cached_property
    def all_stimuli(self) -> tuple[Stimulus, ...]:
        """The listed stimuli and those of the grid."""
        return (*self.stimuli, *(self.grid.stimuli(self.display_names) if self.grid else ()))

    @cached_property
    def setting(self) -> DesignContext:
        """Context of its design."""
        return DesignContext(self.name, self.seed, self.order, self.all_stimuli, self.display_names)

    @cached_property
    def display_names(self) -> dict[str, Wording]:
        """Names by key; numbered items one by one."""
        named = dict(self.names or {})
        if self.grid and self.grid.numbered in named:
            pattern = named.pop(self.grid.numbered)
            numbered = {
                item: pattern.filled(number=str(number))
                for number, item in enumerate(self.grid.numbered_items, 1)
            }
            named = {**numbered, **named}
        return named

    def names_in(self, language: Language) -> dict[str, str]:
        """Return the names in a language, by key."""
        return {key: text for key, name in self.display_names.items() if (text := name.in_language(language))}

    @property
    def unused_names(self) -> tuple[str, ...]:
        """Keys of ``names`` that no item, condition or stimulus has: obsolete, or misspelt."""
        return tuple(key for key in self.display_names if key not in self._keys)

    @property
    def _keys(self) -> set[str]:
        return {text for one in self.made_stimuli for text in (one.item, one.condition, one.name) if text}

    def _check_names(self) -> None:
        """Raise ValueError if two keys share a name."""
        keys = self._keys
        for language in self.languages:
            names = self.names_in(language)
            shown = Counter(names.get(key, key) for key in keys)
            if twice := [text for text, count in shown.items() if count > 1]:
                problem = f"two are called {twice[0]!r} in {language}; names must differ"
                raise ParameterError("names", problem)

    @property
    def made_stimuli(self) -> tuple[Stimulus, ...]:
        """Stimuli of the trials, and those of the practice only."""
        return (*self.all_stimuli, *(self.practice.own if self.practice else ()))

    @property
    def planned(self) -> PlannedAnalysis:
        """The planned analysis; by default no margin, and alpha .05."""
        return self.analysis or PlannedAnalysis()

    @property
    def trials(self) -> int:
        """Trials of a participant, or the largest possible number."""
        return self.design.total(self.setting)

    def as_json(self) -> str:
        """Return every resolved value as JSON, for `Study.of`; texts in the study's languages only."""
        values = self.model_dump(mode="json", exclude_none=True, context={"languages": self.languages})
        return json.dumps(values, ensure_ascii=False, sort_keys=True)

    def first_difference(self, other: Study) -> str:
        """Return the first dotted key in which another study differs, "nothing" if none does."""
        return _difference(json.loads(self.as_json()), json.loads(other.as_json())) or "nothing"

    @cached_property
    def sha256(self) -> str:
        """Hash of every resolved value."""
        return hashlib.sha256(self.as_json().encode()).hexdigest()


def _missing_text(place: tuple[int | str, ...]) -> Fault:
    *keys, language = map(str, place)
    text = ".".join(keys)
    return Fault(place, f"{text} lacks the language {language}; give {text}.{language}")


def _design_of(values: Mapping[str, Any], where: str) -> tuple[type[Design], Mapping[str, Any]]:
    """Return the design's class and settings; raise `ParameterError` if there is no such design."""
    design = values.get("design") if isinstance(values, Mapping) else None
    if isinstance(design, str):
        design = {"kind": design}
    kind = design.get("kind") if isinstance(design, Mapping) else design
    if not isinstance(design, Mapping) or not isinstance(kind, str) or kind not in designs():
        known = ", ".join(designs())
        raise ParameterError(
            f"{where}: design.kind must be one of {known}, or of a file that {FOLDERS_VARIABLE} names, got {kind!r}"
        )
    return designs()[kind], design


def _difference(one: Any, other: Any, place: str = "") -> str:
    if isinstance(one, dict) and isinstance(other, dict):
        for key in sorted({*one, *other}):
            inner = f"{place}.{key}" if place else key
            if different := _difference(one.get(key), other.get(key), inner):
                return different
        return ""
    return "" if one == other else place


def shipped_studies() -> dict[str, Path]:
    """Return the studies that come with the package, by name."""
    folder = Path(__file__).parent / "studies"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}
