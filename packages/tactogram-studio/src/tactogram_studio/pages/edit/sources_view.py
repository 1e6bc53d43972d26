"""Cards to begin from: ready effects, kept results, and haptic files."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from nicegui import ui

from tactogram.errors import DataError
from tactogram.rendering import to_one_axis
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.effects.effect import Track, effect_from_json, track_of, track_of_signal
from tactogram_studio.effects.library import ready_effects
from tactogram_studio.pages.edit.exports import WrittenFile, WrittenFiles
from tactogram_studio.workspace.shelf import SignalSources

MOST_MIB = 32
EFFECT = "effect"
"""Fact of a kept result that holds the effect it was made of."""
Insert = Callable[[tuple[Track, ...], bool], None]


def draw_sources(
    studio: Studio,
    files: WrittenFiles,
    insert: Insert,
    *,
    of: str,
    audition: Callable[[WrittenFile], None],
) -> None:
    """Draw the cards; ``insert`` adds tracks at the cursor, ``audition`` shows a file.

    ``of`` is the id of a signal to begin with, or empty.
    """
    sources = SignalSources(studio.workspace, studio.shelf)

    async def add_signal(identifier: str) -> None:
        tracks, simulated = await kit.in_background(tracks_from, studio, sources, identifier)
        insert(tracks, simulated)

    async def opened(name: str, data: bytes) -> None:
        file, content = await kit.in_background(files.upload, name, data)
        audition(file)  # also of one that is too long to be edited
        if content.events is None:
            track = await kit.in_background(track_of_signal, to_one_axis(content.signal)[0], file.title)
        else:
            track = await kit.in_background(track_of, content.events, file.title)
        insert((track,), file.simulated)

    with kit.card("Ready effects", classes="w-full edit-card"):
        kit.hint("Each becomes a track at the cursor.")
        with ui.element("div").classes("edit-ready"):
            for title, ready in ready_effects().items():
                button = ui.button(title, on_click=partial(insert, (ready.track,), False))
                button.props("outline dense").tooltip(ready.about)
    with kit.card("Results and files", classes="w-full edit-card"):
        kit.signal_choice(sources, "kept", add_signal)
        kit.file_field("A haptic file: AHAP, .haptic, HJIF, JSON", opened, most_mib=MOST_MIB)
    if of:
        ui.timer(0.05, partial(add_signal, of), once=True)


def tracks_from(studio: Studio, sources: SignalSources, identifier: str) -> tuple[tuple[Track, ...], bool]:
    """Return a signal of the workspace as tracks, those of a kept effect as they were, and whether it is simulated."""
    if identifier.startswith("kept:"):
        facts = studio.shelf.get(identifier.removeprefix("kept:")).facts
        if isinstance(text := facts.get(EFFECT), str):
            effect = effect_from_json(text, where="the kept result's effect")
            if not effect.tracks:
                raise DataError("the kept result's effect is empty")
            return effect.tracks, effect.simulated
    selected = sources.select(identifier)
    return (track_of_signal(selected.signal(), selected.title),), selected.simulated
