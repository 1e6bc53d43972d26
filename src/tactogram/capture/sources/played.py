"""A simulated hand that strokes what a store holds: its recordings, played through a simulated TWE-Lite device.

What comes out went the whole way: quantised, framed, printed to a pty, delayed, some of it lost, read from the port and
parsed. It is simulated, also where the recordings are not, and says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from threading import Lock
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from tactogram.capture.session.plan import PlannedTake
from tactogram.capture.sources.twelite import TweliteSource
from tactogram.capture.twelite.simulator import SimulatedPort, SimulatedReceiver, transmissions
from tactogram.datasets import RecordingInfo, Store
from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.resampling import resample
from tactogram.signal.units import STANDARD_GRAVITY

AXES = ("x", "y", "z")
PACKETS_AT_ONCE = 3
"""Packets after which the hand may change what it strokes: a tenth of a second at 330 Hz."""
REST_NOISE = 0.02
"""Of a hand that rests, m/s^2 rms per axis: about the sensor's own at a few hundred Hz."""


class StrokeReplay:
    """Strokes one recording after the other, each again and again from a place drawn at random.

    Parameters
    ----------
    store : Store
        Recordings of three axes in m/s^2.
    rate : float, Hz
        Of the sensor.
    seed : int
        Draws recordings and places.
    stream : str
        What is played.
    """

    def __init__(self, store: Store, *, rate: float, seed: int = 0, stream: str = "acceleration") -> None:
        facts = store.streams.get(stream)
        if facts is None or facts.unit != "m/s^2" or set(facts.axes) != set(AXES):
            raise ParameterError(f"{store.path}: a simulated device plays {stream} of axes x, y, z in m/s^2")
        self._store, self._rate, self._stream = store, rate, stream
        self._rng = np.random.default_rng(seed)
        self._infos = [info for info in store.index if info.material is not None]
        self._lock = Lock()
        self._samples: NDArray[np.float32] | None = None
        self._place = 0
        self.touched: list[tuple[float, RecordingInfo | None]] = []
        """When what began to be stroked (clock of ``time.monotonic``), None for rest."""

    @property
    def materials(self) -> tuple[str, ...]:
        """What can be stroked, sorted."""
        return tuple(sorted({str(info.material) for info in self._infos}))

    def touch(self, material: str, *, contactor: str | None = None, speed_mm_s: float | None = None) -> None:
        """Stroke a recording of ``material`` from now on; of the contactor and speed asked for where there is one.

        Raises
        ------
        ParameterError
            If there is none of the material.
        """
        found = [info for info in self._infos if info.material == material]
        if not found:
            raise ParameterError(f"material must be one of {', '.join(self.materials)}, got {material!r}")
        for name, value in (("contactor", contactor), ("speed_mm_s", speed_mm_s)):
            found = [info for info in found if value is None or getattr(info, name) == value] or found
        info = found[int(self._rng.integers(len(found)))]
        signal = resample(self._store.signal(info.id, self._stream).select(*AXES), self._rate)
        with self._lock:
            self._samples, self._place = signal.samples, int(self._rng.integers(len(signal)))
            self.touched.append((monotonic(), info))

    def rest(self) -> None:
        """Lift the finger."""
        with self._lock:
            self._samples = None
            self.touched.append((monotonic(), None))

    def felt(self, count: int) -> Signal:
        """Return the next ``count`` samples, three axes, m/s^2, at the sensor's rate."""
        with self._lock:
            if self._samples is None:
                x = (REST_NOISE * self._rng.standard_normal((3, count))).astype(np.float32)
                x[2] += np.float32(STANDARD_GRAVITY)
            else:
                places = (self._place + np.arange(count)) % self._samples.shape[1]
                x = self._samples[:, places]
                self._place = int(places[-1] + 1) % self._samples.shape[1]
        return Signal(x, self._rate, "m/s^2", AXES)


class StoreReplayPort(SimulatedPort):
    """A pty that a simulated receiver prints to what a `StrokeReplay` feels, for ever or for its ``seconds``."""

    def __init__(
        self,
        receiver: SimulatedReceiver,
        hand: StrokeReplay,
        *,
        each: Callable[[float], None] | None = None,
    ) -> None:
        super().__init__(receiver)
        self.hand, self._each = hand, each

    def _print(self) -> None:
        start, per_packet = monotonic(), self.receiver.samples_per_packet
        chunk_s = PACKETS_AT_ONCE * per_packet / self.receiver.rate
        for number in self._chunks(chunk_s):
            if self._each is not None:
                self._each(number * chunk_s)
            # A piece of its own each: sequence and losses go on, what is felt is asked for when it is due.
            receiver = self.receiver.model_copy(
                update={
                    "first_sequence": (self.receiver.first_sequence + PACKETS_AT_ONCE * number) % 65536,
                    "seed": self.receiver.seed + number,
                    "seconds": None,
                }
            )
            for sent in transmissions(receiver, self.hand.felt(PACKETS_AT_ONCE * per_packet)):
                due = start + number * chunk_s + sent.time_s
                if self._stop.wait(max(0.0, due - monotonic())):
                    return
                self.sent += 1
                self.lost += not sent.data
                self.damaged += sent.damaged
                if not self._write(sent.data):
                    return
        self._finished.set()

    def _chunks(self, chunk_s: float) -> Iterator[int]:
        number = 0
        while self.receiver.seconds is None or number * chunk_s < self.receiver.seconds:
            yield number
            number += 1


class StoreReplaySource(TweliteSource):
    """A simulated TWE-Lite device whose sensor strokes what a store holds.

    Parameters
    ----------
    store : Store
    receiver : SimulatedReceiver
        Rate, losses, lateness, length and form.
    name : str
        The address.
    materials : sequence of str, optional
        Stroked in turn, ``("all",)`` every one; by default nothing is until `on_trial` or ``hand.touch`` says so.
    each_s : float
        How long each of ``materials`` is.
    log : Path, optional
        As in `TweliteSource`.
    """

    def __init__(
        self,
        store: Store,
        receiver: SimulatedReceiver,
        *,
        name: str,
        materials: Sequence[str] = (),
        each_s: float = 5.0,
        log: Path | None = None,
    ) -> None:
        self.hand = StrokeReplay(store, rate=receiver.rate, seed=receiver.seed)
        names = self.hand.materials if tuple(materials) == ("all",) else tuple(materials)
        self._materials, self._each_s, self._turn = names, each_s, -1
        for material in self._materials:
            self.hand.touch(material)  # refuses what is not there before anything is opened
        self.hand.rest()
        self.hand.touched.clear()
        port = StoreReplayPort(receiver, self.hand, each=self._next if self._materials else None)
        super().__init__(port, name=name, log=log, simulated=True)

    def on_trial(self, trial: PlannedTake) -> None:
        """Stroke what a session asks for."""
        self.hand.touch(trial.material, contactor=trial.contactor, speed_mm_s=trial.speed_mm_s)

    def _next(self, now_s: float) -> None:
        turn = int(now_s / self._each_s)
        if turn != self._turn:
            self._turn = turn
            self.hand.touch(self._materials[turn % len(self._materials)])
