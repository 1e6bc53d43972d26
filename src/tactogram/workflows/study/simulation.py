"""Studies taken by simulated participants, by the same interface as people."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError
from tactogram.signal.io.atomic import atomic_write
from tactogram.study.session.store import SessionStore
from tactogram.study.simulated_participants import SimulatedEffect, simulate
from tactogram.study.study_file import Study
from tactogram.study.trials import Page, Participant
from tactogram.validation import validated
from tactogram.workflows.request import takes
from tactogram.workflows.study.requests import ParticipantsRequest
from tactogram.workflows.study.sessions import ORIGIN, keep_origin, log_played, origin_folder
from tactogram.workflows.study.stimuli import StudyStimuli
from tactogram.workflows.study.studies import study_folder

SIMULATED = "-simulated"
"""Suffix of the folder of a session's simulated participants."""


@takes(ParticipantsRequest)
def simulate_study(request: ParticipantsRequest) -> dict[str, Any]:
    """Let simulated participants take a study, by the same interface as people, into a session folder.

    A folder begun with the same study is continued. ``effect`` holds values of `SimulatedEffect` by name, and
    ``shift.NAME`` for one of its shifts.

    Raises
    ------
    DataError
        If people took the study in that folder: real and simulated answers are kept apart.
    """
    out = request.out
    effect = effect_of(request.effect or {})
    study = Study.load(request.study, changes=request.changes)
    with SessionStore(Path(out), study) as store:
        if any(not known.simulated for known in store.participants()):
            raise DataError(f"{out}: people took this study; give simulated participants another folder")
        keep_origin(store.path.parent, request.study)
        stimuli = StudyStimuli(study, study_folder(request.study))
        store.is_simulated = stimuli.is_simulated
        play = _logger(store, stimuli) if request.play else None
        participants = simulate(
            store,
            request.participants,
            effect=effect,
            seed=request.seed,
            play=play,
            progress=lambda done: request.progress("participants", done, request.participants),
        )
        rows = len(store.answers())
    return _simulated_facts(out, study, participants, effect, rows)


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
    simulated_effect = effect_of(effect or {})
    folder = Path(session)
    with SessionStore(folder) as store:
        study, own = store.study, bool(store.participants())
        own = own and all(known.simulated for known in store.participants())
    out = folder if own else folder.with_name(f"{folder.name}{SIMULATED}")
    with SessionStore(out, study) as store:
        if any(not known.simulated for known in store.participants()):
            raise DataError(
                f"{out}: people took this study; simulated participants need that folder to themselves"
            )
        if (folder / ORIGIN).is_file() and not own:
            with atomic_write(out / ORIGIN) as part:
                part.write_bytes((folder / ORIGIN).read_bytes())
        store.is_simulated = StudyStimuli(study, origin_folder(folder)).is_simulated
        who = simulate(store, participants, effect=simulated_effect, seed=seed, progress=progress)
        rows = len(store.answers())
    return _simulated_facts(out, study, who, simulated_effect, rows)


def _simulated_facts(
    out: Path | str, study: Study, who: list[Participant], effect: SimulatedEffect, rows: int
) -> dict[str, Any]:
    return {
        "folder": str(out),
        "study": study.name,
        "simulated_participants": [participant.code for participant in who],
        "effect": effect.model_dump(),
        "answers": rows,
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
