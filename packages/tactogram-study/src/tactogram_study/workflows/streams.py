"""Stimuli that follow a participant's finger, streamed to the server's display.

The way of a finger position: the page measures it in mm from the middle of the page and sends it over a websocket
(`studio.participants.stimulus_routes`), as often as the screen reports it and at least once per frame while the finger
is down. `PageMotion` keeps it, with its time of arrival, for the engine of `tactogram_playback`, which runs in a
thread of the server: texture, display output and guard are those of `tactogram stream`, and so are the devices. When
the finger lands on a slot, the session logs hash, level and display; when it leaves, latency, motion and drive.
"""

from __future__ import annotations

import copy
import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import tactogram_playback as playback
from tactogram.errors import ParameterError
from tactogram.rendering import Display, Level, MotionSample, MotionSettings, display_family, without_constant
from tactogram.signal import Signal

FORCE_N = 0.5
"""Force of a finger that touches the page, N: a screen reports contact only. Our choice."""
LONGEST_S = 600.0
"""Longest stream without leaving a slot, s."""
WAITING = 1024
"""Most positions between two blocks; the oldest are dropped beyond that."""
ON_A_PAGE = MotionSettings(late_s=0.05)
"""A page sends positions once per frame, and over a wireless network: up to 50 ms late they are still used."""


@dataclass(frozen=True, eq=False)
class StimulusStream:
    """A stimulus that is ready to be streamed to a display; ``weight`` is that of its texture.

    ``sha256`` is that of the rehearsal (the texture under a simulated hand, seeded), or of the surface itself.
    """

    texture: playback.StreamingTexture
    output: playback.DisplayOutput
    sha256: str
    weight: float = 1.0

    def stronger(self, gain_db: float) -> StimulusStream:
        """Return the stimulus ``gain_db`` above its level: weights are of the power of a vibration."""
        return replace(self, weight=self.weight * 10 ** (gain_db / 10))


def texture_settings(display: Display, axes: str, *, seed: int = 0) -> playback.TextureSettings:
    """Return the settings of textures for a display; raises `ParameterError` if it cannot be streamed to."""
    playback.check_streams(display)
    return playback.TextureSettings(
        display.rate,
        max(1, int(playback.LONGEST_BLOCK_S * display.rate + 1e-9)),
        axes or display.axes,
        seed=seed,
    )


def texture_of_signal(
    name: str, signal: Signal, settings: playback.TextureSettings, speed_mm_s: float | None
) -> playback.StreamingTexture:
    """Return a signal as a surface: over displacement along x, where it has its place; over time along the path."""
    signal, _ = without_constant(signal)
    along = replace(settings, along="x" if signal.domain == "displacement" else "path")
    return playback.surface_of(name, signal, along, speed_mm_s)


def stimulus_stream(
    texture: playback.StreamingTexture, display: Display, level: Level, most: int
) -> StimulusStream:
    """Fit a texture to a display, as `tactogram stream` does: the level comes from a rehearsal."""
    if display_family(display.family).stream_surface is not None:
        if not isinstance(texture, playback.SurfaceTexture):
            raise ParameterError(
                f"{display.name}: streams a surface, a friction coefficient over displacement; got a vibration"
            )
        return StimulusStream(
            texture, playback.DisplayOutput(display, texture, level=level), texture.signal.sha256
        )
    rehearsed = playback.rehearsal([texture], rate=display.rate, most=most, seed=0, contact=_quiet())
    return StimulusStream(texture, playback.DisplayOutput(display, rehearsed, level=level), rehearsed.sha256)


def _quiet() -> playback.ContactSettings:
    """Return contact without transients of landings: they are no part of a stimulus."""
    return playback.ContactSettings(gain=0.0)


class PageMotion:
    """Positions of a finger on a page, for an engine on ``clock``."""

    name, simulated = "page", False

    def __init__(self, clock: playback.Clock) -> None:
        self._clock = clock
        self._waiting: deque[tuple[float, Sequence[float]]] = deque(maxlen=WAITING)

    def add(self, samples: Sequence[Sequence[float]]) -> None:
        """Take positions, (time on the page in ms, x mm, y mm, 1 while it touches), which arrive now."""
        now = time.perf_counter()
        self._waiting.extend((now, sample) for sample in samples)

    def poll(self, now_s: float) -> list[MotionSample]:
        """Return the positions that arrived since the last call."""
        samples = []
        while self._waiting:
            arrival, (ms, x, y, touching) = self._waiting.popleft()
            force = FORCE_N if touching else 0.0
            samples.append(MotionSample(ms / 1e3, arrival - self._clock.began, x, y, math.nan, force))
        return samples

    def close(self) -> None:
        """Forget the positions that wait."""
        self._waiting.clear()


class FingerStream:
    """One stimulus under one finger, from landing on a slot until it leaves; started and stopped once.

    A ``silent`` one keeps the display at rest: the stimulus that is not there. ``landed_s`` is when the finger landed
    (`time.perf_counter`).
    """

    def __init__(
        self, stimulus: StimulusStream, *, silent: bool = False, landed_s: float | None = None
    ) -> None:
        self._clock = playback.Clock()
        self._silent = silent
        self._landed_s = time.perf_counter() if landed_s is None else landed_s
        self._begin_s: float | None = None
        self._began: Callable[[], None] = lambda: None
        self.motion = PageMotion(self._clock)
        # Copied: filters and guard begin at rest, and the prepared stimulus stays as it is.
        output = copy.deepcopy(stimulus.output)
        rate, texture = output.display.rate, stimulus.texture
        engine = playback.Engine(
            [texture],
            self.motion,
            rate=rate,
            most=max(1, int(playback.LONGEST_BLOCK_S * rate + 1e-9)),
            weights={texture.name: stimulus.weight},
            settings=ON_A_PAGE,
            contact=_quiet(),
        )
        self.stream = playback.Stream(engine, output, on_block=self._on_block)
        self.stream.warm_up()

    def add(self, samples: Sequence[Sequence[float]]) -> None:
        """Take positions as of `PageMotion.add`."""
        if not self._silent:
            self.motion.add(samples)

    def run(self, backend: playback.Backend, *, began: Callable[[], None] = lambda: None) -> dict[str, Any]:
        """Stream until stopped, and return the facts for the session's log; ``began`` is called with the first block.

        Raises `TactogramError` if the device is missing or fails, or the stream had an error; the display is at rest
        then.
        """
        self._began = began
        sent = playback.run(self.stream, backend, seconds=LONGEST_S, clock=self._clock)
        if self.stream.error is not None:
            raise self.stream.error
        facts = self.stream.facts()
        engine = self.stream.engine
        return {
            "state": "stopped" if self.stream.stopped else "ended",
            "seconds": round(sum(engine.blocks.values()) * engine.most / engine.rate, 3),
            "silent": self._silent,
            "landing_to_first_block_ms": None if self._begin_s is None else round(1e3 * self._begin_s, 1),
            "simulated_device": backend.simulated,
            **{name: facts[name] for name in ("motion", "states", "latency")},
            "display": {key: value for key, value in facts["display"].items() if key != "rehearsal"},
            **sent,
        }

    def stop(self) -> None:
        """Fade to rest and end; safe to call at any time, from any thread."""
        self.stream.stop()

    def _on_block(self, now_s: float) -> None:
        if self._begin_s is None:
            self._begin_s = time.perf_counter() - self._landed_s
            self._began()
