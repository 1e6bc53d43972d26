"""Speaker: drives played on a connected device, one at a time, with a log."""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.rendering import Display
from tactogram.signal import Signal
from tactogram.text_files import parse_json, read_text
from tactogram_playback import Playback

LOG = "played.jsonl"


class Speaker:
    """Plays drives, one at a time, and logs them in ``folder``."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.playing: Playback | None = None
        self.title = ""
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()

    @property
    def busy(self) -> bool:
        """Whether a drive is playing."""
        return self._thread is not None and self._thread.is_alive()

    def play(self, drive: Signal, display: Display, *, title: str, **options: Any) -> None:
        """Start to play; ``options`` as for `Playback`. `ParameterError` while another drive is playing."""
        with self._lock:
            if self.busy:
                raise ParameterError("something is playing; stop it first")
            playing = Playback(drive, display, **options)
            self.playing, self.title = playing, title
            self._thread = threading.Thread(
                target=self._run, args=(playing, title), name="speaker", daemon=True
            )
            self._thread.start()

    def stop(self) -> None:
        """Fade out and wait for the end."""
        playing, thread = self.playing, self._thread
        if playing is not None and thread is not None:
            playing.stop()
            thread.join(3.0)

    def _run(self, playing: Playback, title: str) -> None:
        try:
            playing.run()
        except TactogramError:
            pass  # the facts hold the error
        finally:
            log_played(self.folder, {"title": title, **playing.facts()})


def log_played(folder: Path, facts: Mapping[str, Any]) -> None:
    """Add a line to the log: drive by hash, strength and device."""
    folder.mkdir(parents=True, exist_ok=True)
    line = json.dumps({"time": datetime.now(UTC).isoformat(timespec="seconds"), **facts}, ensure_ascii=False)
    with (folder / LOG).open("a", encoding="utf-8") as file:
        file.write(line + "\n")


def recently_played(folder: Path, count: int = 5) -> list[dict[str, Any]]:
    """Return the last readable lines of the log, newest first."""
    try:
        lines = read_text(folder / LOG).splitlines()
    except DataError:
        return []
    entries = []
    for line in reversed(lines[-4 * count :]):
        try:
            entries.append(parse_json(line, LOG))
        except DataError:  # cut short by a kill
            continue
    return entries[:count]
