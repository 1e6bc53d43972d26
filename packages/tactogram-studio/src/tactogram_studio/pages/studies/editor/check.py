"""Check of a draft: the sentences of `study check`, each with its place in the form, and the study's size."""

from __future__ import annotations

import copy
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactogram.errors import TactogramError
from tactogram.validation import Fault
from tactogram_studio.pages.studies.editor.draft import Place, StudyDraft
from tactogram_studio.pages.studies.editor.fields import text_default
from tactogram_study.study_file import Study
from tactogram_study.workflows.studies import check_loaded

LACKS = re.compile(r"([\w.{}:/-]+) lacks the language ([\w-]+);")
NAMED = re.compile(r"([a-z_][\w.]*)(?:: | must | needs )")
STIMULUS = re.compile(r"stimulus (.+?): ")
CONDITION = re.compile(r"grid: by_condition\.(.+?): ")
NO_TABLE = "each line must be NAME = VALUE as in the study's file, texts in quotes"
MOST_MISSING = 200


@dataclass(frozen=True)
class DraftCheck:
    """Faults of a draft; without any, its facts as `check_study` returns them."""

    faults: tuple[Fault, ...]
    facts: Mapping[str, Any] | None = None


def check_draft(draft: StudyDraft, *, stimuli: bool = False) -> DraftCheck:
    """Return what `study check` says of a draft, with ``stimuli`` after making and rendering each."""
    values = draft.values
    found = [_placed(fault, values) for fault in _faults(values)]
    if not found:
        try:
            study = Study.of(values)
            return DraftCheck((), check_loaded(study, draft.path.parent, stimuli=stimuli))
        except TactogramError as error:
            found = [_placed(Fault((), str(error)), values)]
    return DraftCheck(tuple(found))


def _faults(values: dict[str, Any]) -> list[Fault]:
    """Return the faults of values; missing texts one by one, each filled to find the next."""
    missing: list[Fault] = []
    probe = StudyDraft(Path(), copy.deepcopy(values), "")
    while True:
        faults = Study.faults(probe.values)
        lacking = LACKS.match(faults[0].sentence) if len(faults) == 1 else None
        if lacking is None or len(missing) == MOST_MISSING:
            return missing or list(faults)
        place = _place(lacking[1])
        missing.append(Fault((*place, lacking[2]), faults[0].sentence))
        kind = probe.get(("design", "kind"))
        probe.set_text(place, lacking[2], "?", text_default(kind, place))


def _placed(fault: Fault, values: Mapping[str, Any]) -> Fault:
    """Return a fault with the place that its sentence begins with, if it has none or that of the grid alone."""
    if fault.place[:1] == ("grid",) and "must be a valid dictionary" in fault.sentence:
        return Fault(fault.place, f"{'.'.join(map(str, fault.place))}: {NO_TABLE}")
    if fault.place == ("grid",) and (condition := CONDITION.match(fault.sentence)):
        return Fault(("grid", "by_condition", condition[1]), fault.sentence)
    if fault.place:
        return fault
    if stimulus := STIMULUS.match(fault.sentence):
        for number, one in enumerate(values.get("stimuli", ())):
            if one.get("name") == stimulus[1]:
                return Fault(("stimuli", number), fault.sentence)
        return Fault(("grid",), fault.sentence)
    named = NAMED.match(fault.sentence)
    first = named[1].split(".")[0] if named else ""
    if named and first in Study.model_fields:
        return Fault(_place(named[1]), fault.sentence)
    return fault


def _place(text: str) -> Place:
    """Return the place of a dotted key; keys of names may have dots of their own."""
    first, _, rest = text.partition(".")
    if first == "names":
        return ("names", rest)
    return tuple(int(part) if part.isdigit() else part for part in text.split("."))
