"""Open sessions: session folders that participants can reach, each with its answers, stimuli and secrets."""

from __future__ import annotations

import hmac
import logging
import shutil
import tempfile
import threading
from collections import OrderedDict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from anyio import CapacityLimiter

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram_study.participants.prepared_stimuli import PreparedStimuli
from tactogram_study.participants.server_display import ServerDisplay
from tactogram_study.participants.tickets import FILE as KEYS, SessionKeys, load_keys
from tactogram_study.session.participants import UnknownParticipantError
from tactogram_study.session.progress import ParticipantState
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import Study, shipped_studies
from tactogram_study.trials import Participant
from tactogram_study.wording import Language
from tactogram_study.workflows.sessions import begin_session, begin_trials, keep_origin, origin_folder
from tactogram_study.workflows.studies import study_folder

MOST_ATTEMPTS = 1000
"""Attempts to join that are remembered, so that a double click makes one participant."""
MOST_PREVIEWS = 4
MOST_MAKING = 8
"""Requests for a stimulus at a time."""
PREVIEW = "PREVIEW1"
"""Code of the participant of a preview."""
NO_TICKET = "this link does not belong to any participant; ask the experimenter for a new one"

log = logging.getLogger("tactogram_studio")


class UnknownSessionError(TactogramError):
    """No open session or participant belongs to a key, ticket or code."""


class OpenSession:
    """One open session folder, with ``answers.sqlite`` in it; `TactogramError` if it holds no session.

    The study's files may lie in its own folder and those ``within``. A study whose stimuli cannot be played opens, too:
    its answers can be read, its sounds are refused.
    """

    def __init__(self, folder: Path, *, within: Iterable[Path] = ()) -> None:
        self.folder = folder
        self.store = SessionStore(folder)
        try:
            self.keys: SessionKeys = load_keys(folder)
            origin = origin_folder(folder)
            self.stimuli = PreparedStimuli(self.store.study, origin, within=[origin, *within])
        except BaseException:
            self.store.close()
            raise
        self.store.is_simulated, self.store.limited = self.stimuli.is_simulated, self.stimuli.limited
        # A thread of its own: answers are stored even while all others are busy.
        self.writing = CapacityLimiter(1)
        self.guessing = CapacityLimiter(1)
        self._codes: dict[bytes, str] = {}
        self._attempts: OrderedDict[str, str] = OrderedDict()
        self._joining = threading.Lock()

    @property
    def name(self) -> str:
        """Name of the folder."""
        return self.folder.name

    @property
    def study(self) -> Study:
        """The study that participants take."""
        return self.store.study

    @property
    def join_path(self) -> str:
        """Path of the join page, from the server's root."""
        return f"/join/{self.keys.join}"

    @property
    def failures(self) -> dict[str, str]:
        """Why a stimulus could not be made, by name: for the experimenter."""
        return dict(self.stimuli.failures)

    def take_path(self, code: str) -> str:
        """Return the path of a participant's pages, from the server's root."""
        return f"/take/{self.keys.ticket(code)}"

    def code_of(self, ticket: str, *, cached: bool = False) -> str | None:
        """Return the code that a ticket belongs to, or None; with ``cached``, without reading the session's file."""
        # A keyed hash as the key: the time of a look-up reveals nothing about the tickets that exist.
        hashed = self._hashed(ticket)
        if not cached and hashed not in self._codes:
            codes = [participant.code for participant in self.store.participants()]
            self._codes = {self._hashed(self.keys.ticket(code)): code for code in codes}
        return self._codes.get(hashed)

    def join(self, attempt: str, language: Language, device: Mapping[str, Any]) -> Participant:
        """Return a new participant, or the one that the same ``attempt`` made; an empty one makes a new one."""
        if not attempt:
            return self.store.enrol(language=language, device=device)
        with self._joining:
            if attempt in self._attempts:
                return self.store.participant(self._attempts[attempt])
            participant = self._enrolled(attempt, language, device)
            self._attempts[attempt] = participant.code
            if len(self._attempts) > MOST_ATTEMPTS:
                self._attempts.popitem(last=False)
        return participant

    def close(self) -> None:
        """Close the session's file and stop preparing stimuli."""
        self.stimuli.stop()
        self.store.close()

    def _enrolled(self, attempt: str, language: Language, device: Mapping[str, Any]) -> Participant:
        # The code follows from the attempt: sent again after a crash, it leads to the participant who was enrolled and
        # has not answered anything.
        taken = {participant.code.upper(): participant for participant in self.store.participants()}
        for count in range(MOST_ATTEMPTS):
            code = self.keys.code(attempt, count)
            if code not in taken:
                return self.store.enrol(code, language=language, device=device)
            page = self.store.participant_state(code).page
            if page is not None and page.kind == "consent" and not taken[code].simulated:
                return taken[code]
        raise DataError(self.folder, "no free participant code; ask the experimenter for one")

    def _hashed(self, ticket: str) -> bytes:
        return hmac.digest(self.keys.secret, f"lookup\0{ticket}".encode(), "sha256")


