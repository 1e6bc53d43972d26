"""Files that a browser sends: a field to drop one on, or a button that opens one."""

from __future__ import annotations

import html
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

from nicegui import ui

from tactogram_studio.kit.cards import attribute

CHOOSER = """<div class="chooser">
<span>{text}</span>
<q-btn outline label="Choose a file" aria-label="Choose a file: {text}" @click="props.pickFiles" />
<span hidden><q-uploader-add-trigger /></span>
</div>"""
"""Replaces the button of Quasar's uploader, which is a link around an input, without an accessible name."""
Take = Callable[[str, bytes], Awaitable[Any]]
"""What is done with a file, by its name and content."""


def file_field(
    text: str, take: Take, *, accept: Sequence[str] = (), most_mib: int | None = None, refused: str = ""
) -> ui.upload:
    """Draw a field with a prompt where a file is dropped or chosen.

    ``accept`` are the suffixes of files that it takes; others, and larger ones, are refused with a text.
    """
    field = _upload(take, refused or f"The file must have at most {most_mib} MiB.", most_mib)
    if accept:
        field.props(f'accept="{",".join(accept)}"')
    field.add_slot("header", CHOOSER.format(text=html.escape(text)))
    return field.props("flat bordered").classes("w-full")


def file_button(text: str, take: Take, *, accept: str = "", refused: str = "", marks: str = "") -> ui.upload:
    """Draw a button that opens a file, as often as one likes; ``marks`` are properties of the hidden field.

    ``accept`` is as that of an input element. Without a text, there is no button, but that of the page.
    """
    field = _upload(take, refused, None).classes("hidden").props(f'accept="{attribute(accept)}" {marks}')
    if text:
        button = ui.button(text).props("outline dense")
        button.on("click", js_handler=f"() => getElement({field.id}).$refs.qRef.pickFiles()")
    return field


def _upload(take: Take, refused: str, most_mib: int | None) -> ui.upload:
    async def taken(event: Any) -> None:
        name, data = event.file.name, await event.file.read()
        field.reset()
        await take(name, data)

    most = None if most_mib is None else most_mib * 2**20
    field = ui.upload(auto_upload=True, on_upload=taken, max_file_size=most)
    return field.on("rejected", lambda: ui.notify(refused or "This file cannot be used.", type="negative"))
