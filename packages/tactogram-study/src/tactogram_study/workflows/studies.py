"""Studies that come with the package, and checks of a study's file."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram.errors import DataError, ParameterError
from tactogram.parameters import checked
from tactogram.signal.io import atomic_write
from tactogram.text_files import parse_toml, read_text
from tactogram_study.designs import designs
from tactogram_study.questions import Question
from tactogram_study.study_file import NAME, Study, shipped_studies
from tactogram_study.trials import Page, PageAnswers, Participant, PresentedStimulus
from tactogram_study.wording import complete_texts, language_texts, missing_texts, own_name

if TYPE_CHECKING:
    from tactogram_study.workflows.stimuli import StudyStimuli

INTRODUCTION_S = 120.0
"""Consent, and matching the card to the screen."""
ANSWER_S = {"choice": 3.0, "steps": 4.0, "vas": 6.0, "number": 6.0, "text": 20.0}
"""For each question, by its kind."""
STIMULUS_S = 3.0
"""For each stimulus whose ``seconds`` are not in the file."""
CHANGE_S = 2.0
"""Before each page, and before each stimulus."""


def planned_minutes(study: Study) -> float:
    """Return the length of a session in minutes, without rests; of a staircase with all of its trials."""
    trial = sum(map(_page_seconds, _first_trial(study)))
    trials = study.trials + (study.practice.trials if study.practice else 0)
    around = _answer_seconds((*study.before, *study.after))
    return (INTRODUCTION_S + around + trials * trial) / 60


def _first_trial(study: Study) -> Iterator[Page]:
    """Yield the pages of the first participant's first trial."""
    history: list[PageAnswers] = []
    while (page := study.design.next_page(study.setting, Participant("P1", 1), history)) is not None:
        if page.trial > 1:
            return
        yield page
        answers = {question.key: question.right or question.question.example for question in page.questions}
        history.append(PageAnswers(page.token, answers, page.more))


def _page_seconds(page: Page) -> float:
    stimuli = [presented.stimulus.seconds if presented.stimulus else None for presented in page.presented]
    touching_s = sum(CHANGE_S + (seconds or STIMULUS_S) for seconds in stimuli)
    return CHANGE_S + touching_s + _answer_seconds([question.question for question in page.questions])


def _answer_seconds(questions: Sequence[Question]) -> float:
    return sum(ANSWER_S[question.kind] for question in questions)


def list_studies() -> dict[str, Any]:
    """List the studies that come with the package.

    Returns
    -------
    dict
        By name the facts by which to choose one, those of `check_study`.
    """
    from tactogram_study.workflows.stimuli import StudyStimuli

    return {
        name: _facts(StudyStimuli(Study.load(path), path.parent)) for name, path in shipped_studies().items()
    }


def list_designs() -> dict[str, Any]:
    """List the designs that a study can have, with their margins and power tables.

    Returns
    -------
    dict
        By kind ``title``, ``question``, ``margins`` (their units by name) and ``power`` (names of tables).
    """
    return {
        kind: {
            "title": design.title,
            "question": design.question_text,
            "margins": {name: scale.unit for name, scale in design.margins.items()},
            "power": list(design.power),
        }
        for kind, design in designs().items()
    }


@checked
def list_languages(language: str = "") -> dict[str, Any]:
    """List the languages of participants' pages, or print the texts of one.

    Parameters
    ----------
    language : str, optional
        Print the texts of this language as a file to translate, missing ones in English.

    Returns
    -------
    dict
        By tag the ``name`` of each language in itself, and ``missing_texts``, the keys that are English; of one
        language its texts by key.
    """
    if language:
        return dict(complete_texts(language))
    return {
        tag: {"name": own_name(tag), "missing_texts": list(missing_texts(tag))} for tag in language_texts()
    }


