"""Journal of a session: one line of JSON per event, on the disk before the session continues.

Accepted takes are in the store, which is authoritative; the journal records their order, redone and skipped takes,
check results and raw logs. An incomplete last line, as after a crash, is dropped: its event did not
happen, or is in the store.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self, TextIO

from tactogram.errors import DataError
from tactogram.signal.io import lock
from tactogram.text_files import parse_json

FILE = "session.jsonl"


class Journal:
    """The journal in ``folder``, which is created; a context manager that locks the session."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.path = folder, folder / FILE
        self.events: list[dict[str, Any]] = []
        """Of all runs; each has ``event`` and ``time`` (UTC)."""
        self._file: TextIO | None = None

    def __enter__(self) -> Self:
        """Open and read it; `DataError` if another process uses it, or a line other than the last is damaged."""
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
            raise DataError(self.folder, "another process uses this session; end it first")
        self._file = file
        return self

    def __exit__(self, *_: object) -> None:
        """Close it and release the lock; remove the journal of a session that never began."""
        if self._file is None:
            return
        if not self.events:
            self.path.unlink(missing_ok=True)
            for folder in (self.folder, self.folder.parent):
                # A folder with other files remains.
                with suppress(OSError):
                    folder.rmdir()
        self._file.close()
        self._file = None

    def write(self, event: str, facts: Mapping[str, Any] | None = None) -> None:
        """Add an event; it is on the disk when this returns.

        Raises `OSError` if the disk is full; the event is then removed.
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
                raise DataError(self.path, f"line {number} must be an event, got {line[:60]!r}")
            events.append(entry)
        return events
