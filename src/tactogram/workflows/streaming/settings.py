"""Stream settings, and combinations that are refused before anything moves."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

from tactogram.errors import ParameterError
from tactogram.rendering.streaming.engine import LONGEST_BLOCK_S
from tactogram.signal.io.files import WRITABLE
from tactogram.signal.io.writable import check_writable

Backend = Literal["null", "file", "clock", "audio", "osc", "udp"]
NETWORK = ("osc", "udp")


@dataclass(frozen=True)
class StreamSettings:
    """Settings of a stream.

    Parameters
    ----------
    motion : str
        ``simulated``, ``osc`` or ``udp`` (one port hears both), ``mouse``, or a CSV.
    backend : {"null", "file", "clock", "audio", "osc", "udp"}
        See `tactogram.rendering.streaming.backends`; ``osc`` and ``udp`` send the blocks over the network.
    seconds : float
    block_ms : float
        At most 5.
    seed : int
        Of noise and simulated hand.
    listen, to : str
        HOST:PORT that motion is heard at, and that blocks go to (by default back to who sent the motion).
    device : str, optional
        A sound card by name or number.
    tap_gain : float
        Of a landing's transient; 0 is none.
    realtime : bool
        Ask the system for real-time priority.
    equalise : bool, optional
        Whether the display's response is made up for; by default as its file says, which is so wherever one is known:
        a stream is felt like the file that `render` makes.
    """

    motion: str = "simulated"
    backend: Backend = "null"
    seconds: float = 10.0
    block_ms: float = 5.0
    seed: int = 0
    listen: str = ""
    to: str = ""
    device: str | None = None
    tap_gain: float = 4.0
    realtime: bool = False
    equalise: bool | None = None


def check(settings: StreamSettings, display: str | None, level: str | None) -> None:
    """Refuse settings that are out of range or do not go together.

    Raises
    ------
    ParameterError
    """
    if settings.backend not in get_args(Backend):
        raise ParameterError(
            f"backend must be one of {', '.join(get_args(Backend))}, got {settings.backend!r}"
        )
    if not 0 < settings.seconds <= 24 * 3600:
        raise ParameterError(f"seconds must be > 0 and at most a day, got {settings.seconds:g}")
    if not 0 < settings.block_ms <= 1e3 * LONGEST_BLOCK_S:
        raise ParameterError(
            f"block must be > 0 and at most {1e3 * LONGEST_BLOCK_S:g} ms, got {settings.block_ms:g}"
        )
    if settings.seed < 0:
        raise ParameterError(f"seed must be >= 0, got {settings.seed}")
    if (display is None) != (level is None):
        raise ParameterError(
            "a display needs a level and a level a display: give --display and --level, or neither"
        )
    if settings.equalise is not None and display is None:
        raise ParameterError(
            "a display's response is equalised: give --display and --level, or leave out --equalise"
        )
    if settings.backend == "audio" and display is None:
        raise ParameterError(
            "the audio backend moves an actuator: say which --display it is, and the --level"
        )
    if settings.backend == "file" and settings.motion in (*NETWORK, "mouse"):
        raise ParameterError(
            f"backend file does not keep the time, so motion cannot come from {settings.motion}: use clock"
        )


def check_files(out: Path | None, figure: Path | None) -> None:
    """Refuse what could not be written in the end: an hour of streaming would be lost."""
    if out is not None and out.suffix.lower() not in WRITABLE:
        raise ParameterError(f"{out}: suffix must be one of {', '.join(WRITABLE)}, got {out.suffix}")
    if figure is not None and figure.suffix.lower() != ".png":
        raise ParameterError(f"{figure}: a figure's suffix must be .png, got {figure.suffix}")
    for path in filter(None, (out, figure)):
        check_writable(path)
