"""Sessions of studies: start, progress, notes, abort, end and withdrawal; and simulated participants."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram.errors import DataError, ParameterError
from tactogram.parameters import Count, checked, shares_out
from tactogram.signal.io import write_text
from tactogram.text_files import read_json
from tactogram.validation import validated
from tactogram.workflows import ProgressCallback, silent
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import Study, shipped_studies
from tactogram_study.trials import Page, Participant
from tactogram_study.workflows.studies import check_study, study_folder

if TYPE_CHECKING:
    from tactogram_study.simulated_observer import SimulatedEffect
    from tactogram_study.workflows.stimuli import SlotPlayback, StudyStimuli

ORIGIN = "origin.json"
"""File in a session folder with the path of its study."""


def begin_session(study: Path | str, out: Path | str, *, changes: Mapping[str, Any] | None = None) -> Path:
    """Start a study in a session folder, or continue it, and return the folder.

    The path of the study's file is written next to the answers (``origin.json``): stimuli are relative to it.

    Raises `TactogramError` if the study is wrong, a stimulus's file is missing, or the folder holds another study.
    """
    check_study(study, changes=changes)
    folder = Path(out)
    with SessionStore(folder, Study.load(study, changes=changes)):
        pass
    keep_origin(folder, study)
    return folder


def origin_folder(session: Path | str) -> Path:
    """Return the folder of a session's study; the session's own folder if it is not recorded.

    Raises `DataError` if the record cannot be read.
    """
    path = Path(session) / ORIGIN
    if not path.is_file():
        return Path(session)
    try:
        return study_folder(read_json(path)["study"])
    except (DataError, KeyError, TypeError) as error:
        reason = str(error) if isinstance(error, DataError) else f"{path}: lacks the study"
        raise DataError(f"{reason}; run the study again with its file") from None


def keep_origin(folder: Path, study: Path | str) -> None:
    """Record the path of the study's file in a session folder."""
    shipped = str(study) in shipped_studies()
    origin = {"study": str(study) if shipped else str(Path(study).resolve()), "shipped": shipped}
    write_text(folder / ORIGIN, json.dumps(origin, ensure_ascii=False) + "\n")


def begin_trials(store: SessionStore, code: str) -> None:
    """Answer the consent and the questions before the trials for a participant, each with a first possible answer."""
    while (page := store.participant_state(code).page) is not None and page.kind in ("consent", "questions"):
        answers = {question.key: question.question.example for question in page.questions}
        store.submit(code, page.token, answers)


@checked
def session_progress(folder: Path | str) -> dict[str, Any]:
    """Show the progress of each participant in a session.

    Parameters
    ----------
    folder : Path or str
        Folder of the session.

    Returns
    -------
    dict
        ``participants``, their counts by status, the notes, and when the session was ``ended``.
    """
    with SessionStore(Path(folder)) as store:
        everybody = store.progress()
        return {
            "folder": str(folder),
            "study": store.study.name,
            "participants": [known | {"device": store.device(known["participant"])} for known in everybody],
            "statuses": dict(Counter(known["status"] for known in everybody)),
            "notes": store.notes(),
            "ended": store.ended,
            "withdrawn": store.withdrawn,
            "answers": store.count,
        }


@checked
def write_note(folder: Path | str, text: str, *, participant: str | None = None) -> dict[str, Any]:
    """Add an experimenter's note to a session.

    Parameters
    ----------
    folder : Path or str
        Folder of the session.
    text : str
        Text of the note; no names of people.
    participant : str, optional
        Code of the participant the note is about (default: the whole study).

    Returns
    -------
    dict
        ``folder``, and the number of ``notes`` in it.
    """
    with SessionStore(Path(folder)) as store:
        store.note(text, code=participant)
        return {"folder": str(folder), "notes": len(store.notes())}


@checked
def abort_participant(folder: Path | str, code: str, *, undo: bool = False) -> dict[str, Any]:
    """End a participant's session now; the answers so far are kept.

    Parameters
    ----------
    folder : Path or str
        Folder of the session.
    code : str
        Code of the participant.
    undo : bool
        Let the participant continue.

    Returns
    -------
    dict
        ``folder``, ``participant`` and ``state``.
    """
    with SessionStore(Path(folder)) as store:
        (store.reopen if undo else store.abort)(code)
        return {"folder": str(folder), "participant": code, "state": store.state(code)}


@checked
def end_session(folder: Path | str, *, undo: bool = False) -> dict[str, Any]:
    """End a study: nobody can join, and unfinished participants cannot continue.

    Parameters
    ----------
    folder : Path or str
        Folder of the session.
    undo : bool
        Let the study continue.

    Returns
    -------
    dict
        ``folder``, and when it ``ended``.
    """
    with SessionStore(Path(folder)) as store:
        (store.reopen_study if undo else store.end)()
        return {"folder": str(folder), "ended": store.ended}


@checked
def withdraw(folder: Path | str, code: str) -> dict[str, Any]:
    """Delete a participant and all their data; export tables again afterwards.

    Parameters
    ----------
    folder : Path or str
        Folder of the session.
    code : str
        Code of the participant.

    Returns
    -------
    dict
        ``folder``, ``answers_deleted`` and ``participants_left``.
    """
    with SessionStore(Path(folder)) as store:
        deleted = store.withdraw(code)
        left = len(store.participants())
    return {"folder": str(folder), "answers_deleted": deleted, "participants_left": left}


