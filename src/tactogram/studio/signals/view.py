"""The card that shows a signal on every page: waveform, spectrogram, level, spectrum beside the threshold, and sound.

Pictures and sounds are fetched by the browser under ``/signals/KEY/…``, where KEY follows from the samples.
"""

from __future__ import annotations

import hashlib
import math
import threading
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from tactogram.errors import DataError, TactogramError
from tactogram.signal import Signal
from tactogram.studio.signals.pictures import (
    Scales,
    peak_of,
    rms_of,
    scales_of,
    spectrogram_png,
    spectrum_options,
    threshold_note,
    unit_of,
    waveform_height,
    waveform_options,
)
from tactogram.studio.signals.sound import NORMAL_PEAK, WALKED_MM_S, sound_of

MOST_BYTES = 256 * 2**20
"""Of samples that are held for the browser to fetch."""
HEAD = '<link rel="stylesheet" href="/static/signals.css"><script type="module" src="/static/player.js"></script>'


@dataclass
class Shown:
    """Signals that pages show at present, by key; the ones that were not asked for longest go first."""

    most: int = MOST_BYTES
    _held: OrderedDict[str, Signal] = field(default_factory=OrderedDict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def put(self, signal: Signal) -> str:
        """Hold a signal, and return its key."""
        key = key_of(signal)
        with self._lock:
            self._held[key] = signal
            self._held.move_to_end(key)
            while len(self._held) > 1 and sum(one.samples.nbytes for one in self._held.values()) > self.most:
                self._held.popitem(last=False)
        return key

    def get(self, key: str) -> Signal:
        """Return a signal by its key.

        Raises
        ------
        DataError
            If it is no longer held.
        """
        with self._lock:
            if key not in self._held:
                raise DataError("this signal is no longer held: reload the page")
            self._held.move_to_end(key)
            return self._held[key]


SHOWN = Shown()


def key_of(signal: Signal) -> str:
    """Return 24 hexadecimal digits that follow from the samples and what they mean."""
    said = f"{signal.rate!r} {signal.unit} {signal.axes!r} {signal.domain}"
    return hashlib.sha256(said.encode() + signal.samples.tobytes()).hexdigest()[:24]


def add_routes() -> None:
    """Register where pictures and sounds of shown signals are fetched; a second call does nothing."""
    from fastapi import Response
    from nicegui import app

    if any(getattr(route, "path", "") == "/signals/{key}/sound.wav" for route in app.routes):
        return

    @app.get("/signals/{key}/sound.wav")
    def sound(key: str, gain: float | None = None) -> Response:
        try:
            made = sound_of(SHOWN.get(key), gain=gain)
        except TactogramError as error:
            return Response(str(error), status_code=404, media_type="text/plain")
        said = {
            "X-Gain": f"{made.gain:.6g}",
            "X-Limited": f"{made.limited:.6g}",
            "X-Own-Level": str(int(made.own_level)),
        }
        return Response(made.wav, media_type="audio/wav", headers=said | KEPT)

    @app.get("/signals/{key}/spectrogram.png")
    def spectrogram(key: str, peak: float, extent: float, top_db: float, top_hz: float) -> Response:
        try:
            signal = SHOWN.get(key)
        except TactogramError as error:
            return Response(str(error), status_code=404, media_type="text/plain")
        if not (extent > 0 and top_hz > 0 and math.isfinite(extent + top_hz + top_db + peak)):
            return Response("extent and top_hz must be > 0", status_code=400, media_type="text/plain")
        png = spectrogram_png(signal, scales=Scales(peak, extent, top_db, top_hz))
        return Response(png, media_type="image/png", headers=KEPT)


KEPT = {"Cache-Control": "private, max-age=3600"}
"""What follows from the samples alone may be kept by the browser."""


def signal_card(
    signal: Signal,
    *,
    title: str,
    simulated: bool = False,
    compare: Sequence[Signal] = (),
    scales: Scales | None = None,
    gain: float | None = None,
    key: str = "",
    small: bool = False,
) -> Any:
    """Draw a signal, and return the row at its top that further buttons go into.

    Parameters
    ----------
    signal : Signal
    title : str
        What people call it.
    simulated : bool
        Whether it, or what it was learned from, is simulated: then it says so.
    compare : sequence of Signal
        What stands beside it: all are drawn on the same scales.
    scales : Scales, optional
        By default of the signal and ``compare``, see `scales_of`: to be made in a thread where they are long.
    gain : float, optional
        Full scales per unit at which it is played; by default a level of its own.
    key : str
        Of the keyboard that plays it, ``1`` to ``9``; several of a page are changed between while playing.
    small : bool
        Whether the spectrum is left out.
    """
    from nicegui import ui

    load_player()
    add_routes()
    held = SHOWN.put(signal)
    scales = scales or scales_of([signal, *compare])
    with ui.element("section").classes("card signal").props(f'role="group" aria-label="{_quoted(title)}"'):
        with ui.row().classes("w-full items-center gap-2") as top:
            ui.label(title).classes("h2")
            if simulated:
                ui.label("simulated").classes("simulated")
        ui.label(level_text(signal)).classes("small level")
        ui.label(threshold_note(signal)).classes("small quiet")
        play_button(held, title=title, gain=gain, key=key, unit=unit_of(signal), domain=signal.domain)
        described = f"Waveform of {title}: {level_text(signal)}"
        _chart(waveform_options(signal, scales=scales), waveform_height(signal), described)
        _spectrogram(held, scales, over_time=signal.domain == "time", title=title)
        if not small:
            described = f"Spectrum of {title} in third octaves. {threshold_note(signal)}"
            _chart(spectrum_options(signal, others=compare), 200, described)
    return top


def level_text(signal: Signal) -> str:
    """Return how strong and how long a signal is, in words."""
    unit = unit_of(signal)
    per = "Hz" if signal.domain == "time" else "per mm"
    extent = f"{signal.extent:.3g} {'s' if signal.domain == 'time' else 'mm'}"
    axes = f"axes {', '.join(signal.axes)}" if len(signal.axes) > 1 else f"axis {signal.axes[0]}"
    return (
        f"{rms_of(signal):.3g} {unit} rms · {peak_of(signal):.3g} {unit} peak · "
        f"{extent} at {signal.rate:,.6g} {per} · {axes}"
    )


def play_button(
    held: str,
    *,
    title: str,
    gain: float | None = None,
    key: str = "",
    unit: str = "",
    domain: str = "time",
) -> None:
    """Draw the button that plays a held signal, and where its level is told."""
    from nicegui import ui

    address = f"/signals/{held}/sound.wav" + ("" if gain is None else f"?gain={gain:.6g}")
    how = (
        f"level of its own: peaks at {NORMAL_PEAK:g} of full scale"
        if gain is None
        else f"{gain:.3g} of full scale per {unit}, as the others"
    )
    if domain != "time":
        how += f", walked through at {WALKED_MM_S:g} mm/s"
    with ui.row().classes("items-center gap-2 no-wrap"):
        button = ui.element("button").classes("player")
        button.props(
            f'type="button" aria-pressed="false" aria-label="Play {_quoted(title)}" data-player-url="{address}"'
        )
        if key:
            button.props(f'data-player-key="{key}" aria-keyshortcuts="{key}"')
        ui.label(how).classes("small quiet")
        ui.element("span").classes("small quiet").props(f'data-player-told="{address}" data-unit="{unit}"')
    ui.element("div").classes("playhead").props(f'data-player-head="{address}" aria-hidden="true"')


def load_player() -> None:
    """Load `static/player.js` into the present page, once, also after it was sent."""
    from nicegui import ui

    client = ui.context.client
    if getattr(client, "tactogram_player", False):
        return
    client.tactogram_player = True  # type: ignore[attr-defined]
    ui.add_head_html(HEAD)
    if client.has_socket_connection:
        ui.run_javascript("import('/static/player.js')")


def _chart(options: dict[str, Any], height: int, described: str) -> None:
    from nicegui import ui

    chart = ui.echart(options).classes("w-full").style(f"height: {height}px")
    chart.props(f'role="img" aria-label="{_quoted(described)}"')


def _spectrogram(held: str, scales: Scales, *, over_time: bool, title: str) -> None:
    from nicegui import ui

    asked = (
        f"peak={scales.peak:.6g}&extent={scales.extent:.9g}&top_db={scales.top_db:.6g}"
        f"&top_hz={scales.top_hz:.9g}"
    )
    unit = "Hz" if over_time else "per mm"
    with ui.element("div").classes("spectrogram"):
        ui.label(f"{scales.top_hz:.4g} {unit}").classes("small quiet top")
        ui.label("0").classes("small quiet bottom")
        picture = ui.element("img").props(
            f'src="/signals/{held}/spectrogram.png?{asked}" alt="Spectrogram of {_quoted(title)}, 0 to '
            f'{scales.top_hz:.4g} {unit}, brightest {scales.top_db:.0f} dB re 1 unit"'
        )
        picture.classes("w-full")


def _quoted(text: str) -> str:
    """Return a text that may stand between double quotes in an element's properties."""
    return text.replace("\\", "/").replace('"', "'").replace("\n", " ")
