"""A simulated TWE-Lite receiver."""

from __future__ import annotations

from pathlib import Path

from tactogram.errors import ParameterError
from tactogram_capture.source import SourceKind
from tactogram_capture.twelite.simulator import SimulatedPort, SimulatedReceiver
from tactogram_capture.twelite.source import TweliteSource


class SimulatedOptions(SimulatedReceiver):
    """Options of ``simulated:twelite``: the simulated receiver, and these."""

    file: Path | None = None
    """A recording that the sensor measures: three axes in m/s^2."""
    paced: bool = True
    """Whether packets arrive in real time; otherwise as fast as they are read."""
    log: Path | None = None
    """A new file for all bytes."""


def _open(place: str, options: SimulatedOptions, *, name: str) -> TweliteSource:
    if place != "twelite":
        raise ParameterError(f"{name}: the simulated device must be twelite, got {place!r}")
    from tactogram.signal.io import read_signal  # takes longer to import than the rest

    signal = None if options.file is None else read_signal(options.file)
    port = SimulatedPort(options, signal, paced=options.paced)
    return TweliteSource(port, name=name, rate=options.rate, log=options.log, simulated=True)


EXAMPLE, TITLE = "simulated:twelite?rate=330&loss=0.02", "simulated TWE-Lite receiver"
SOURCE = SourceKind(
    "simulated", TITLE, EXAMPLE, SimulatedOptions, _open, find=lambda _: {EXAMPLE: TITLE}, simulated=True
)
