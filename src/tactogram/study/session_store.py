"""Answers on the disk before anything else happens: one SQLite file for each study.

Write-ahead log and ``synchronous=FULL``: when `SessionStore.submit` returns, its page is on the disk, and what a kill
or a power cut leaves behind opens with it. A page is stored once, whatever is sent again. What is next follows from
what is stored, in the order of the rows' numbers; no clock decides anything.
"""

from __future__ import annotations

import json
import re
import secrets
import sqlite3
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self

from tactogram.errors import DataError, ParameterError
from tactogram.study.answers import Answer, Answers
from tactogram.study.device_facts import kept_facts
from tactogram.study.practice import practised
from tactogram.study.session_tables import STEPS, TABLES, VERSION
from tactogram.study.sitting import answers_to, declined, next_page
from tactogram.study.study_file import Study
from tactogram.study.trials import Given, Page, Participant
from tactogram.study.wording import Language

State = Literal["going", "done", "declined", "aborted"]
FILE = "answers.sqlite"
CODE = re.compile(r"(?=.*[0-9])[A-Za-z0-9]{2,16}")
"""Of a participant: letters and digits, so that BIDS takes it, and a digit at least, so that it is no name."""
LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ"
DIGITS = "23456789"
TRIES = 40
"""How often opening a file is tried that another process is making."""
AGAIN = "close what else reads it, and compact it"
WAIT_S = 30.0
"""For another writer. A write takes some ms; only a vacuum takes longer."""


@dataclass(frozen=True)
class Submitted:
    """What became of answers that were sent.

    Parameters
    ----------
    stored : bool
        False if the page was answered before; what was stored then stays.
    page : Page or None
        Next one, None at the end.
    """

    stored: bool
    page: Page | None


