"""Studies taken by simulated participants, by the same interface as people."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError
from tactogram.text_files import read_json
from tactogram.validation import validated
from tactogram.workflows import takes
from tactogram_study.session.store import SessionStore
from tactogram_study.simulated_participants import SimulatedEffect, simulate
from tactogram_study.study_file import Study
from tactogram_study.trials import Page, Participant
from tactogram_study.workflows.requests import ParticipantsRequest
from tactogram_study.workflows.sessions import ORIGIN, keep_origin, log_played, origin_folder
from tactogram_study.workflows.stimuli import StudyStimuli
from tactogram_study.workflows.studies import study_folder

SIMULATED = "-simulated"
"""Suffix of the folder of a session's simulated participants."""


@takes(ParticipantsRequest)
def simulate_study(request: ParticipantsRequest) -> dict[str, Any]:
    """Let simulated participants take a study, by the same interface as people, into a session folder.

    A folder begun with the same study is continued. ``effect`` holds values of `SimulatedEffect` by name, and
    ``shift.NAME`` for one of its shifts.

    Raises `DataError` if people took the study in that folder: real and simulated answers are kept apart.
    """
    study, count = Study.load(request.study, changes=request.changes), request.participants
    session = Path(request.out), study, request.study, study_folder(request.study)

    def progress(done: int) -> None:
        request.progress("participants", done, count)

    return _simulated(
        *session, count, request.effect, play=request.play, seed=request.seed, progress=progress
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
        raise ParameterError(f"participants must be at least 1, got {participants}")
    folder = Path(session)
    with SessionStore(folder) as store:
        study, who = store.study, store.participants()
    own = bool(who) and all(known.simulated for known in who)
    out = folder if own else folder.with_name(f"{folder.name}{SIMULATED}")
    origin = read_json(folder / ORIGIN)["study"] if (folder / ORIGIN).is_file() else None
    place = origin_folder(folder)
    return _simulated(out, study, origin, place, participants, effect, seed=seed, progress=progress)


def _simulated(
    out: Path,
    study: Study,
    origin: Path | str | None,
    place: Path,
    count: int,
    effect: Mapping[str, Any] | None,
    *,
    play: bool = False,
    **options: Any,
) -> dict[str, Any]:
    """Let simulated participants take a study into a folder.

    ``origin`` is the study's file, None if unknown; the paths of stimuli are relative to ``place``.
    """
    true_effect = effect_of(effect or {})
    with SessionStore(out, study) as store:
        if any(not known.simulated for known in store.participants()):
            raise DataError(f"{out}: people took this study; give simulated participants another folder")
        if origin is not None:
            keep_origin(out, origin)
        stimuli = StudyStimuli(study, place)
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