class SessionRegistry:
    """The open sessions of a server.

    Session folders and study files must lie in the ``workspace``, symbolic links followed. None allows any folder, for
    the command line; stimuli are still confined to the study's folder. ``device`` and ``full_scale`` are those of
    `ServerDisplay`.
    """

    def __init__(
        self, workspace: Path | None = None, *, device: str = "audio", full_scale: float | None = None
    ) -> None:
        self.workspace = None if workspace is None else workspace.resolve()
        self.display = ServerDisplay(device, full_scale)
        # Few of the server's threads: whoever waits for a stimulus holds up nobody else's page.
        self.making = CapacityLimiter(MOST_MAKING)
        # Replaced, never changed: readers need no lock.
        self._open: dict[Path, OpenSession] = {}
        self._previews: list[Path] = []
        self._guard = threading.RLock()

    def begin(
        self, study: Path | str, folder: Path, *, changes: Mapping[str, Any] | None = None
    ) -> OpenSession:
        """Begin a study (a file or a shipped name) in a folder, or continue it, and open it.

        Raises `TactogramError` if the study is invalid or cannot be played, the server's display cannot play it, files
        lie outside of the workspace, or the folder holds another study. Nothing is written then.
        """
        folder = self._inside(folder)
        if self.workspace is not None and str(study) not in shipped_studies():
            study = self._inside(Path(study))
        loaded = Study.load(study, changes=changes)
        files = study_folder(study).resolve()
        stimuli = PreparedStimuli(loaded, files, within=[files, *self._within])
        stimuli.check_places()
        if loaded.played_by != "browser":
            for display in stimuli.displays:
                self.display.check(display, streams=loaded.played_by == "stream")
        begin_session(study, folder, changes=changes)
        return self.open(folder)

    def open(self, folder: Path) -> OpenSession:
        """Open a session that was begun; `TactogramError` if there is none, or outside of the workspace."""
        folder = self._inside(folder)
        with self._guard:
            if folder not in self._open:
                self._open = {**self._open, folder: OpenSession(folder, within=self._within)}
            return self._open[folder]

    def preview(self, study: Study, file: Path) -> str:
        """Open a study at its first trial, for its author, and return the path of that page.

        Its answers are in a temporary folder, which is deleted with the server, or after `MOST_PREVIEWS` more. Paths of
        the study are relative to its ``file``.
        """
        file = self._inside(file)
        folder = Path(tempfile.mkdtemp(prefix="tactogram-preview-"))
        try:
            with SessionStore(folder, study) as store:
                keep_origin(folder, file)
                begin_trials(store, store.enrol(PREVIEW, language=study.languages[0]).code)
            session = OpenSession(folder, within=self._within)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        with self._guard:
            self._open = {**self._open, folder: session}
            self._previews.append(folder)
            while len(self._previews) > MOST_PREVIEWS:
                self._close_preview(self._previews.pop(0))
        return f"{session.take_path(PREVIEW)}?preview"

    def reopen(self, folders: Iterable[Path]) -> list[OpenSession]:
        """Open the sessions that participants could reach before a restart, so that their links go on working.

        Sessions that cannot be opened are logged and skipped.
        """
        opened = []
        for folder in folders:
            if (folder / KEYS).is_file():
                try:
                    opened.append(self.open(folder))
                except TactogramError as error:
                    log.warning("%s", error)
        return opened

    def close(self) -> None:
        """Close all sessions and stop the display."""
        self.display.stop_all()
        with self._guard:
            sessions, self._open = list(self._open.values()), {}
        for session in sessions:
            session.close()
        for folder in self._previews:
            shutil.rmtree(folder, ignore_errors=True)

    def _close_preview(self, folder: Path) -> None:
        session = self._open[folder]
        self._open = {path: opened for path, opened in self._open.items() if path != folder}
        session.close()
        shutil.rmtree(folder, ignore_errors=True)

    def by_join_key(self, key: str) -> OpenSession:
        """Return the session that a join key opens, or raise `UnknownSessionError`."""
        for session in self._open.values():
            if hmac.compare_digest(session.keys.join.encode(), key.encode("utf-8", "replace")):
                return session
        raise UnknownSessionError("this link does not open a study; ask the experimenter for a new one")

    def by_ticket(self, ticket: str, *, cached: bool = False) -> tuple[OpenSession, str] | None:
        """Return the session and the code that a ticket belongs to, or None; ``cached`` as of `OpenSession.code_of`."""
        for session in self._open.values():
            code = session.code_of(ticket, cached=cached)
            if code is not None:
                return session, code
        return None

    def state_of(self, ticket: str) -> tuple[OpenSession, ParticipantState]:
        """Return the session and the state of a ticket's participant; `UnknownSessionError` if there is none."""
        entry = self.by_ticket(ticket)
        if entry is None:
            raise UnknownSessionError(NO_TICKET)
        session, code = entry
        try:
            return session, session.store.participant_state(code)
        except UnknownParticipantError:  # withdrawn
            raise UnknownSessionError(NO_TICKET) from None

    @property
    def _within(self) -> list[Path]:
        return [] if self.workspace is None else [self.workspace]

    def _inside(self, path: Path) -> Path:
        whole = path.resolve() if self.workspace is None else (self.workspace / path).resolve()
        if self.workspace is not None and not whole.is_relative_to(self.workspace):
            raise ParameterError(f"{str(path)[:200]}: lies outside of the workspace")
        return whole
