"""Studies: those that come with the package, and what a study's file asks of a participant."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactogram.errors import DataError
from tactogram.rendering.level import parse_level
from tactogram.study.designs import designs
from tactogram.study.study_file import Study, shipped_studies
from tactogram.study.trials import PresentedStimulus
from tactogram.workflows.study.stimuli import StudyStimuli


def list_studies() -> dict[str, Any]:
    """Return the studies that come with the package, by name, with what there is to choose by."""
    return {name: _facts(Study.load(path)) for name, path in shipped_studies().items()}


def list_designs() -> dict[str, Any]:
    """Return the designs that a study can have, by kind, with what a margin can be given for and the power tables."""
    return {
        kind: {
            "title": design.title,
            "question": design.question_text,
            "margins": {name: scale.unit for name, scale in design.margins.items()},
            "power": list(design.power),
        }
        for kind, design in designs().items()
    }


def check_study(
    study: Path | str, *, changes: Mapping[str, Any] | None = None, stimuli: bool = False
) -> dict[str, Any]:
    """Return what a study asks of a participant, after checking its file, levels, displays, files and names of stimuli.

    Parameters
    ----------
    study : Path or str
        A TOML file, or the name of a shipped one.
    changes : mapping, optional
        Values by dotted key.
    stimuli : bool
        Whether every stimulus is made and rendered on its display, too; generating can take a while.

    Raises
    ------
    TactogramError
        Whatever is wrong first, in one line.
    """
    loaded = Study.load(study, changes=changes)
    folder = study_folder(study)
    made = StudyStimuli(loaded, folder)
    made.check_names()
    for stimulus in loaded.made_stimuli:
        if stimulus.is_played:
            parse_level(stimulus.level or loaded.level)
        for name in (stimulus.file, stimulus.image):
            path = Path(name) if Path(name).is_absolute() else folder / name
            if name and not path.is_file():
                raise DataError(f"stimulus {stimulus.name}: {path}: no such file")
    facts = _facts(loaded) | {"sha256": loaded.sha256, "rendered": None}
    if stimuli:
        facts["rendered"] = _render_all(made)
    return facts


def study_folder(study: Path | str) -> Path:
    """Return what the files of a study stand beside."""
    return shipped_studies().get(str(study), Path(study)).parent


def _facts(study: Study) -> dict[str, Any]:
    language = study.languages[0]
    return {
        "name": study.name,
        "title": study.title.en or study.title.in_language(language),
        "design": study.design.kind,
        "trials": study.trials,
        "stimuli": len(study.all_stimuli),
        "conditions": list(dict.fromkeys(stimulus.condition for stimulus in study.all_stimuli)),
        "simulated_stimuli": sum(stimulus.is_simulated for stimulus in study.all_stimuli),
        "practice": study.practice.trials if study.practice else 0,
        "margins": study.planned.values,
        "alpha": study.planned.alpha,
        "unused_names": list(study.unused_names),
        "order": study.order,
        "seed": study.seed,
        "languages": list(study.languages),
        "display": study.display,
        "level": study.level,
        "source": study.source,
    }


def _render_all(made: StudyStimuli) -> dict[str, str]:
    """Make and render every stimulus, and return its hash."""
    hashes = {}
    for stimulus in made.study.made_stimuli:
        made.image(stimulus)
        if stimulus.is_played:
            hashes[stimulus.name] = made.played(PresentedStimulus("", stimulus)).sha256
    return hashes
