"""Studies that are being taken: session folders that are open, each with its answers, stimuli and secrets."""

from __future__ import annotations

import hmac
import logging
import threading
from collections import OrderedDict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.studio.participants.playing import ServerDisplay
from tactogram.studio.participants.prepared import PreparedStimuli
from tactogram.studio.participants.tickets import FILE as KEYS
from tactogram.studio.participants.tickets import SessionKeys, keys_of
from tactogram.studio.participants.together import WriteBatcher
from tactogram.study.session.participants import UnknownParticipantError
from tactogram.study.session.progress import ParticipantState
from tactogram.study.session.store import SessionStore
from tactogram.study.study_file import Study, shipped_studies
from tactogram.study.trials import Participant
from tactogram.study.wording import Language
from tactogram.workflows.study.sessions import begin_session, origin_folder
from tactogram.workflows.study.studies import study_folder

MOST_ATTEMPTS = 1000
"""Attempts to join that are remembered, so that a double click makes one participant."""
NO_TICKET = "this link belongs to no participant; ask the experimenter for a new one"

log = logging.getLogger("tactogram.studio")


class UnknownSessionError(TactogramError):
    """No open session or participant belongs to a key, ticket or code."""


class OpenSession:
    """One session folder that is open.

    Parameters
    ----------
    folder : Path
        With ``answers.sqlite``.
    within : sequence of Path
        What the study's files must lie in; the folder that they stand beside is added.

    Raises
    ------
    TactogramError
        If it is no session. A study that cannot be shown can still be looked at: its sounds are refused.
    """

    def __init__(self, folder: Path, *, within: Iterable[Path] = ()) -> None:
        self.folder = folder
        self.store = SessionStore(folder)
        try:
            self.keys: SessionKeys = keys_of(folder)
            beside = origin_folder(folder)
            self.stimuli = PreparedStimuli(self.store.study, beside, within=[beside, *within])
        except BaseException:
            self.store.close()
            raise
        self.writes = WriteBatcher(self.store)
        self._codes: dict[bytes, str] = {}
        self._attempts: OrderedDict[str, str] = OrderedDict()
        self._joining = threading.Lock()

    @property
    def name(self) -> str:
        """The folder's."""
        return self.folder.name

    @property
    def study(self) -> Study:
        """What is taken."""
        return self.store.study

    @property
    def join_path(self) -> str:
        """The address, from the server's root, at which people join."""
        return f"/join/{self.keys.join}"

    @property
    def troubles(self) -> dict[str, str]:
        """What stimuli could not be made, by name, and why: for the experimenter."""
        return dict(self.stimuli.troubles)

    def take_path(self, code: str) -> str:
        """Return the address, from the server's root, of a participant's pages."""
        return f"/take/{self.keys.ticket(code)}"

    def code_of(self, ticket: str, *, look: bool = True) -> str | None:
        """Return whose a ticket is; None if it is nobody's here.

        Parameters
        ----------
        ticket : str
        look : bool
            Whether the file is looked at for tickets that were not seen yet; else nothing is waited for.
        """
        # Looked up by a keyed hash: how long that takes says nothing of the tickets there are.
        wanted = self._hashed(ticket)
        if look and wanted not in self._codes:
            codes = [participant.code for participant in self.store.participants()]
            self._codes = {self._hashed(self.keys.ticket(code)): code for code in codes}
        return self._codes.get(wanted)

    def join(self, attempt: str, language: Language, device: Mapping[str, Any]) -> Participant:
        """Return a new participant; for an attempt that was sent twice the same one.

        Parameters
        ----------
        attempt : str
            Drawn by the page; "" is one that is sent once.
        language : {"ja", "en"}
        device : mapping
            What the device says of itself.
        """
        if not attempt:
            return self.store.enrol(language=language, device=device)
        with self._joining:
            if attempt in self._attempts:
                return self.store.participant(self._attempts[attempt])
            participant = self._joined(attempt, language, device)
            self._attempts[attempt] = participant.code
            if len(self._attempts) > MOST_ATTEMPTS:
                self._attempts.popitem(last=False)
        return participant

    def close(self) -> None:
        """Close its file and make no more stimuli."""
        self.stimuli.end()
        self.store.close()

    def _joined(self, attempt: str, language: Language, device: Mapping[str, Any]) -> Participant:
        # The code follows from the attempt: sent again after a crash, it finds who was enrolled and answered nothing.
        taken = {participant.code.upper(): participant for participant in self.store.participants()}
        for count in range(MOST_ATTEMPTS):
            code = self.keys.code(attempt, count)
            if code not in taken:
                return self.store.enrol(code, language=language, device=device)
            page = self.store.standing(code).page
            if page is not None and page.kind == "consent" and not taken[code].simulated:
                return taken[code]
        raise DataError(f"{self.folder}: no free code was found; ask the experimenter for one")

    def _hashed(self, ticket: str) -> bytes:
        return hmac.digest(self.keys.secret, f"lookup\0{ticket}".encode(), "sha256")