class SessionStore:
    """The answers to one study in a folder; safe for several threads and processes at once.

    Parameters
    ----------
    folder : Path
    study : Study, optional
        Needed for a folder that is new; else it must be the one that was begun.

    Raises
    ------
    DataError
        If the folder holds another study, or a file that is no session store.
    """

    def __init__(self, folder: Path, study: Study | None = None) -> None:
        self.path = folder / FILE
        if study is None and not self.path.is_file():
            raise DataError(f"{folder}: no study was begun here; run one, or say which folder holds it")
        folder.mkdir(parents=True, exist_ok=True)
        self._lock = threading.RLock()
        try:
            self._connection = sqlite3.connect(
                self.path, timeout=WAIT_S, isolation_level=None, check_same_thread=False
            )
            self.study = self._begun(study)
        except sqlite3.DatabaseError as error:
            raise DataError(f"{self.path}: no readable session store: {error}") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; what was stored stays."""
        with self._lock:
            self._connection.close()

    def enrol(
        self,
        code: str | None = None,
        *,
        language: Language | None = None,
        simulated: bool = False,
        session: str = "1",
        device: Mapping[str, Any] | None = None,
    ) -> Participant:
        """Return a new participant, with the lowest number that is free.

        The number of who withdrew is given again, so that the counterbalancing stays whole.

        Parameters
        ----------
        code : str, optional
            By default one is drawn.
        language : {"ja", "en"}, optional
            By default the study's first.
        simulated : bool
        session : str
        device : mapping, optional
            What the device says of itself; see `tactogram.study.device_facts`.

        Raises
        ------
        ParameterError
            If the code is taken or may be a name, the study lacks the language, or one who is simulated would stand
            among people, or the other way round.
        """
        language = language or self.study.languages[0]
        self._check_language(language)
        if code is not None:
            checked_code(code)
        if not re.fullmatch(r"[A-Za-z0-9]{1,16}", session):
            raise ParameterError(f"session must be 1 to 16 letters and digits, got {session[:40]!r}")
        self._check_going()
        with self._writing() as rows:
            self._check_kind(rows, simulated)
            taken = {row[0].casefold() for row in rows.execute("SELECT code FROM participants")}
            if code is not None and code.casefold() in taken:
                raise ParameterError(f"code {code} is taken; give another, or go on with it")
            while code is None or code.casefold() in taken:
                code = drawn_code()
            used = {row[0] for row in rows.execute("SELECT number FROM participants")}
            number = next(n for n in range(1, len(used) + 2) if n not in used)
            rows.execute(
                "INSERT INTO participants (number, code, language, simulated, session, status) VALUES (?,?,?,?,?,?)",
                (number, code, language, simulated, session, "active"),
            )
            _add_device(rows, number, "", kept_facts(device))
        return Participant(code, number, language, simulated, session)

    def participant(self, code: str) -> Participant:
        """Return who has a code, whatever the case of its letters.

        Raises
        ------
        ParameterError
            If nobody has.
        """
        with self._lock:
            row = self._connection.execute(
                "SELECT code, number, language, simulated, session FROM participants WHERE code = ? COLLATE NOCASE",
                (code,),
            ).fetchone()
        if row is None:
            raise ParameterError(f"no participant has the code {code[:40]!r}")
        return Participant(row[0], row[1], row[2], bool(row[3]), row[4])

    def page(self, code: str) -> Page | None:
        """Return what a participant is shown now; None at the end.

        Raises
        ------
        ParameterError
            If nobody has the code, or the session was ended by the experimenter.
        """
        participant = self.participant(code)
        self._check_active(participant)
        page = next_page(self.study, participant, self._given(participant))
        if page is not None:
            self._check_going()
        return page

    def submit(
        self,
        code: str,
        token: str,
        responses: Mapping[str, str],
        *,
        rt_ms: Mapping[str, float] | None = None,
        device: Mapping[str, Any] | None = None,
    ) -> Submitted:
        """Store the answers to a page; they are on the disk when this returns.

        Sent again, by a double click, the back button or a reload, it stores nothing and answers the same.

        Parameters
        ----------
        code, token : str
            Whose, and to which page.
        responses : mapping from str to str
            By the keys of the page's questions.
        rt_ms : mapping from str to float, optional
            By key; ``""`` stands for the page.
        device : mapping, optional
            What the device says of itself and of this page: ``{"px_per_mm": 6.1, "refresh_hz": 60}``. What cannot be
            kept is left out (see `tactogram.study.device_facts`); the rest stands in the rows, as ``device_px_per_mm``.

        Raises
        ------
        ParameterError
            If the page is neither the present one nor an answered one, or an answer is none. Nothing is stored then.
        """
        participant = self.participant(code)
        given = self._given(participant)
        if any(one.token == token for one in given):
            return Submitted(False, self.page(code))
        self._check_active(participant)
        page = next_page(self.study, participant, given)
        if page is None or page.token != token:
            now = "at the end" if page is None else f"at page {page.token}"
            raise ParameterError(
                f"{participant.code} is {now}, got an answer to {token[:60]!r}; reload the page"
            )
        self._check_going()
        accepted = page.accepted(responses)
        facts = kept_facts(device)
        answers = answers_to(
            self.study,
            participant,
            page,
            accepted,
            at=now_utc(),
            rt_ms=_times(rt_ms or {}, accepted),
            played=self.played(participant.code, token),
            device=facts,
        )
        new = Given(token, accepted, page.more)
        if self._store(participant, len(given) + 1, new, answers, facts):
            return Submitted(True, next_page(self.study, participant, [*given, new]))
        return Submitted(False, self.page(code))

    def log_played(
        self, code: str, token: str, slot: str, *, sha256: str, level: str, display: str, gain_db: float = 0.0
    ) -> None:
        """Note what was played, before or while it is; it is on the disk when this returns.

        Raises
        ------
        ParameterError
            If the participant is not at that page, or it has no such slot.
        """
        page = self.page(code)
        if page is None or page.token != token:
            raise ParameterError(f"{code} is not at page {token[:60]!r}; reload the page")
        page.slot(slot)
        if not re.fullmatch("[0-9a-f]{64}", sha256):
            raise ParameterError(f"sha256 must be 64 hexadecimal digits, got {sha256[:80]!r}")
        participant = self.participant(code)
        with self._writing() as rows:
            number = self._still_there(participant)
            rows.execute(
                "INSERT INTO played (participant, token, slot, sha256, level, display, gain_db, at) "
                "VALUES (?,?,?,?,?,?,?,?)",
                (number, token, slot, sha256, level, display, gain_db, now_utc()),
            )

    def played(self, code: str, token: str) -> dict[str, str]:
        """Return the hash of what was last played in each slot of a page."""
        with self._lock:
            rows = self._connection.execute(
                "SELECT slot, sha256 FROM played WHERE participant = ? AND token = ? ORDER BY id",
                (self.participant(code).number, token),
            ).fetchall()
        return dict(rows)

    def played_log(self, code: str) -> list[dict[str, Any]]:
        """Return all that was played to a participant: ``token``, ``slot``, ``sha256``, ``level`` … ``at``."""
        names = ("token", "slot", "sha256", "level", "display", "gain_db", "at")
        with self._lock:
            rows = self._connection.execute(
                f"SELECT {', '.join(names)} FROM played WHERE participant = ? ORDER BY id",
                (self.participant(code).number,),
            ).fetchall()
        return [dict(zip(names, row, strict=True)) for row in rows]

    def note_device(self, code: str, device: Mapping[str, Any]) -> None:
        """Keep what a device says of itself as a participant begins or goes on with it."""
        participant = self.participant(code)
        with self._writing() as rows:
            _add_device(rows, self._still_there(participant), "", kept_facts(device))

    def device_log(self, code: str) -> list[dict[str, Any]]:
        """Return what devices said: ``token`` ("" as the participant began or went on), ``facts``, ``at``."""
        with self._lock:
            rows = self._connection.execute(
                "SELECT token, facts, at FROM device WHERE participant = ? ORDER BY id",
                (self.participant(code).number,),
            ).fetchall()
        return [{"token": token, "facts": json.loads(facts), "at": at} for token, facts, at in rows]

    def device(self, code: str) -> dict[str, Any]:
        """Return the last word on each fact of a participant's device."""
        return {name: fact for one in self.device_log(code) for name, fact in one["facts"].items()}

    def set_language(self, code: str, language: Language) -> None:
        """Change the language of a participant's pages.

        Raises
        ------
        ParameterError
            If the study lacks the language, or nobody has the code.
        """
        self._check_language(language)
        number = self.participant(code).number
        with self._writing() as rows:
            rows.execute("UPDATE participants SET language = ? WHERE number = ?", (language, number))

    def note(self, text: str, *, code: str | None = None) -> None:
        """Write down what the experimenter saw, about one participant or the whole.

        Raises
        ------
        ParameterError
            If it is empty or longer than 4,000 characters, or nobody has the code.
        """
        if not 0 < len(text.strip()) <= 4000:
            raise ParameterError(f"a note must have 1 to 4000 characters, got {len(text.strip())}")
        number = None if code is None else self.participant(code).number
        with self._writing() as rows:
            rows.execute(
                "INSERT INTO notes (participant, text, at) VALUES (?,?,?)", (number, text.strip(), now_utc())
            )

    def notes(self) -> list[dict[str, Any]]:
        """Return all notes, first ones first: ``participant`` (None is the whole study), ``text``, ``at``."""
        with self._lock:
            rows = self._connection.execute(
                "SELECT code, text, at FROM notes LEFT JOIN participants ON number = participant ORDER BY id"
            ).fetchall()
        return [{"participant": code, "text": text, "at": at} for code, text, at in rows]

    @property
    def ended(self) -> str | None:
        """When the experimenter ended the study, by the clock of then; None while it goes on."""
        with self._lock:
            row = self._connection.execute("SELECT ended FROM study").fetchone()
        return None if row[0] is None else str(row[0])

    def end(self) -> None:
        """End the study: nobody joins, and who has not finished does not go on. What was answered stays."""
        with self._writing() as rows:
            rows.execute("UPDATE study SET ended = ? WHERE ended IS NULL", (now_utc(),))

    def go_on(self) -> None:
        """Let a study go on that was ended."""
        with self._writing() as rows:
            rows.execute("UPDATE study SET ended = NULL")

    def abort(self, code: str) -> None:
        """End a participant's session now; what was answered stays."""
        self._set_status(code, "aborted")

    def reopen(self, code: str) -> None:
        """Let a participant go on whose session was aborted."""
        self._set_status(code, "active")

    def withdraw(self, code: str) -> int:
        """Delete a participant and everything that is kept of them, and return how many answers that were.

        The space is overwritten (``secure_delete``), the file is written anew and its log emptied. What was exported
        before is out of reach: it is to be exported again.
        """
        participant = self.participant(code)
        with self._writing() as rows:
            found = rows.execute(
                "SELECT count(*) FROM answers WHERE participant = ?", (participant.number,)
            ).fetchone()[0]
            for table in ("answers", "pages", "played", "notes", "device"):
                rows.execute(f"DELETE FROM {table} WHERE participant = ?", (participant.number,))
            rows.execute("DELETE FROM participants WHERE number = ?", (participant.number,))
            rows.execute("UPDATE study SET withdrawn = withdrawn + 1")
        self.compact()
        return int(found)

    def compact(self) -> None:
        """Write the file anew without what was deleted, and empty its log.

        Raises
        ------
        DataError
            If another process reads it all the while; what was deleted is deleted, and may stand in the log.
        """
        with self._lock:
            try:
                self._connection.execute("VACUUM")
                busy = self._connection.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()[0]
            except sqlite3.OperationalError as error:
                raise DataError(f"{self.path}: deleted, but not written anew: {error}; {AGAIN}") from error
            if busy:
                raise DataError(f"{self.path}: deleted, but its log could not be emptied; {AGAIN}")

    @property
    def withdrawn(self) -> int:
        """How many withdrew."""
        with self._lock:
            return int(self._connection.execute("SELECT withdrawn FROM study").fetchone()[0])

    def participants(self) -> list[Participant]:
        """Return all participants by number."""
        with self._lock:
            rows = self._connection.execute(
                "SELECT code, number, language, simulated, session FROM participants ORDER BY number"
            ).fetchall()
        return [Participant(row[0], row[1], row[2], bool(row[3]), row[4]) for row in rows]

    def state(self, code: str) -> State:
        """Return whether a participant is going on, done, did not agree to take part, or was aborted.

        Raises
        ------
        ParameterError
            If nobody has the code.
        """
        participant = self.participant(code)
        if self._status(participant) != "active":
            return "aborted"
        given = self._given(participant)
        if next_page(self.study, participant, given) is not None:
            return "aborted" if self.ended else "going"
        return "declined" if declined(given) else "done"

    def progress(self) -> list[dict[str, Any]]:
        """Return where each participant stands, for the experimenter.

        Code, number, status, trials done and in all, practice trials begun, and when the last answer came.
        """
        found = []
        for participant in self.participants():
            given = self._given(participant)
            status = self._status(participant)
            page = next_page(self.study, participant, given)
            if status == "active" and page is None:
                status = "declined" if declined(given) else "finished"
            trials = {one.token.partition(".")[0] for one in given if one.token.startswith("trial-")}
            finished_all = page is None or page.step == 1
            found.append(
                {
                    "participant": participant.code,
                    "number": participant.number,
                    "simulated": participant.simulated,
                    "language": participant.language,
                    "status": status,
                    "page": None if page is None else page.token,
                    "trials": len(trials) - (0 if finished_all else 1),
                    "of": self.study.trials,
                    "practice": len({one.token.partition(".")[0] for one in practised(given)}),
                    "last": self._last(participant),
                }
            )
        return found

    def answers(self) -> Answers:
        """Return every answer, by participant and in the order given."""
        with self._lock:
            rows = self._connection.execute(
                "SELECT row FROM answers ORDER BY participant, position, place"
            ).fetchall()
        return Answers(tuple(_answer(json.loads(row[0])) for row in rows))

    def latest(self, count: int) -> tuple[Answer, ...]:
        """Return the last answers of all participants, newest first; by the order in which they came, not the clock."""
        with self._lock:
            rows = self._connection.execute(
                "SELECT row FROM answers ORDER BY rowid DESC LIMIT ?", (count,)
            ).fetchall()
        return tuple(_answer(json.loads(row[0])) for row in rows)

    @property
    def count(self) -> int:
        """How many answers there are."""
        with self._lock:
            return int(self._connection.execute("SELECT count(*) FROM answers").fetchone()[0])

    def _begun(self, study: Study | None) -> Study:
        connection = self._connection
        self._use_log()
        connection.execute("PRAGMA synchronous=FULL")
        connection.execute("PRAGMA secure_delete=ON")
        connection.execute("PRAGMA foreign_keys=ON")
        with self._writing() as rows:
            version = rows.execute("PRAGMA user_version").fetchone()[0]
            if not 0 <= version <= VERSION:
                raise DataError(
                    f"{self.path}: is of version {version}, this program knows versions up to {VERSION}; "
                    "open it with the program that made it"
                )
            if version == 0:
                if study is None:
                    raise DataError(f"{self.path}: holds no study")
                for table in TABLES:
                    rows.execute(table)
                rows.execute(
                    "INSERT INTO study (id, facts, begun) VALUES (1,?,?)", (study.as_json(), now_utc())
                )
            else:
                for older in range(version, VERSION):
                    for step in STEPS[older]:
                        rows.execute(step)
            rows.execute(f"PRAGMA user_version = {VERSION}")
            [facts] = rows.execute("SELECT facts FROM study").fetchone()
        begun = Study.of(json.loads(facts), where=str(self.path))
        if study is not None and study.sha256 != begun.sha256:
            raise DataError(
                f"{self.path.parent}: was begun with another {begun.name} than this {study.name} (they differ in "
                f"{begun.differing(study)}); give another folder, or the file as it was"
            )
        return begun

    def _use_log(self) -> None:
        """Switch to the write-ahead log; another process may be doing the same to a new file."""
        for attempt in range(TRIES):
            try:
                self._connection.execute("PRAGMA journal_mode=WAL")
            except sqlite3.OperationalError:
                if attempt == TRIES - 1:
                    raise
                time.sleep(0.05)
            else:
                return

    @contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        """Give the connection in a transaction that no other writer is in."""
        with self._lock:
            try:
                self._connection.execute("BEGIN IMMEDIATE")
                try:
                    yield self._connection
                except BaseException:
                    # A full disk has rolled it back already.
                    if self._connection.in_transaction:
                        self._connection.execute("ROLLBACK")
                    raise
                self._connection.execute("COMMIT")
            except sqlite3.OperationalError as error:
                # A full disk, a file that went away, another writer that never ends.
                if self._connection.in_transaction:
                    self._connection.execute("ROLLBACK")
                raise DataError(f"{self.path}: nothing was stored: {error}") from error

    def _given(self, participant: Participant) -> list[Given]:
        with self._lock:
            rows = self._connection.execute(
                "SELECT token, responses, facts FROM pages WHERE participant = ? ORDER BY position",
                (participant.number,),
            ).fetchall()
        return [Given(token, json.loads(responses), json.loads(facts)) for token, responses, facts in rows]

    def _store(
        self,
        participant: Participant,
        position: int,
        given: Given,
        answers: Sequence[Answer],
        device: Mapping[str, Any],
    ) -> bool:
        """Store a page and its rows; return False if another got there first."""
        number = participant.number
        with self._writing() as rows:
            self._still_there(participant)
            there = rows.execute(
                "SELECT 1 FROM pages WHERE participant = ? AND position = ?", (number, position)
            )
            if there.fetchone():
                return False
            text = json.dumps(given.responses, ensure_ascii=False)
            facts = json.dumps(given.facts, ensure_ascii=False)
            rows.execute(
                "INSERT INTO pages (participant, position, token, responses, facts) VALUES (?,?,?,?,?)",
                (number, position, given.token, text, facts),
            )
            rows.executemany(
                "INSERT INTO answers (participant, position, place, row) VALUES (?,?,?,?)",
                [(number, position, place, json.dumps(asdict(row))) for place, row in enumerate(answers)],
            )
            _add_device(rows, number, given.token, device)
        return True

    def _still_there(self, participant: Participant) -> int:
        """Return a participant's number, or refuse: meanwhile they may have withdrawn, and another have the number."""
        row = self._connection.execute(
            "SELECT code, status FROM participants WHERE number = ?", (participant.number,)
        ).fetchone()
        if row is None or row[0] != participant.code:
            raise ParameterError(f"no participant has the code {participant.code!r}")
        if row[1] != "active":
            raise ParameterError(f"the session of {participant.code} was ended by the experimenter")
        return participant.number

    def _last(self, participant: Participant) -> str | None:
        """Return when the last answer came, by the clock of then; None if none has."""
        with self._lock:
            row = self._connection.execute(
                "SELECT row FROM answers WHERE participant = ? ORDER BY position DESC LIMIT 1",
                (participant.number,),
            ).fetchone()
        return None if row is None else str(json.loads(row[0])["at"])

    def _check_language(self, language: str) -> None:
        if language not in self.study.languages:
            known = ", ".join(self.study.languages)
            raise ParameterError(f"language must be one of {known}, got {language[:20]!r}")

    def _status(self, participant: Participant) -> str:
        with self._lock:
            row = self._connection.execute(
                "SELECT status FROM participants WHERE number = ?", (participant.number,)
            ).fetchone()
        return str(row[0]) if row else "withdrawn"

    def _check_going(self) -> None:
        if self.ended is not None:
            raise ParameterError("the study was ended by the experimenter")

    def _check_kind(self, rows: sqlite3.Connection, simulated: bool) -> None:
        """Refuse a mixture: answers of people and of simulated participants are never analysed together."""
        if rows.execute("SELECT 1 FROM participants WHERE simulated != ?", (simulated,)).fetchone():
            there, other = (
                ("people", "simulated participants") if simulated else ("simulated participants", "people")
            )
            raise ParameterError(f"{there} take this study here; {other} need a session folder of their own")

    def _check_active(self, participant: Participant) -> None:
        if self._status(participant) != "active":
            raise ParameterError(f"the session of {participant.code} was ended by the experimenter")

    def _set_status(self, code: str, status: str) -> None:
        number = self.participant(code).number
        with self._writing() as rows:
            rows.execute("UPDATE participants SET status = ? WHERE number = ?", (status, number))


