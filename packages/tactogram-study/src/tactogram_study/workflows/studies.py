"""Studies that come with the package, and checks of a study's file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError
from tactogram.rendering import parse_level
from tactogram_study.designs import designs
from tactogram_study.language_files import language_texts, missing_texts, own_name
from tactogram_study.session_length import planned_minutes
from tactogram_study.study_file import Study, shipped_studies
from tactogram_study.trials import PresentedStimulus
from tactogram_study.workflows.stimuli import StudyStimuli


def list_studies() -> dict[str, Any]:
    """Return the facts by which to choose a study, for each that comes with the package."""
    studies = {name: (Study.load(path), path.parent) for name, path in shipped_studies().items()}
    return {name: _facts(StudyStimuli(study, folder)) for name, (study, folder) in studies.items()}


def list_designs() -> dict[str, Any]:
    """Return the designs of studies by kind, with their margins and power tables."""
    return {
        kind: {
            "title": design.title,
            "question": design.question_text,
            "margins": {name: scale.unit for name, scale in design.margins.items()},
            "power": list(design.power),
        }
        for kind, design in designs().items()
    }


def list_languages() -> dict[str, Any]:
    """Return the languages of participants' pages by tag, with their own names and the keys that are English."""
    return {
        language: {"name": own_name(language), "missing_texts": list(missing_texts(language))}
        for language in language_texts()
    }


def check_study(
    study: Path | str, *, changes: Mapping[str, Any] | None = None, stimuli: bool = False
) -> dict[str, Any]:
    """Check a study's file, levels, displays, and the files and names of its stimuli; return its facts.

    With ``stimuli`` every stimulus is also made and rendered on its display, which can take a while; ``limited`` are
    sentences, by stimulus, on what was outside of what its run learned.

    Raises `TactogramError` for the first fault, in one line.
    """
    return check_loaded(Study.load(study, changes=changes), study_folder(study), stimuli=stimuli)


def check_loaded(study: Study, folder: Path, *, stimuli: bool = False) -> dict[str, Any]:
    """Check a study whose paths are relative to ``folder``, as `check_study` does its file."""
    for place in ("title", "consent"):
        if not getattr(study, place):
            raise ParameterError(f"{place} must have a text, got none")
    made = StudyStimuli(study, folder)
    made.check_names()
    for stimulus in study.made_stimuli:
        if stimulus.is_played:
            parse_level(stimulus.level or study.level)
        for name in (stimulus.file, stimulus.image):
            path = Path(name) if Path(name).is_absolute() else folder / name
            if name and not path.is_file():
                raise DataError(f"stimulus {stimulus.name}: {path}: no such file")
    facts = _facts(made) | {"sha256": study.sha256, "rendered": None, "limited": {}}
    if stimuli:
        facts |= {"rendered": _render_all(made), "limited": made.limited()}
    return facts


def study_folder(study: Path | str) -> Path:
    """Return the folder of a study's file, to which its paths are relative."""
    return shipped_studies().get(str(study), Path(study)).parent


def _facts(made: StudyStimuli) -> dict[str, Any]:
    study = made.study
    return {
        "name": study.name,
        "title": study.title.in_english(),
        "design": study.design.kind,
        "trials": study.trials,
        "minutes": round(planned_minutes(study), 1),
        "stimuli": len(study.all_stimuli),
        "conditions": list(dict.fromkeys(stimulus.condition for stimulus in study.all_stimuli)),
        "simulated_stimuli": sum(map(made.is_simulated, study.all_stimuli)),
        "practice": study.practice.trials if study.practice else 0,
        "margins": study.planned.values,
        "alpha": study.planned.alpha,
        "unused_names": list(study.unused_names),
        "order": study.order,
        "seed": study.seed,
        "languages": list(study.languages),
        "missing_texts": {one: list(keys) for one in study.languages if (keys := missing_texts(one))},
        "display": study.display,
        "played_by": study.played_by,
        "level": study.level,
        "source": study.source,
    }


def _render_all(made: StudyStimuli) -> dict[str, str]:
    """Make and render every stimulus, and return the hashes by name."""
    hashes = {}
    for stimulus in made.study.made_stimuli:
        made.image(stimulus)
        if stimulus.is_played:
            hashes[stimulus.name] = made.played(PresentedStimulus("", stimulus)).sha256
    return hashes
