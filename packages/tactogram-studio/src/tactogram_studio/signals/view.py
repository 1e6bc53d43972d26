"""Signal cards of all pages: waveform, spectrogram, level, spectrum with the detection threshold, and sound.

The browser fetches pictures and sounds under ``/signals/KEY/…``, where KEY follows from the samples.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from fastapi import Response
from nicegui import app, ui

from tactogram.errors import ParameterError, TactogramError
from tactogram.signal import Signal
from tactogram_studio import kit
from tactogram_studio.signals.pictures import (
    RANGE_DB,
    card_height,
    spectrogram_png,
    spectrum_options,
    waveform_height,
    waveform_options,
)
from tactogram_studio.signals.registry import SHOWN, ShownSignal, Source
from tactogram_studio.signals.sound import NORMAL_PEAK, PLAYBACK_MM_S, common_gain, sound_of
from tactogram_studio.signals.traits import SharedScales, SignalTraits, scales_of, unit_text

HEAD = '<link rel="stylesheet" href="/static/signals.css"><script type="module" src="/static/player.js"></script>'
USUAL_AXES = 3
CACHED = {"Cache-Control": "private, max-age=3600"}
"""Pictures and sounds follow from the samples in their key: browsers may cache them."""


@cache
def add_routes() -> None:
    """Register the routes of pictures and sounds, once."""

    @app.get("/signals/{key}/sound.wav")
    def sound(key: str, gain: float | None = None) -> Response:
        clip = sound_of(SHOWN.get(key).signal, gain=gain)
        headers = {
            "X-Gain": f"{clip.gain:.6g}",
            "X-Limited": f"{clip.limited:.6g}",
            "X-Own-Level": str(int(clip.normalised)),
        }
        return Response(clip.wav, media_type="audio/wav", headers=headers | CACHED)

    @app.get("/signals/{key}/spectrogram.png")
    def spectrogram(key: str, peak: float, extent: float, top_db: float, top_hz: float) -> Response:
        if not (extent > 0 and top_hz > 0 and math.isfinite(extent + top_hz + top_db + peak)):
            raise ParameterError("extent and top_hz must be > 0")
        png = spectrogram_png(SHOWN.get(key).traits, scales=SharedScales(peak, extent, top_db, top_hz))
        return Response(png, media_type="image/png", headers=CACHED)


@dataclass(frozen=True)
class SignalEntry:
    """A signal, or a file that is read once, to show; the ``key`` (``1`` to ``9``) plays it, or switches to it."""

    source: Source
    title: str
    simulated: bool = False
    key: str = ""


def signal_card(source: Source, *, title: str, simulated: bool = False, small: bool = False) -> ui.row:
    """Draw a signal and return its title row, where more buttons can go; see `signal_cards`."""
    [top] = signal_cards([SignalEntry(source, title, simulated)], small=small)
    return top


def signal_cards(
    entries: Sequence[SignalEntry], *, same_gain: bool = False, small: bool = False
) -> list[ui.row]:
    """Draw signals to compare, and return their title rows, where more buttons can go.

    The cards appear at once; their pictures, on shared scales, follow when a thread has computed them. If units or
    domains differ, each signal has its own scales and a note. With ``same_gain``, strengths can be compared by ear;
    otherwise each signal is normalised. ``small`` omits the spectrum.
    """
    load_player()
    add_routes()
    frames = [_frame(entry) for entry in entries]
    cached = [SHOWN.cached(entry.source) for entry in entries]
    places = [container for _, container in frames]
    if all(signal is not None for signal in cached):
        _fill(entries, [signal for signal in cached if signal], places, same_gain=same_gain, small=small)
    else:
        for entry, container in zip(entries, places, strict=True):
            axes = len(entry.source.axes) if isinstance(entry.source, Signal) else USUAL_AXES
            with container:
                placeholder("Drawing …", axes=axes, small=small)

        async def fill() -> None:
            await _fill_later(entries, places, same_gain=same_gain, small=small)

        ui.timer(0, fill, once=True)
    return [top for top, _ in frames]


def placeholder(text: str, *, axes: int = USUAL_AXES, small: bool = False) -> None:
    """Draw a text as high as a signal's pictures, so that nothing below moves when they appear."""
    kit.hint(text).style(f"min-height: {card_height(axes, small=small)}px")


def _frame(entry: SignalEntry) -> tuple[ui.row, ui.element]:
    """Draw an empty card and return its title row and the place of its pictures."""
    card = ui.element("section").classes("card signal")
    with card.props(f'role="group" aria-label="{kit.attribute(entry.title)}"'):
        top = kit.title_row(entry.title, entry.simulated)
        container = ui.element("div").classes("pictures")
    return top, container


async def _fill_later(
    entries: Sequence[SignalEntry], places: Sequence[ui.element], *, same_gain: bool, small: bool
) -> None:
    """Fill cards once their signals are analysed, unless the page was closed or redrawn."""
    try:
        signals = [await kit.in_background(SHOWN.load, entry.source) for entry in entries]
    except Exception as error:
        for container in places:
            if not container.is_deleted:
                container.clear()
                with container:
                    ui.label(f"This signal cannot be shown: {error}").props('role="alert"')
        if not isinstance(error, TactogramError | OSError):
            raise
        return
    if not any(container.is_deleted for container in places):
        _fill(entries, signals, places, same_gain=same_gain, small=small)


