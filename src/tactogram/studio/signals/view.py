"""The card that shows a signal on every page: waveform, spectrogram, level, spectrum beside the threshold, and sound.

Pictures and sounds are fetched by the browser under ``/signals/KEY/…``, where KEY follows from the samples.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from tactogram.errors import TactogramError
from tactogram.signal import Signal
from tactogram.studio.layout import in_background, report_errors
from tactogram.studio.signals.pictures import (
    card_height,
    spectrogram_png,
    spectrum_options,
    waveform_height,
    waveform_options,
)
from tactogram.studio.signals.registry import SHOWN, ShownSignal, Source
from tactogram.studio.signals.sound import NORMAL_PEAK, WALKED_MM_S, common_gain, sound_of
from tactogram.studio.signals.traits import SharedScales, SignalTraits, scales_of, unit_of

HEAD = '<link rel="stylesheet" href="/static/signals.css"><script type="module" src="/static/player.js"></script>'


def add_routes() -> None:
    """Register where pictures and sounds of shown signals are fetched; a second call does nothing."""
    from fastapi import Response
    from nicegui import app

    if any(getattr(route, "path", "") == "/signals/{key}/sound.wav" for route in app.routes):
        return

    @app.get("/signals/{key}/sound.wav")
    def sound(key: str, gain: float | None = None) -> Response:
        try:
            made = sound_of(SHOWN.get(key).signal, gain=gain)
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
            traits = SHOWN.get(key).traits
        except TactogramError as error:
            return Response(str(error), status_code=404, media_type="text/plain")
        if not (extent > 0 and top_hz > 0 and math.isfinite(extent + top_hz + top_db + peak)):
            return Response("extent and top_hz must be > 0", status_code=400, media_type="text/plain")
        png = spectrogram_png(traits, scales=SharedScales(peak, extent, top_db, top_hz))
        return Response(png, media_type="image/png", headers=KEPT)


USUAL_AXES = 3
KEPT = {"Cache-Control": "private, max-age=3600"}
"""What follows from the samples alone may be kept by the browser."""


@dataclass(frozen=True)
class SignalEntry:
    """A signal that stands beside others.

    Parameters
    ----------
    source : Signal or Path
        A file is read as soon as the card stands, and once; it is not written anew.
    title : str
        What people call it.
    simulated : bool
        Whether it, or what it was learned from, is simulated: then it says so.
    key : str
        Of the keyboard that plays it, ``1`` to ``9``; several of a page are changed between while playing.
    """

    source: Source
    title: str
    simulated: bool = False
    key: str = ""


def signal_card(source: Source, *, title: str, simulated: bool = False, small: bool = False) -> Any:
    """Draw a signal, and return the row at its top that further buttons go into; see `signal_cards`."""
    [top] = signal_cards([SignalEntry(source, title, simulated)], small=small)
    return top


def signal_cards(
    entries: Sequence[SignalEntry], *, same_gain: bool = False, small: bool = False
) -> list[Any]:
    """Draw signals that stand beside each other, and return the rows at their tops that further buttons go into.

    The cards stand at once; their pictures, on the same scales, come as soon as a thread has worked them out. Signals
    of several units, or over time and displacement, are each on scales of their own, and it says so.

    Parameters
    ----------
    entries : sequence of Entry
    same_gain : bool
        Whether they are played at one gain, so that they keep their strengths; by default each at a level of its own.
    small : bool
        Whether the spectrum is left out.
    """
    from nicegui import ui

    load_player()
    add_routes()
    frames = [_frame(entry) for entry in entries]
    known = [SHOWN.known(entry.source) for entry in entries]
    places = [place for _, place in frames]
    if all(held is not None for held in known):
        _fill(entries, [held for held in known if held], places, same_gain=same_gain, small=small)
    else:
        for entry, place in zip(entries, places, strict=True):
            with place:
                waiting("Drawing", axes=_axes_of(entry.source), small=small)

        async def fill() -> None:
            await _fill_later(entries, places, same_gain=same_gain, small=small)

        ui.timer(0, report_errors(fill), once=True)
    return [top for top, _ in frames]


def waiting(words: str, *, axes: int = USUAL_AXES, small: bool = False) -> None:
    """Say that a signal's pictures come, in the room that they will take: what stands below does not move."""
    from nicegui import ui

    height = card_height(axes, small=small)
    ui.label(words).classes("small quiet").style(f"min-height: {height}px")


