"""Sound cards through miniaudio, and its null device, which has a sound card's pace without a card."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DeviceError
from tactogram.extras import device_errors, imported, silenced

WHAT = "the null and audio backends"


@dataclass(frozen=True)
class OpenedCard:
    """A device that plays once it is started; ``backend`` is miniaudio's name of the system's library."""

    backend: str
    start: Callable[[], None]
    stop: Callable[[], None]


@contextmanager
def opened_card(
    pull: Callable[[int], NDArray[np.float32]],
    *,
    rate: float,
    channels: int,
    buffer_ms: float,
    null: bool,
    name: str = "",
) -> Iterator[OpenedCard]:
    """Open the null device or a sound card (the default one without a ``name``), and close it afterwards.

    In its own thread it requests any number of frames from ``pull``, which returns float32, shape (frames, channel), C
    order. Raises `MissingExtraError` or `DeviceError` if the library or the card is missing, also in the block.
    """
    miniaudio = imported("miniaudio", extra="devices", what=WHAT)

    def frames() -> Iterator[bytes]:
        count: Any = yield b""
        while True:
            count = yield pull(count).tobytes()

    with device_errors("null" if null else f"audio:{name}"):
        card = None if null else _card(name)
        with silenced():
            device = miniaudio.PlaybackDevice(
                output_format=miniaudio.SampleFormat.FLOAT32,
                nchannels=channels,
                sample_rate=int(rate),
                buffersize_msec=max(1, round(buffer_ms)),
                device_id=card,
                backends=[miniaudio.Backend.NULL] if null else None,
                app_name="tactogram",
            )
        source = frames()
        next(source)
        try:
            yield OpenedCard(str(device.backend), lambda: device.start(source), device.stop)
        finally:
            device.close()


def sound_cards() -> dict[str, Any]:
    """Return miniaudio's ids of sound cards by name; none where it has only its null device."""
    miniaudio = imported("miniaudio", extra="devices", what="playing on a sound card")
    with silenced():
        try:
            devices = miniaudio.Devices()
        except miniaudio.MiniaudioError:
            return {}
    if "null" in str(devices.backend).lower():
        return {}
    # ALSA's own null device discards everything and keeps no time.
    return {d["name"]: d["id"] for d in devices.get_playbacks() if not d["name"].startswith("Discard all")}


def _card(name: str) -> Any:
    cards = sound_cards()
    if not cards:
        raise DeviceError("no sound card found: plug one in, or play on the null device")
    if not name:
        return None
    if name not in cards:
        raise DeviceError(f"no sound card is called {name!r}; there are {', '.join(cards)}")
    return cards[name]
