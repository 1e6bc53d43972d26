"""Choice of a signal of the workspace: a kept result, a file, or a recording of a store."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from tactogram_studio.workspace.sources import SignalSources

KINDS = {
    "kept": ("Kept result", "No kept results yet: generate one on the page Make and keep it."),
    "file": ("File", "No signal files in this workspace."),
    "recording": ("Store", "No store in this workspace yet."),
}
"""Label and text of an empty list, by kind of signal."""


def signal_choice(sources: SignalSources, kind: str, take: Callable[[str], Any], *, last: str = "") -> None:
    """Draw the choice of a signal of a kind, or of its store and then the recording.

    ``take`` is called with the id of the signal (see `SignalSources.select`); ``last`` is the id that was chosen last.
    """
    label, empty = KINDS[kind]
    if kind != "recording":
        option_choice(
            sources.kept() if kind == "kept" else sources.files(), label, take, empty=empty, last=last
        )
        return

    def recordings(store: str) -> None:
        place.clear()
        with place:
            option_choice(
                sources.recordings(store), "Recording", take, empty="This store is empty.", last=last
            )

    stores = sources.stores()
    first = last.removeprefix("recording:").partition("#")[0]
    first = first if first in stores else next(iter(stores), "")
    option_choice(stores, label, recordings, empty=empty, last=first)
    place = ui.column().classes("w-full")
    if first:
        recordings(first)


def option_choice(
    options: Mapping[str, str], label: str, take: Callable[[str], Any], *, empty: str = "", last: str = ""
) -> ui.select | None:
    """Draw a choice that calls ``take`` with each value; a text if there is none."""
    if not options:
        ui.label(empty).classes("quiet")
        return None
    value = last if last in options else None
    select = ui.select(dict(options), label=label, value=value, with_input=len(options) > 12)
    select.on_value_change(lambda event: take(event.value) if event.value else None)
    return select.props("dense options-dense").classes("w-full")