def _axes_of(source: Source) -> int:
    """Return how many axes a source has; of a file, before it is read, the usual number."""
    return len(source.axes) if isinstance(source, Signal) else USUAL_AXES


def _frame(entry: SignalEntry) -> tuple[Any, Any]:
    """Draw the card as it stands at once, and return the row at its top and the place of its pictures."""
    from nicegui import ui

    with (
        ui.element("section")
        .classes("card signal")
        .props(f'role="group" aria-label="{_quoted(entry.title)}"')
    ):
        with ui.row().classes("w-full items-center gap-2") as top:
            ui.label(entry.title).classes("h2")
            if entry.simulated:
                ui.label("simulated").classes("simulated")
        place = ui.element("div").classes("pictures")
    return top, place


async def _fill_later(
    entries: Sequence[SignalEntry], places: Sequence[Any], *, same_gain: bool, small: bool
) -> None:
    """Fill cards once their signals are worked out; nothing, if the page was left or drawn anew meanwhile."""
    from nicegui import ui

    try:
        held = [await in_background(SHOWN.load, entry.source) for entry in entries]
    except Exception as error:
        for place in places:
            if not place.is_deleted:
                place.clear()
                with place:
                    ui.label(f"It cannot be shown: {error}").props('role="alert"')
        if not isinstance(error, TactogramError | OSError):
            raise
        return
    if not any(place.is_deleted for place in places):
        _fill(entries, held, places, same_gain=same_gain, small=small)


def _fill(
    entries: Sequence[SignalEntry],
    held: Sequence[ShownSignal],
    places: Sequence[Any],
    *,
    same_gain: bool,
    small: bool,
) -> None:
    """Draw what is known of signals into their places."""
    from nicegui import ui

    alike = len({(one.traits.unit, one.traits.domain) for one in held}) <= 1
    scales = scales_of([one.traits for one in held]) if alike else None
    gain = common_gain([one.traits.peak for one in held]) if same_gain and alike else None
    for entry, one, place in zip(entries, held, places, strict=True):
        others = [other.traits for other in held if other is not one] if alike else []
        place.clear()
        with place:
            _pictures(entry, one, scales or scales_of([one.traits]), gain, None if small else others)
            if not alike:
                ui.label("Another unit, or over something else: drawn on scales of its own.").classes(
                    "small quiet"
                )


def _pictures(
    entry: SignalEntry,
    held: ShownSignal,
    scales: SharedScales,
    gain: float | None,
    beside: Sequence[SignalTraits] | None,
) -> None:
    from nicegui import ui

    traits, title = held.traits, entry.title
    ui.label(level_text(traits)).classes("small level")
    ui.label(traits.note).classes("small quiet")
    play_button(held, title=title, gain=gain, key=entry.key)
    described = f"Waveform of {title}: {level_text(traits)}"
    _chart(waveform_options(traits, scales=scales), waveform_height(traits), described)
    _spectrogram(held.key, scales, over_time=traits.domain == "time", title=title)
    if beside is not None:
        described = f"Spectrum of {title} in third octaves. {traits.note}"
        _chart(spectrum_options(traits, others=beside), 200, described)


def level_text(traits: SignalTraits) -> str:
    """Return how strong and how long a signal is, in words."""
    unit = unit_of(traits)
    per = "Hz" if traits.domain == "time" else "per mm"
    extent = f"{traits.extent:.3g} {'s' if traits.domain == 'time' else 'mm'}"
    axes = f"axes {', '.join(traits.axes)}" if len(traits.axes) > 1 else f"axis {traits.axes[0]}"
    return (
        f"{traits.rms:.3g} {unit} rms · {traits.peak:.3g} {unit} peak · "
        f"{extent} at {traits.rate:,.6g} {per} · {axes}"
    )


def play_button(held: ShownSignal, *, title: str, gain: float | None = None, key: str = "") -> None:
    """Draw the button that plays a held signal, and where its level is told."""
    from nicegui import ui

    unit = unit_of(held.traits)
    address = f"/signals/{held.key}/sound.wav" + ("" if gain is None else f"?gain={gain:.6g}")
    how = (
        f"level of its own: peaks at {NORMAL_PEAK:g} of full scale"
        if gain is None
        else f"{gain:.3g} of full scale per {unit}, as the others"
    )
    if held.traits.domain != "time":
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


def _spectrogram(held: str, scales: SharedScales, *, over_time: bool, title: str) -> None:
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