def _fill(
    entries: Sequence[SignalEntry],
    signals: Sequence[ShownSignal],
    places: Sequence[ui.element],
    *,
    same_gain: bool,
    small: bool,
) -> None:
    comparable = len({(signal.traits.unit, signal.traits.domain) for signal in signals}) <= 1
    scales = scales_of([signal.traits for signal in signals]) if comparable else None
    gain = common_gain([signal.traits.peak for signal in signals]) if same_gain and comparable else None
    for entry, signal, container in zip(entries, signals, places, strict=True):
        others = [other.traits for other in signals if other is not signal] if comparable else []
        container.clear()
        with container:
            _pictures(entry, signal, scales or scales_of([signal.traits]), gain, None if small else others)
            if not comparable:
                kit.hint("Units or domains differ: this signal has its own scales.")


def _pictures(
    entry: SignalEntry,
    shown: ShownSignal,
    scales: SharedScales,
    gain: float | None,
    others: Sequence[SignalTraits] | None,
) -> None:
    """Draw a signal; ``others`` share its spectrum's scale, None omits the spectrum."""
    traits, title = shown.traits, entry.title
    ui.label(level_text(traits)).classes("small level")
    kit.hint(traits.note) if traits.felt else kit.alert(traits.note).classes("small")
    _play_button(shown, title=title, gain=gain, key=entry.key)
    description = f"Waveform of {title}: {level_text(traits)}"
    _chart(waveform_options(traits, scales=scales), waveform_height(traits), description)
    _spectrogram(shown, scales, title=title)
    if others is not None and len(traits.bands[0]) > 1:
        description = f"Spectrum of {title} in third octaves. {traits.note}"
        _chart(spectrum_options(traits, others=others), 200, description)


def level_text(traits: SignalTraits) -> str:
    """Return level and length of a signal in a line."""
    unit, unitless = (" ", " · no unit") if traits.unit == "1" else (f" {unit_text(traits.unit)} ", "")
    per = "Hz" if traits.domain == "time" else "per mm"
    extent = f"{traits.extent:.3g} {'s' if traits.domain == 'time' else 'mm'}"
    axes = f"axes {', '.join(traits.axes)}" if len(traits.axes) > 1 else f"axis {traits.axes[0]}"
    axes = axes.replace("axis dft321", "axes as one (DFT321)")
    return (
        f"{traits.rms:.3g}{unit}rms · {traits.peak:.3g}{unit}peak{unitless} · "
        f"{extent} at {traits.rate:,.6g} {per} · {axes}"
    )


def _play_button(shown: ShownSignal, *, title: str, gain: float | None, key: str) -> None:
    unit = unit_text(shown.traits.unit)
    address = f"/signals/{shown.key}/sound.wav" + ("" if gain is None else f"?gain={gain:.6g}")
    level = (
        f"normalised to a peak of {NORMAL_PEAK:g} of full scale"
        if gain is None
        else f"{gain:.3g} of full scale{'' if unit == 'no unit' else f' per {unit}'}, like the others"
    )
    if shown.traits.domain != "time":
        level += f", played at {PLAYBACK_MM_S:g} mm/s"
    with ui.row().classes("items-center gap-2 no-wrap"):
        button = ui.element("button").classes("player").props('type="button" aria-pressed="false"')
        button.props.update({"aria-label": f"Play {title}", "data-player-url": address})
        if key:
            button.props.update({"data-player-key": key, "aria-keyshortcuts": key})
        kit.hint(level)
        if not shown.traits.felt:
            ui.label(shown.traits.note.partition(":")[0].lower()).classes("small text-negative")
        status = ui.element("span").classes("small quiet")
        status.props.update({"data-player-status": address, "data-unit": unit})
    head = ui.element("div").classes("playhead").props('aria-hidden="true"')
    head.props["data-player-head"] = address


def load_player() -> None:
    """Load `static/player.js` into the current page, once, also after the page was sent."""
    client = ui.context.client
    if getattr(client, "tactogram_player", False):
        return
    client.tactogram_player = True  # type: ignore[attr-defined]
    ui.add_head_html(HEAD)
    if client.has_socket_connection:
        ui.run_javascript("import('/static/player.js')")


def _chart(options: dict[str, Any], height: int, description: str) -> None:
    chart = ui.echart(options).classes("w-full").style(f"height: {height}px")
    chart.props(f'role="img" aria-label="{kit.attribute(description)}"')


def draw_scale(top_db: float, unit: str, *, title: str = "") -> None:
    """Draw the bar of the colours of spectrograms, with their lowest and highest level."""
    with ui.element("div").classes("scale"):
        kit.hint(f"{title} {top_db - RANGE_DB:.0f}")
        ui.element("span").props('aria-hidden="true"')
        kit.hint(f"{top_db:.0f} dB re 1 {unit}".removesuffix(" no unit"))


def _spectrogram(shown: ShownSignal, scales: SharedScales, *, title: str) -> None:
    query = (
        f"peak={scales.peak:.6g}&extent={scales.extent:.9g}&top_db={scales.top_db:.6g}"
        f"&top_hz={scales.top_hz:.9g}"
    )
    unit = "Hz" if shown.traits.domain == "time" else "per mm"
    with ui.element("div").classes("spectrogram"):
        kit.hint(f"{scales.top_hz:.4g} {unit}").classes("top")
        kit.hint("0").classes("bottom")
        picture = ui.element("img").classes("w-full")
        picture.props["src"] = f"/signals/{shown.key}/spectrogram.png?{query}"
        extent = f"0 to {scales.top_hz:.4g} {unit}, brightest {scales.top_db:.0f} dB re 1 unit"
        picture.props["alt"] = f"Spectrogram of {title}, {extent}"
    draw_scale(scales.top_db, unit_text(shown.traits.unit))
