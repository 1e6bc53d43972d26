"""Playback of drives by the studio: one at a time, stopped with a fade, logged."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError, TactogramError
from tactogram.rendering.displays.display import Display
from tactogram.signal import Signal
from tactogram.studio.pages.send.played_log import log_played
from tactogram.workflows.rendering.playback import Playback


class Speaker:
    """Plays drives, one at a time.

    Parameters
    ----------
    folder : Path
        For the log.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.playing: Playback | None = None
        self.title = ""
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()

    @property
    def busy(self) -> bool:
        """Whether something is being played."""
        return self._thread is not None and self._thread.is_alive()

    def play(self, drive: Signal, display: Display, *, title: str, **options: Any) -> None:
        """Begin to play; ``options`` as of `Playback`.

        Raises
        ------
        ParameterError
            If something plays, or it cannot be played there.
        """
        with self._lock:
            if self.busy:
                raise ParameterError("something is being played: stop it first")
            playing = Playback(drive, display, **options)
            self.playing, self.title = playing, title
            self._thread = threading.Thread(
                target=self._run, args=(playing, title), name="speaker", daemon=True
            )
            self._thread.start()

    def stop(self) -> None:
        """Fade out, and wait for it."""
        playing, thread = self.playing, self._thread
        if playing is not None and thread is not None:
            playing.stop()
            thread.join(3.0)

    def _run(self, playing: Playback, title: str) -> None:
        try:
            playing.run()
        except TactogramError:
            pass  # stands in the facts
        finally:
            log_played(self.folder, {"title": title, **playing.facts()})
