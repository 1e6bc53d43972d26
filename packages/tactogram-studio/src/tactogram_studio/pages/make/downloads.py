"""Downloads of a result: as WAV or another format of signals, or as a haptic file."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from nicegui import ui

from tactogram.rendering import file_name, haptic_formats
from tactogram.workflows import SIGNAL_FORMATS, convert, list_formats
from tactogram_studio.layout import attribute, busy, in_background, report_errors
from tactogram_studio.signals.sound import PLAYBACK_MM_S
from tactogram_studio.workspace.shelf import KeptResult


def draw_download(name: str, result: KeptResult) -> None:
    """Draw the button with the formats of a result, which is called ``name`` in addresses."""

    async def download(format: str) -> None:
        with busy(f"Writing {format}"):
            file, data, loss = await in_background(encoded, result, format)
        ui.download.content(data, file)
        if loss:
            ui.notify(f"{file} {loss}.")

    button = ui.button("Download").props(
        f'no-caps dense flat aria-label="Download {attribute(result.title)}"'
    )
    if result.is_image:
        where, _, id = name.partition(":")
        address, file = f"/make/image/{where}/{id}", f"{_stem(result)}.png"
        button.on_click(lambda: ui.download.from_url(address, file))
        return
    with button, ui.menu():
        for format, title in titles().items():
            ui.menu_item(title, report_errors(partial(download, format))).props('role="menuitem"')


def titles() -> dict[str, str]:
    """Return the titles of the formats by name."""
    haptic = {name: f"{kind.title} ({kind.suffix})" for name, kind in haptic_formats().items()}
    return {format: format.upper() for format in SIGNAL_FORMATS} | haptic


def encoded(result: KeptResult, format: str) -> tuple[str, bytes, str]:
    """Return a result as a file: its name, its bytes, and what a haptic file keeps and loses.

    Raises
    ------
    TactogramError
        If the format cannot hold it.
    """
    suffix, haptic = list_formats()[format]["suffix"], format in haptic_formats()
    name = file_name(_stem(result), format) if haptic else f"{_stem(result)}{suffix}"
    over_time = result.signal().domain == "time"
    speed = PLAYBACK_MM_S if haptic and not over_time else None
    with TemporaryDirectory() as folder:
        path = Path(folder) / name
        facts = convert(result.file, path, format=format, play_at=speed)
        return name, path.read_bytes(), _sentence(facts["written"], speed) if haptic else ""


def _sentence(written: Mapping[str, Any], speed_mm_s: float | None) -> str:
    """Return what a haptic file keeps and loses, of several axes the first, and the verdict on all."""
    played = "" if speed_mm_s is None else f" Played at {speed_mm_s:g} mm/s."
    return f"{written['told'][0]}{played} Verdict: {written['verdict']}"


def _stem(result: KeptResult) -> str:
    return re.sub(r"[^A-Za-z0-9_-]+", "-", result.title)[:40].strip("-") or "touch"
