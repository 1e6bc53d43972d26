"""Studies: listed, checked, taken by simulated participants, exported, withdrawn from."""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.level import parse_level
from tactogram.signal.io.files import written_beside
from tactogram.study.answers import SUFFIXES, Answers, read_answers, write_answers
from tactogram.study.beside import write_beside
from tactogram.study.bids_rules import problems
from tactogram.study.export import export_bids
from tactogram.study.importing import Mapped, import_answers
from tactogram.study.session_store import SessionStore
from tactogram.study.simulated import SimulatedEffect, simulate
from tactogram.study.study_file import Study, shipped_studies
from tactogram.study.trials import Page, Participant
from tactogram.validation import validated

SIMULATED = "-simulated"
"""What the folder of a session's simulated participants ends with."""
STUDY_SUFFIX = ".study.json"
"""Of the file beside a table that holds the study it is of."""
ORIGIN = "origin.json"
"""In a session folder: where its study's file lies."""
Progress = Callable[[int], None]


def list_studies() -> dict[str, Any]:
    """Return the studies that come with the package, by name, with what there is to choose by."""
    return {name: _facts(Study.load(path)) for name, path in shipped_studies().items()}


def check_study(
    study: Path | str, *, changes: Mapping[str, Any] | None = None, stimuli: bool = False
) -> dict[str, Any]:
    """Return what a study asks of a participant, after checking its file, levels and files of stimuli.

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
    for stimulus in loaded.made_stimuli:
        if stimulus.is_played:
            parse_level(stimulus.level or loaded.level)
        for name in (stimulus.file, stimulus.image):
            path = Path(name) if Path(name).is_absolute() else folder / name
            if name and not path.is_file():
                raise DataError(f"stimulus {stimulus.name}: {path}: no such file")
    facts = _facts(loaded) | {"sha256": loaded.sha256, "rendered": None}
    if stimuli:
        facts["rendered"] = _render_all(loaded, folder)
    return facts


def begin_session(study: Path | str, out: Path | str, *, changes: Mapping[str, Any] | None = None) -> Path:
    """Begin a study in a session folder, or go on with it, and return the folder.

    Where the study's file lies is kept beside the answers (``origin.json``): stimuli are looked for there.

    Parameters
    ----------
    study : Path or str
        A TOML file, or the name of a shipped one.
    out : Path
        New, or begun with the same study.
    changes : mapping, optional
        Values by dotted key.

    Raises
    ------
    TactogramError
        If the study is wrong, a stimulus's file is missing, or the folder holds another study.
    """
    check_study(study, changes=changes)
    folder = Path(out)
    with SessionStore(folder, Study.load(study, changes=changes)):
        pass
    _keep_origin(folder, study)
    return folder


def origin_folder(session: Path | str) -> Path:
    """Return what the files of a session's study stand beside; the session's own folder where nobody said.

    Raises
    ------
    DataError
        If what was said cannot be read.
    """
    path = Path(session) / ORIGIN
    if not path.is_file():
        return Path(session)
    try:
        return study_folder(json.loads(path.read_text(encoding="utf-8"))["study"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DataError(f"{path}: not readable: {error}; run the study again with its file") from error


def simulate_study(
    study: Path | str,
    out: Path | str,
    *,
    participants: int,
    effect: Mapping[str, Any] | None = None,
    seed: int = 0,
    changes: Mapping[str, Any] | None = None,
    play: bool = False,
    progress: Progress = lambda done: None,
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
        _keep_origin(store.path.parent, study)
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
    progress: Progress = lambda done: None,
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
            with written_beside(out / ORIGIN) as part:
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


def export_zip(folder: Path | str, *, kind: Literal["tables", "bids"]) -> tuple[str, bytes]:
    """Return the name and the bytes of a ZIP file with the answers of a session.

    Parameters
    ----------
    folder : Path
        Of the session.
    kind : {"tables", "bids"}
        What `export_study` writes as a table with what stands beside it, or as a BIDS folder.
    """
    name = Path(folder).resolve().name
    with tempfile.TemporaryDirectory(prefix="tactogram-export-") as temporary:
        whole = Path(temporary) / f"{name}-{kind}"
        if kind == "bids":
            export_study(folder, bids=whole)
        else:
            whole.mkdir()
            export_study(folder, table=whole / "answers.csv")
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
            for path in sorted(whole.rglob("*")):
                if path.is_file():
                    file.write(path, path.relative_to(whole.parent))
    return f"{name}-{kind}.zip", packed.getvalue()


def export_study(
    folder: Path | str, *, table: Path | str | None = None, bids: Path | str | None = None
) -> dict[str, Any]:
    """Write the answers of a session folder as a tidy table, as a BIDS folder, or both.

    Parameters
    ----------
    folder : Path
    table : Path, optional
        ``.csv``, ``.tsv`` or ``.parquet``. Beside it stand the study (``.study.json``), the participants with what
        their devices said (``.participants.csv``), and the experimenter's notes (``.notes.csv``).
    bids : Path, optional
        A new folder. It is checked by `bids_rules.problems`.
    """
    if table is None and bids is None:
        raise ParameterError("export needs where to: --out F.csv, --bids DIR, or both")
    with SessionStore(Path(folder)) as store:
        answers = store.answers()
        facts: dict[str, Any] = {
            "study": store.study.name,
            "answers": len(answers),
            "participants": len(answers.unique("participant")),
            "simulated_participants": len(answers.where(simulated=True).unique("participant")),
            "withdrawn": store.withdrawn,
            "notes": len(store.notes()),
        }
        if table is not None:
            path = Path(table)
            write_answers(path, answers)
            described = path.with_suffix(STUDY_SUFFIX)
            with written_beside(described) as part:
                text = json.dumps(json.loads(store.study.as_json()), ensure_ascii=False, indent=1)
                part.write_text(text + "\n", encoding="utf-8")
            participants, notes = write_beside(path, store)
            facts |= {
                "table": str(path),
                "study_file": str(described),
                "participants_table": str(participants),
                "notes_table": str(notes),
            }
        if bids is not None:
            made = export_bids(store, Path(bids))
            facts |= {"bids": str(made), "bids_problems": problems(made)}
    return facts


def withdraw(folder: Path | str, code: str) -> dict[str, Any]:
    """Delete a participant and all that is kept of them in a session folder."""
    with SessionStore(Path(folder)) as store:
        deleted = store.withdraw(code)
        left = len(store.participants())
    return {"folder": str(folder), "answers_deleted": deleted, "participants_left": left}


def open_answers(
    source: Path | str,
    *,
    columns: Mapping[str, str] | None = None,
    constants: Mapping[str, str] | None = None,
    encoding: str = "utf-8-sig",
) -> Answers:
    """Return the answers of a session folder, of a table, or of another's table by a mapping of columns.

    Parameters
    ----------
    source : Path
    columns, constants : mapping, optional
        See `tactogram.study.importing.Mapped`; any of them makes it another's table.
    encoding : str
    """
    path = Path(source)
    if path.is_dir():
        with SessionStore(path) as store:
            return store.answers()
    if path.suffix.lower() not in SUFFIXES:
        raise ParameterError(f"{path}: answers are a session folder or {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise DataError(f"{path}: no such file")
    if columns or constants:
        return import_answers(path, Mapped(columns or {}, constants or {}, encoding=encoding))
    return read_answers(path)


def _keep_origin(folder: Path, study: Path | str) -> None:
    shipped = str(study) in shipped_studies()
    origin = {"study": str(study) if shipped else str(Path(study).resolve()), "shipped": shipped}
    with written_beside(folder / ORIGIN) as part:
        part.write_text(json.dumps(origin, ensure_ascii=False) + "\n", encoding="utf-8")


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


def study_folder(study: Path | str) -> Path:
    """Return what the files of a study stand beside."""
    return shipped_studies().get(str(study), Path(study)).parent


def _facts(study: Study) -> dict[str, Any]:
    language = study.languages[0]
    return {
        "name": study.name,
        "title": study.title.en or study.title.in_language(language),
        "design": study.design.model_dump()["kind"],
        "trials": study.trials,
        "stimuli": len(study.all_stimuli),
        "conditions": list(dict.fromkeys(stimulus.condition for stimulus in study.all_stimuli)),
        "simulated_stimuli": sum(stimulus.is_simulated for stimulus in study.all_stimuli),
        "practice": study.practice.trials if study.practice else 0,
        "margins": study.planned.values,
        "alpha": study.planned.alpha,
        "order": study.order,
        "seed": study.seed,
        "languages": list(study.languages),
        "display": study.display,
        "level": study.level,
        "source": study.source,
    }


def _render_all(study: Study, folder: Path) -> dict[str, str]:
    """Make and render every stimulus, and return its hash."""
    from tactogram.jobs.study_stimuli import Stimuli
    from tactogram.study.trials import Presented

    made = Stimuli(study, folder)
    hashes = {}
    for stimulus in study.made_stimuli:
        made.image(stimulus)
        if stimulus.is_played:
            hashes[stimulus.name] = made.played(Presented("", stimulus)).sha256
    return hashes


def _logger(store: SessionStore, study: Study, folder: Path) -> Callable[[Participant, Page], None]:
    from tactogram.jobs.study_stimuli import Stimuli

    stimuli = Stimuli(study, folder)

    def play(participant: Participant, page: Page) -> None:
        for presented in page.presented:
            if presented.stimulus is None or presented.stimulus.is_played:
                log_played(store, stimuli, participant.code, page, presented.slot)

    return play


def log_played(store: SessionStore, stimuli: Any, code: str, page: Page, slot: str) -> Any:
    """Render what is in a slot of a participant's page, log it, and return it (`study_stimuli.Played`)."""
    played = stimuli.played(page.slot(slot))
    store.log_played(
        code,
        page.token,
        slot,
        sha256=played.sha256,
        level=played.level,
        display=played.display,
        gain_db=played.gain_db,
    )
    return played
