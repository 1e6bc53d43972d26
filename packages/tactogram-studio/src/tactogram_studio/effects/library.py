"""Ready effects: short tracks to begin with, in ``library.toml``."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tactogram.text_files import read_toml
from tactogram_studio.effects.editing import repeated
from tactogram_studio.effects.effect import Point, Track, Transient

FILE = Path(__file__).with_name("library.toml")


@dataclass(frozen=True)
class ReadyEffect:
    """A track that begins at 0 s, with a sentence about it."""

    track: Track
    about: str


@cache
def ready_effects() -> dict[str, ReadyEffect]:
    """Return the ready effects by title."""
    effects = {}
    for values in read_toml(FILE)["effect"]:
        track = Track(
            title=values["title"],
            amplitude=tuple(_point(*pair) for pair in values.get("amplitude", ())),
            frequency=tuple(_point(*pair) for pair in values.get("frequency", [[0.0, 170.0]])),
            transients=tuple(
                Transient(time=float(time), amplitude=float(amplitude), frequency=float(hz))
                for time, amplitude, hz in values.get("transients", ())
            ),
        )
        if times := values.get("times"):
            track = repeated(track, 0.0, values["every"], times=times)
        effects[track.title] = ReadyEffect(track, values["about"])
    return effects


def _point(time: float, value: float) -> Point:
    return Point(time=float(time), value=float(value))
