"""Examples of the start page: signals that are heard, and move, at a press."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from html import escape
from pathlib import Path

import numpy as np
from fastapi import Response
from nicegui import app, ui

from tactogram.errors import DataError
from tactogram.rendering import carrier, effect, photo_to_touch
from tactogram.signal import Signal
from tactogram.signal.io import read_image, read_signal
from tactogram_studio import kit
from tactogram_studio.signals.sound import sound_of
from tactogram_studio.signals.traits import envelope
from tactogram_studio.signals.view import load_player

FOLDER = Path(__file__).parents[1] / "static" / "examples"
PHOTOGRAPH = "corduroy.webp"
WIDTH_MM = 80.0
"""Width that the photograph shows."""
COLUMNS, HEIGHT = 240, 80
"""Of a drawn waveform."""


@dataclass(frozen=True)
class Example:
    """A signal with a line about it, and its photograph."""

    title: str
    about: str
    signal: Callable[[], Signal]
    photograph: str = ""


EXAMPLES: Mapping[str, Example] = {
    "sandpaper": Example(
        "Sandpaper",
        "under a finger that moves to and fro (simulated)",
        lambda: read_signal(FOLDER / "sandpaper.flac"),
    ),
    "heartbeat": Example(
        "Heartbeat", "an effect for a phone or a controller", lambda: carrier(effect("heartbeat"))
    ),
    "click": Example("Click", "a key: a sharp press and a weaker release", lambda: carrier(effect("click"))),
    "photograph": Example(
        "A photograph",
        "its ridges, crossed by a finger (simulated corduroy)",
        lambda: photo_to_touch(read_image(FOLDER / PHOTOGRAPH, width_mm=WIDTH_MM)),
        PHOTOGRAPH,
    ),
}


@cache
def add_route() -> None:
    """Register the route of the sounds, for the process."""

    @app.get("/examples/{name}.wav")
    def sound(name: str) -> Response:
        return Response(_wav(name), media_type="audio/wav")


def draw_examples(actions: Mapping[str, Callable[[], object]]) -> None:
    """Draw the examples in a row, each with what its action draws."""
    load_player()
    with ui.element("div").classes("examples"):
        for name, example in EXAMPLES.items():
            with ui.element("div").classes("example"):
                address = f"/examples/{name}.wav"
                play = (
                    ui.element("button").classes("example-play").props('type="button" aria-pressed="false"')
                )
                play.props.update({"aria-label": f"Play: {example.title}", "data-player-url": address})
                with play:
                    ui.html(_picture(name), sanitize=False)
                    dot = ui.element("span").classes("example-dot").props('aria-hidden="true"')
                    dot.props["data-player-head"] = address
                with ui.row().classes("items-baseline justify-between w-full no-wrap gap-2"):
                    ui.label(example.title).classes("h2")
                    actions[name]()
                kit.hint(example.about)


@cache
def _wav(name: str) -> bytes:
    if name not in EXAMPLES:
        raise DataError(name[:60], "no such example")
    return sound_of(EXAMPLES[name].signal()).wav


@cache
def _picture(name: str) -> str:
    """Return the photograph, or the waveform as SVG."""
    example = EXAMPLES[name]
    if example.photograph:
        return f'<img src="/static/examples/{escape(example.photograph)}" alt="" class="example-photograph">'
    samples = example.signal().samples[0]
    times, values = envelope(samples / np.abs(samples).max(), COLUMNS)
    xs, ys = COLUMNS * times / len(samples), HEIGHT / 2 - (HEIGHT / 2 - 4) * values
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(xs, ys, strict=True))
    return (
        f'<svg viewBox="0 0 {COLUMNS} {HEIGHT}" preserveAspectRatio="none" aria-hidden="true">'
        f'<polyline points="{points}"/></svg>'
    )
