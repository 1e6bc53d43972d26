"""The diary of a session: one line of JSON per event, on the disk before the session goes on.

What was *accepted* stands in the store, which is the truth; the diary says in which order it was to be, what was
redone, skipped and found, and which raw log holds it. A kill may cut its last line short: that line is dropped, as what
it would have said did not come to be, or stands in the store.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TextIO

from tactogram.errors import DataError
from tactogram.signal.io.locks import lock
from tactogram.text_files import parse_json

FILE = "session.jsonl"


class Journal:
    """The diary in ``folder``; a context manager that keeps other processes from the same session.

    Parameters
    ----------
    folder : Path
        Made if it is not there.

    Attributes
    ----------
    events : list of dict
        All that was written, those of earlier runs too. Each has ``event`` and ``time`` (UTC).
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.path = folder, folder / FILE
        self.events: list[dict[str, Any]] = []
        self._file: TextIO | None = None

    def __enter__(self) -> Self:
        """Open it, and read what is there.

        Raises
        ------
        DataError
            If another process is at this session, or a line that is not the last is broken.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        file = self.path.open("a+", encoding="utf-8")
        try:
            free = lock(file.fileno())
            self.events = self._read(file) if free else []
        except BaseException:
            file.close()
            raise
        if not free:
            file.close()
            raise DataError(f"{self.folder}: another process is at this session; end it first")
        self._file = file
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it, and let others at the session; of a session that never began nothing stays."""
        if self._file is None:
            return
        if not self.events:
            self.path.unlink(missing_ok=True)
            for folder in (self.folder, self.folder.parent):
                # What else lies there keeps its folder.
                with suppress(OSError):
                    folder.rmdir()
        self._file.close()
        self._file = None

    def write(self, event: str, facts: Mapping[str, Any] | None = None) -> None:
        """Add one event; it is on the disk when this returns.

        Raises
        ------
        OSError
            If the disk is full; nothing of the event stays then.
        """
        if self._file is None:
            raise DataError(f"{self.path} is not open")
        entry = {
            "event": event,
            "time": datetime.now(UTC).isoformat(timespec="milliseconds"),
            **(facts or {}),
        }
        line = (json.dumps(entry, ensure_ascii=False) + "\n").encode()
        opened = self._file.fileno()
        end = os.fstat(opened).st_size
        try:
            written = 0
            while written < len(line):
                written += os.write(opened, line[written:])
            os.fsync(opened)
        except OSError:
            os.ftruncate(opened, end)
            raise
        self.events.append(entry)

    def of(self, event: str) -> list[dict[str, Any]]:
        """Return the events of one kind, in order."""
        return [entry for entry in self.events if entry["event"] == event]

    def _read(self, file: TextIO) -> list[dict[str, Any]]:
        file.seek(0)
        text = file.read()
        whole = text[: text.rfind("\n") + 1]
        if whole != text:
            os.ftruncate(file.fileno(), len(whole.encode()))
        events = []
        for number, line in enumerate(whole.splitlines(), 1):
            entry = parse_json(line, f"{self.path}: line {number}")
            if not isinstance(entry, dict) or "event" not in entry:
                raise DataError(f"{self.path}: line {number} must be an event, got {line[:60]!r}")
            events.append(entry)
        return events