def log_played(store: SessionStore, stimuli: StudyStimuli, code: str, page: Page, slot: str) -> SlotPlayback:
    """Render the stimulus in a slot of a participant's page, log it, and return it."""
    played = stimuli.played(page.slot(slot))
    store.log_played(code, page.token, slot, **played.logged)
    return played


SIMULATED = "-simulated"
"""Suffix of the folder of a session's simulated participants."""


@checked
@shares_out
def simulate_study(
    study: Path | str,
    out: Path | str,
    *,
    participants: Count = 20,
    effect: Mapping[str, Any] | None = None,
    seed: int = 0,
    play: bool = False,
    changes: Mapping[str, Any] | None = None,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Let simulated participants take a study, with or without an effect.

    They use the same interface as people. ``progress`` is called with each participant who is done.

    Parameters
    ----------
    study : Path or str
        A study: a TOML file, or one of `study list`.
    out : Path or str
        Folder of the session; created, or continued with the same study.
    participants : int
        Number of simulated participants.
    effect : mapping, optional
        True effect, e.g. d_prime=1 or shift.generated=-10 (default: none); the values of `SimulatedEffect`.
    seed : int
        Seed of their answers.
    play : bool
        Generate and render stimuli and log their hashes.
    changes : mapping, optional
        Change a value of the study.

    Returns
    -------
    dict
        ``folder``, ``study``, the codes of the ``simulated_participants``, the whole ``effect``, and the number of
        ``answers``.

    Raises
    ------
    DataError
        If people took the study in that folder: real and simulated answers are kept apart.
    """
    loaded = Study.load(study, changes=changes)

    def done(count: int) -> None:
        progress("participants", count, participants)

    return _simulated(
        Path(out),
        loaded,
        study,
        study_folder(study),
        participants,
        effect,
        play=play,
        seed=seed,
        progress=done,
    )


def simulate_session(
    session: Path | str,
    *,
    participants: int,
    effect: Mapping[str, Any] | None = None,
    seed: int = 0,
    progress: Callable[[int], None] = lambda done: None,
) -> dict[str, Any]:
    """Let simulated participants take the study of a session, in a separate folder next to it.

    The folder has the session's name with ``-simulated``; a session of simulated participants is continued itself.
    The parameters are those of `simulate_study`.
    """
    if participants < 1:
        raise ParameterError.must("participants", "be at least 1", participants)
    folder = Path(session)
    with SessionStore(folder) as store:
        study, who = store.study, store.participants()
    own = bool(who) and all(known.simulated for known in who)
    out = folder if own else folder.with_name(f"{folder.name}{SIMULATED}")
    origin = read_json(folder / ORIGIN)["study"] if (folder / ORIGIN).is_file() else None
    stimuli_folder = origin_folder(folder)
    return _simulated(out, study, origin, stimuli_folder, participants, effect, seed=seed, progress=progress)


def _simulated(
    out: Path,
    study: Study,
    origin: Path | str | None,
    stimuli_folder: Path,
    count: int,
    effect: Mapping[str, Any] | None,
    *,
    play: bool = False,
    **options: Any,
) -> dict[str, Any]:
    """Let simulated participants take a study into a folder.

    ``origin`` is the study's file, None if unknown; the paths of stimuli are relative to ``stimuli_folder``.
    """
    from tactogram_study.simulated_participants import simulate
    from tactogram_study.workflows.stimuli import StudyStimuli

    true_effect = effect_of(effect or {})
    with SessionStore(out, study) as store:
        if any(not known.simulated for known in store.participants()):
            raise DataError(out, "people took this study; give simulated participants another folder")
        if origin is not None:
            keep_origin(out, origin)
        stimuli = StudyStimuli(study, stimuli_folder)
        store.is_simulated, store.limited = stimuli.is_simulated, stimuli.limited
        log = _logger(store, stimuli) if play else None
        who = simulate(store, count, effect=true_effect, play=log, **options)
        return {
            "folder": str(out),
            "study": study.name,
            "simulated_participants": [participant.code for participant in who],
            "effect": true_effect.model_dump(),
            "answers": store.count,
            "simulated": True,
        }


def effect_of(values: Mapping[str, Any]) -> SimulatedEffect:
    """Return the effect with these values by name; ``shift.NAME`` is one of its shifts."""
    from tactogram_study.simulated_observer import SimulatedEffect

    whole: dict[str, Any] = {}
    for key, value in values.items():
        name, dot, inner = key.partition(".")
        if dot and name == "shift":
            whole.setdefault("shift", {})[inner] = value
        else:
            whole[key] = value
    return validated(SimulatedEffect, whole, where="effect")


def _logger(store: SessionStore, stimuli: StudyStimuli) -> Callable[[Participant, Page], None]:
    def play(participant: Participant, page: Page) -> None:
        for presented in page.presented:
            if presented.stimulus is None or presented.stimulus.is_played:
                log_played(store, stimuli, participant.code, page, presented.slot)

    return play