def checked_code(code: str) -> str:
    """Return a code if it may be one.

    Raises
    ------
    ParameterError
        If it may be a name, or is too short or long.
    """
    if not CODE.fullmatch(code):
        raise ParameterError(
            f"code must be 2 to 16 letters and digits with a digit among them, never a name, got {code[:40]!r}"
        )
    return code


def drawn_code() -> str:
    """Return a code that is easily read and typed and hard to guess: three times a letter and a digit."""
    return "".join(secrets.choice(LETTERS) + secrets.choice(DIGITS) for _ in range(3))


def now_utc() -> str:
    """Return the time as the store writes it; it orders nothing."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _times(rt_ms: Mapping[str, float], accepted: Mapping[str, str]) -> dict[str, float]:
    """Return the times that can be: what a broken or changed clock made of the others is left out."""
    known = {key: value for key, value in rt_ms.items() if key == "" or key in accepted}
    return {key: float(value) for key, value in known.items() if 0 <= value < 86_400_000}


def _add_device(rows: sqlite3.Connection, number: int, token: str, facts: Mapping[str, Any]) -> None:
    if facts:
        rows.execute(
            "INSERT INTO device (participant, token, facts, at) VALUES (?,?,?,?)",
            (number, token, json.dumps(facts, ensure_ascii=False), now_utc()),
        )


def _answer(values: dict[str, Any]) -> Answer:
    return Answer(**values)
