"""Recordings of a store, played through a simulated TWE-Lite receiver.

The output passes through the whole chain: quantised, framed, delayed, partly lost, and parsed. It is marked simulated
even if the recordings are not.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from tactogram.datasets import Store, open_store
from tactogram.errors import ParameterError
from tactogram.signal import STANDARD_GRAVITY, resample
from tactogram_capture.session.plan import PlannedTake
from tactogram_capture.source import SourceKind, required_place
from tactogram_capture.twelite.simulator import SimulatedPort, SimulatedReceiver
from tactogram_capture.twelite.source import TweliteSource

AXES = ("x", "y", "z")
REST_NOISE = 0.02
"""Of a resting hand, m/s^2 rms per axis: about the sensor's own noise at a few hundred Hz."""


class StoreReplayOptions(SimulatedReceiver):
    """Options of ``played:STORE``: the simulated receiver, and these."""

    materials: str = ""
    """Stroked in turn, separated by commas; ``all`` is every one. By default the plan of a session decides."""
    each_s: float = Field(default=5.0, gt=0, allow_inf_nan=False)
    """Duration of each material, s."""
    log: Path | None = None
    """A new file for all bytes."""


class StrokeReplay:
    """A simulated hand that strokes one recording of a store at a time, repeated from a random position.

    The stream ``stream`` of the recordings has three axes in m/s^2; ``rate`` is the sensor's, Hz.
    """

    def __init__(self, store: Store, *, rate: float, seed: int = 0, stream: str = "acceleration") -> None:
        facts = store.streams.get(stream)
        if facts is None or facts.unit != "m/s^2" or set(facts.axes) != set(AXES):
            raise ParameterError(f"{store.path}: a simulated device plays {stream} of axes x, y, z in m/s^2")
        self._store, self._rate, self._stream = store, rate, stream
        self._rng = np.random.default_rng(seed)
        self._infos = [info for info in store.index if info.material is not None]
        self._samples: NDArray[np.float32] | None = None
        self._place = 0

    @property
    def materials(self) -> tuple[str, ...]:
        """Materials of the store, sorted."""
        return tuple(sorted({str(info.material) for info in self._infos}))

    def touch(self, material: str, *, contactor: str | None = None, speed_mm_s: float | None = None) -> None:
        """Stroke a recording of ``material`` from now on, preferably of the contactor and speed.

        Raises `ParameterError` if the material has no recording.
        """
        infos = [info for info in self._infos if info.material == material]
        if not infos:
            raise ParameterError.one_of("material", self.materials, material)
        for name, value in (("contactor", contactor), ("speed_mm_s", speed_mm_s)):
            infos = [info for info in infos if value is None or getattr(info, name) == value] or infos
        info = infos[int(self._rng.integers(len(infos)))]
        signal = resample(self._store.signal(info.id, self._stream).select(*AXES), self._rate)
        self._samples, self._place = signal.samples, int(self._rng.integers(len(signal)))

    def rest(self) -> None:
        """Lift the finger."""
        self._samples = None

    def next_samples(self, count: int) -> NDArray[np.float32]:
        """Return the next samples, float32, shape (3, count), m/s^2, at the sensor's rate."""
        if self._samples is None:
            x = (REST_NOISE * self._rng.standard_normal((3, count))).astype(np.float32)
            x[2] += np.float32(STANDARD_GRAVITY)
            return x
        places = (self._place + np.arange(count)) % self._samples.shape[1]
        self._place = int(places[-1] + 1) % self._samples.shape[1]
        return self._samples[:, places]


class StoreReplaySource(TweliteSource):
    """A simulated TWE-Lite device whose sensor strokes the recordings of a store, as a plan says."""

    def __init__(self, store: Store, options: StoreReplayOptions, *, name: str) -> None:
        self.hand = StrokeReplay(store, rate=options.rate, seed=options.seed)
        names = tuple(name for name in options.materials.split(",") if name)
        self._materials = self.hand.materials if names == ("all",) else names
        self._each_s, self._turn = options.each_s, -1
        for material in self._materials:
            self.hand.touch(material)  # refuses unknown materials before anything is opened
        self.hand.rest()
        super().__init__(
            SimulatedPort(options, self._packets(options)), name=name, log=options.log, simulated=True
        )

    def on_trial(self, trial: PlannedTake) -> None:
        """Stroke the material of a planned take."""
        self.hand.touch(trial.material, contactor=trial.contactor, speed_mm_s=trial.speed_mm_s)

    def _packets(self, receiver: SimulatedReceiver) -> Iterator[NDArray[np.float32]]:
        """Yield the samples of each packet as it becomes due, of the material whose turn it is."""
        for number in count():
            turn = int(number * receiver.samples_per_packet / receiver.rate / self._each_s)
            if self._materials and turn != self._turn:
                self._turn = turn
                self.hand.touch(self._materials[turn % len(self._materials)])
            yield self.hand.next_samples(receiver.samples_per_packet)


def _open(place: str, options: StoreReplayOptions, *, name: str) -> StoreReplaySource:
    return StoreReplaySource(open_store(required_place(place, name, "the store")), options, name=name)


SOURCE = SourceKind(
    "played",
    "recordings played by a simulated TWE-Lite receiver",
    "played:STORE?loss=0.02",
    StoreReplayOptions,
    _open,
    place_is_file=True,
    simulated=True,
)
