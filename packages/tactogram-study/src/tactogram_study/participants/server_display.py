"""The server's display: plays one stimulus at a time; only the participant who started it can stop it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Protocol

import tactogram_playback as playback
from tactogram.errors import ParameterError, TactogramError
from tactogram.rendering import Display, carrier_of
from tactogram.signal import Signal
from tactogram_study.workflows.streams import FingerStream

PATIENCE_S = 2.0
"""How long a participant's previous stimulus may take to fade out before the next."""


class DisplayInUseError(TactogramError):
    """The display is playing to another participant."""


class _Stoppable(Protocol):
    def stop(self) -> object: ...


@dataclass
class ServerDisplay:
    """The one display of a server.

    ``device`` is ``audio``, ``audio:NAME``, or ``null`` (no actuator connected, same timing); for streams also
    ``digilent`` or ``osc:HOST:PORT``. ``full_scale`` as of `tactogram_playback.full_scale_of`. With ``track`` the
    carrier of a Digilent follows the transducer's resonance (`tactogram_playback.CarrierTracking`).
    """

    device: str = "audio"
    full_scale: float | None = None
    track: Mapping[str, Any] | None = None
    _trackings: dict[str, playback.CarrierTracking] = field(default_factory=dict, repr=False)
    _turn: threading.Lock = field(default_factory=threading.Lock, repr=False)
    _guard: threading.Lock = field(default_factory=threading.Lock, repr=False)
    _owner: str = field(default="", repr=False)
    _playing: _Stoppable | None = field(default=None, repr=False)

    def check(self, display: Display, *, streams: bool = False) -> None:
        """Refuse a display that the device cannot drive, by a file or by a stream: `ParameterError`."""
        if streams:
            self._backend(display)
            return
        playback.full_scale_of(display, self.device.partition(":")[0], self.full_scale)

    def play(self, owner: str, drive: Signal, display: Display) -> dict[str, Any]:
        """Play a drive to its end and return `Playback.facts`; stops the owner's previous one first.

        Raises
        ------
        DisplayInUseError
            While it plays to another participant.
        TactogramError
            If the drive cannot be played, or the device does not respond.
        """
        playing = playback.Playback(
            drive, display, device=self.device, strength=1.0, full_scale=self.full_scale
        )
        with self._taken(owner, playing):
            return playing.run()

    def stream(
        self, owner: str, streaming: FingerStream, *, began: Callable[[], None] = lambda: None
    ) -> dict[str, Any]:
        """Stream until it is stopped and return `FingerStream.run`'s facts; errors are those of `play`."""
        output = streaming.stream.output
        if output is None:
            raise ParameterError("a stream to a display needs one")
        backend = self._backend(output.display)
        with self._taken(owner, streaming):
            return {"device_address": self.device, **streaming.run(backend, began=began)}

    def lock(self, display: Display) -> None:
        """Find the resonance before anybody touches the display, if it is tracked.

        Raises `TactogramError` if there is none, or a device is missing.
        """
        tracking = self._backend(display).tracking
        if tracking is not None:
            with tracking.generator():
                pass

    def _backend(self, display: Display) -> playback.Backend:
        tracking = None
        if self.track is not None:
            kind, _, serial = self.device.partition(":")
            if kind != "digilent":
                raise ParameterError(f"the carrier of a Digilent is tracked, got the device {self.device}")
            if display.name not in self._trackings:
                self._trackings[display.name] = playback.CarrierTracking(
                    carrier_of(display), self.track, serial=serial
                )
            tracking = self._trackings[display.name]
        return playback.Backend.for_display(
            self.device, display, full_scale=self.full_scale, tracking=tracking
        )

    @contextmanager
    def _taken(self, owner: str, playing: _Stoppable) -> Iterator[None]:
        """Stop the owner's previous stimulus, and hold the display for this one."""
        with self._guard:
            if self._playing is not None:
                if self._owner != owner:
                    raise DisplayInUseError(
                        "the display is playing to another participant; try again in a moment"
                    )
                self._playing.stop()
        if not self._turn.acquire(timeout=PATIENCE_S):
            raise DisplayInUseError("the display has not stopped yet; try again in a moment")
        try:
            with self._guard:
                self._owner, self._playing = owner, playing
            yield
        finally:
            with self._guard:
                self._owner, self._playing = "", None
            self._turn.release()

    def stop(self, owner: str) -> bool:
        """Fade out an owner's stimulus; return whether one was playing."""
        with self._guard:
            if self._playing is None or self._owner != owner:
                return False
            self._playing.stop()
            return True

    def stop_all(self) -> None:
        """Fade out whatever is playing."""
        with self._guard:
            if self._playing is not None:
                self._playing.stop()