class SessionRegistry:
    """The sessions that a server has open.

    Parameters
    ----------
    workspace : Path, optional
        That session folders and study files must lie in, links followed. None is anywhere: for a command line, whose
        user says which; stimuli are still confined to the study's folder.
    device : str
        What ``played_by = "server"`` plays on; see `ServerDisplay`.
    full_scale : float, optional
    """

    def __init__(
        self, workspace: Path | None = None, *, device: str = "audio", full_scale: float | None = None
    ) -> None:
        self.workspace = None if workspace is None else workspace.resolve()
        self.display = ServerDisplay(device, full_scale)
        # Replaced, never changed: whoever looks at it waits for nobody.
        self._open: dict[Path, OpenSession] = {}
        self._guard = threading.RLock()

    def begin(
        self, study: Path | str, folder: Path, *, changes: Mapping[str, Any] | None = None
    ) -> OpenSession:
        """Begin a study in a folder, or go on with it, and open it.

        Parameters
        ----------
        study : Path or str
            A TOML file, or the name of a shipped one.
        folder : Path
            New, or begun with the same study.
        changes : mapping, optional
            Values of the study, by dotted key.

        Raises
        ------
        TactogramError
            If the study is wrong or cannot be shown, the server's display cannot play it, files lie outside, or the
            folder holds another study. Nothing is written then.
        """
        folder = self._inside(folder)
        if self.workspace is not None and str(study) not in shipped_studies():
            study = self._inside(Path(study))
        loaded = Study.load(study, changes=changes)
        beside = study_folder(study).resolve()
        stimuli = PreparedStimuli(loaded, beside, within=[beside, *self._within])
        stimuli.check()
        self._check_display(stimuli)
        begin_session(study, folder, changes=changes)
        return self.open(folder)

    def open(self, folder: Path) -> OpenSession:
        """Return a session that was begun, open.

        Raises
        ------
        TactogramError
            If it is none, or lies outside of the workspace.
        """
        folder = self._inside(folder)
        with self._guard:
            if folder not in self._open:
                self._open = {**self._open, folder: OpenSession(folder, within=self._within)}
            return self._open[folder]

    def _check_display(self, stimuli: PreparedStimuli) -> None:
        if stimuli.study.played_by == "server":
            for display in stimuli.displays:
                self.display.check(display)

    def reopen(self, folders: Iterable[Path]) -> list[OpenSession]:
        """Open those of ``folders`` that were open to participants before: links go on working after a restart.

        One that cannot be opened is logged and left out.
        """
        found = []
        for folder in folders:
            if (folder / KEYS).is_file():
                try:
                    found.append(self.open(folder))
                except TactogramError as error:
                    log.warning("%s", error)
        return found

    def all(self) -> list[OpenSession]:
        """Return those that are open, in the order in which they were opened."""
        return list(self._open.values())

    def close(self) -> None:
        """Close all, and let the display rest."""
        self.display.stop_all()
        with self._guard:
            sessions, self._open = list(self._open.values()), {}
        for session in sessions:
            session.close()

    def joined_at(self, key: str) -> OpenSession:
        """Return the session that a join key opens.

        Raises
        ------
        UnknownError
            If it opens none.
        """
        for session in self.all():
            if hmac.compare_digest(session.keys.join.encode(), key.encode("utf-8", "replace")):
                return session
        raise UnknownSessionError("this link opens no study; ask the experimenter for a new one")

    def holder(self, ticket: str, *, look: bool = True) -> tuple[OpenSession, str] | None:
        """Return the session that a ticket belongs to and the code of whose it is; None if it is nobody's.

        Parameters
        ----------
        ticket : str
        look : bool
            See `OpenSession.code_of`.
        """
        for session in self.all():
            code = session.code_of(ticket, look=look)
            if code is not None:
                return session, code
        return None

    def of_ticket(self, ticket: str) -> tuple[OpenSession, ParticipantState]:
        """Return the session that a ticket belongs to, and where the participant is whose it is.

        Raises
        ------
        UnknownError
            If it is nobody's, or they withdrew.
        """
        held = self.holder(ticket)
        if held is None:
            raise UnknownSessionError(NO_TICKET)
        session, code = held
        try:
            return session, session.store.standing(code)
        except UnknownParticipantError:  # withdrawn
            raise UnknownSessionError(NO_TICKET) from None

    @property
    def _within(self) -> list[Path]:
        return [] if self.workspace is None else [self.workspace]

    def _inside(self, path: Path) -> Path:
        whole = path.resolve() if self.workspace is None else (self.workspace / path).resolve()
        if self.workspace is not None and not whole.is_relative_to(self.workspace):
            raise ParameterError(f"{str(path)[:200]}: lies outside of the workspace {self.workspace}")
        return whole