@checked
def copy_study(study: Path | str, *, out: Path | str) -> dict[str, Any]:
    """Copy a study into a file of your own, to be edited.

    Parameters
    ----------
    study : Path or str
        A study: a TOML file, or one of `study list`.
    out : Path or str
        The new file (.toml), whose name becomes that of the study.

    Returns
    -------
    dict
        ``study``, the file, and ``name``.

    Raises
    ------
    TactogramError
        If the study is not valid, the name is no name of a study, or the file exists.
    """
    source, target = shipped_studies().get(str(study), Path(study)), Path(out)
    name = target.stem.replace("-", "_")
    if target.suffix != ".toml" or not re.fullmatch(NAME, name):
        raise ParameterError.must("out", "end in .toml, after lower-case letters, digits and _", target.name)
    text = re.sub(r'(?m)^name = ".*"$', f'name = "{name}"', read_text(source), count=1)
    Study.of(parse_toml(text, source), where=source.name)
    if target.exists():
        raise DataError(target, "exists; choose another name")
    with atomic_write(target, over=False) as part:
        part.write_text(text, encoding="utf-8")
    return {"study": str(target), "name": name}


@checked
def check_study(
    study: Path | str, *, stimuli: bool = False, changes: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Check a study's file and describe what it asks of a participant.

    Levels, displays, and the files and names of its stimuli are checked, too.

    Parameters
    ----------
    study : Path or str
        A study: a TOML file, or one of `study list`.
    stimuli : bool
        Also generate and render every stimulus, which can take a while.
    changes : mapping, optional
        Change a value of the study.

    Returns
    -------
    dict
        Facts on the study; ``rendered`` are hashes by stimulus, ``limited`` sentences, by stimulus, on what was
        outside of what its run learned.

    Raises
    ------
    TactogramError
        For the first fault, in one line.
    """
    return check_loaded(Study.load(study, changes=changes), study_folder(study), stimuli=stimuli)


def check_loaded(study: Study, folder: Path, *, stimuli: bool = False) -> dict[str, Any]:
    """Check a study whose paths are relative to ``folder``, as `check_study` does its file."""
    for field in ("title", "consent"):
        if not getattr(study, field):
            raise ParameterError.must(field, "have a text, got none")
    from tactogram_study.workflows.stimuli import StudyStimuli

    study_stimuli = StudyStimuli(study, folder)
    study_stimuli.check()
    facts = _facts(study_stimuli) | {"sha256": study.sha256, "rendered": None, "limited": {}}
    if stimuli:
        facts |= {"rendered": _render_all(study_stimuli), "limited": study_stimuli.limited()}
    return facts


def study_folder(study: Path | str) -> Path:
    """Return the folder of a study's file, to which its paths are relative."""
    return shipped_studies().get(str(study), Path(study)).parent


def _facts(stimuli: StudyStimuli) -> dict[str, Any]:
    study = stimuli.study
    return {
        "name": study.name,
        "title": study.title.in_english(),
        "design": study.design.kind,
        "trials": study.trials,
        "minutes": round(planned_minutes(study), 1),
        "stimuli": len(study.all_stimuli),
        "conditions": list(dict.fromkeys(stimulus.condition for stimulus in study.all_stimuli)),
        "simulated_stimuli": sum(map(stimuli.is_simulated, study.all_stimuli)),
        "practice": study.practice.trials if study.practice else 0,
        "margins": study.planned.values,
        "alpha": study.planned.alpha,
        "unused_names": list(study.unused_names),
        "order": study.order,
        "seed": study.seed,
        "languages": list(study.languages),
        "missing_texts": {tag: list(keys) for tag in study.languages if (keys := missing_texts(tag))},
        "display": study.display,
        "played_by": study.played_by,
        "level": study.level,
        "source": study.source,
    }


def _render_all(stimuli: StudyStimuli) -> dict[str, str]:
    """Make and render every stimulus, and return the hashes by name."""
    hashes = {}
    for stimulus in stimuli.study.made_stimuli:
        stimuli.image(stimulus)
        if stimulus.is_played:
            hashes[stimulus.name] = stimuli.played(PresentedStimulus("", stimulus)).sha256
    return hashes
