"""Studies taken by simulated participants, who go the way that people go."""

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
from tactogram.workflows.study.sessions import ORIGIN, keep_origin, log_played
from tactogram.workflows.study.studies import study_folder

SIMULATED = "-simulated"
"""What the folder of a session's simulated participants ends with."""
ProgressCallback = Callable[[int], None]


def simulate_study(
    study: Path | str,
    out: Path | str,
    *,
    participants: int,
    effect: Mapping[str, Any] | None = None,
    seed: int = 0,
    changes: Mapping[str, Any] | None = None,
    play: bool = False,
    progress: ProgressCallback = lambda done: None,
) -> dict[str, Any]:
    """Let simulated participants take a study, by the same interface as people, into a session folder.

    Parameters
    ----------
    study : Path or str
    out : Path
        Folder of the session; one that was begun with the same study goes on.
    participants : int
        How many more.
    effect : mapping, optional
        Values of `SimulatedEffect`, by name; ``shift.NAME`` for one of its shifts. None is no effect.
    seed : int
        Of their answers.
    changes : mapping, optional
        Values of the study, by dotted key.
    play : bool
        Whether stimuli are made and rendered and their hashes logged, as when people take it.
    progress : callable, optional
        Called with how many are done.

    Raises
    ------
    DataError
        If people took the study in that folder: real and simulated answers are kept apart.
    """
    if participants < 1:
        raise ParameterError(f"participants must be at least 1, got {participants}")
    put_in = effect_of(effect or {})
    loaded = Study.load(study, changes=changes)
    with SessionStore(Path(out), loaded) as store:
        if any(not known.simulated for known in store.participants()):
            raise DataError(f"{out}: people took this study; give simulated participants another folder")
        keep_origin(store.path.parent, study)
        logged = _logger(store, loaded, study_folder(study)) if play else None
        who = simulate(store, participants, effect=put_in, seed=seed, play=logged, progress=progress)
        rows = len(store.answers())
    return _simulated_facts(out, loaded, who, put_in, rows)


def simulate_session(
    session: Path | str,
    *,
    participants: int,
    effect: Mapping[str, Any] | None = None,
    seed: int = 0,
    progress: ProgressCallback = lambda done: None,
) -> dict[str, Any]:
    """Let simulated participants take the study of a session, in a folder of their own beside it.

    The folder is called as the session is, with ``-simulated``; for one that is theirs already, it is that one. They
    are kept apart from people whatever happens.

    Parameters
    ----------
    session : Path
    participants, effect, seed, progress
        See `simulate_study`.
    """
    if participants < 1:
        raise ParameterError(f"participants must be at least 1, got {participants}")
    put_in = effect_of(effect or {})
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
        who = simulate(store, participants, effect=put_in, seed=seed, progress=progress)
        rows = len(store.answers())
    return _simulated_facts(out, study, who, put_in, rows)


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
    """Return the effect that values by name say, ``shift.NAME`` being a shift."""
    whole: dict[str, Any] = {}
    for key, value in values.items():
        name, dot, inner = key.partition(".")
        if dot and name == "shift":
            whole.setdefault("shift", {})[inner] = value
        else:
            whole[key] = value
    return validated(SimulatedEffect, whole, where="effect")


def _logger(store: SessionStore, study: Study, folder: Path) -> Callable[[Participant, Page], None]:
    from tactogram.workflows.study.stimuli import StudyStimuli

    stimuli = StudyStimuli(study, folder)

    def play(participant: Participant, page: Page) -> None:
        for presented in page.presented:
            if presented.stimulus is None or presented.stimulus.is_played:
                log_played(store, stimuli, participant.code, page, presented.slot)

    return play
