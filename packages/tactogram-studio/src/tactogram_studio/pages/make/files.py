"""Files of the page Make's form: the photograph with its crop, the vibration, and the motion."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from nicegui import ui
from PIL import Image as Pillow

from tactogram.errors import DataError, ParameterError
from tactogram.rendering import MotionFile
from tactogram.signal import Image, Signal
from tactogram.signal.io import atomic_write, write_image, write_signal
from tactogram_studio.layout import heading, hint, in_background, report_errors
from tactogram_studio.pages.make.form import Crop
from tactogram_studio.workspace.uploads import (
    check_upload,
    read_uploaded_image,
    read_uploaded_signal,
    safe_name,
)

if TYPE_CHECKING:
    from tactogram_studio.pages.make.page import MakePage

MOST_SIDE = 4096
"""Longest side of a stored photograph, pixels; models use far fewer."""
MOST_OFFERED = 200
"""Recordings of a store to choose from."""


def draw_photo(page: MakePage) -> None:
    """Draw the field where a photograph is dropped, pasted, chosen or taken, and the photograph with its crop."""
    state = page.state

    async def uploaded(event: Any) -> None:
        data = await event.file.read()
        upload.reset()
        name = await in_background(store_photo, state.photographs, event.file.name, data)
        choose(state.workspace.name_of(state.photographs / name))

    def choose(photo: str) -> None:
        state.set(photo=photo, crop=None)
        page.committed(redraw=True)

    upload = ui.upload(on_upload=report_errors(uploaded), auto_upload=True, max_files=None)
    upload.on("rejected", lambda: ui.notify("This file is not a supported picture.", type="negative"))
    upload.classes("hidden").props('accept="image/*" data-photo-upload="1"')
    area = ui.element("div").classes("drop")
    area.props(f'data-drop="{upload.id}" role="group" aria-label="Photograph of the surface"')
    with area:
        if state.request.photo:
            _draw_chosen(page)
        else:
            ui.label("Drop a photograph here, or paste one (Ctrl+V).").classes("quiet")
        with ui.row().classes("gap-2"):
            for label, action in (("Choose a file", "choose"), ("Camera", "camera")):
                button = ui.button(label).props("no-caps outline dense")
                button.on("click", js_handler=f"() => window.tactogramMake.{action}({upload.id})")
            if state.request.photo:
                remove = ui.button("Remove", on_click=report_errors(lambda: choose("")))
                remove.props("no-caps flat dense")
        ui.element("div").props('data-camera role="status"').classes("camera")


def _draw_chosen(page: MakePage) -> None:
    request = page.state.request
    left, top, right, bottom = request.crop or (0.0, 0.0, 1.0, 1.0)

    def crop_to(crop: Crop | None) -> None:
        page.state.set(crop=crop)
        page.committed(redraw=True)

    def dragged(event: Any) -> None:
        edges = [min(1.0, max(0.0, float(event.args[k]))) for k in ("left", "top", "right", "bottom")]
        left, top, right, bottom = (round(edge, 4) for edge in edges)
        if right - left >= 0.02 and bottom - top >= 0.02:
            crop_to((left, top, right, bottom))

    place = ui.element("div").classes("crop").props("data-crop")
    place.on("make-crop", report_errors(dragged), js_handler="(event) => emit(event.detail)")
    with place:
        ui.element("img").props(
            f'src="/make/photo/{Path(request.photo).name}" draggable="false" '
            'alt="Selected photograph; drag over it to crop"'
        )
        box = ui.element("div").classes("crop-box").props("data-crop-box")
        box.style(
            f"left: {100 * left:.2f}%; top: {100 * top:.2f}%; width: {100 * (right - left):.2f}%; "
            f"height: {100 * (bottom - top):.2f}%"
        )
        if request.crop is None:
            box.classes("whole")
    with ui.element("details"):
        with ui.element("summary"):
            ui.label("Crop in percent").classes("in-line small")
        _draw_edges([left, top, right, bottom], crop_to)
    if request.crop is not None:
        whole = ui.button("Use the whole photograph", on_click=report_errors(lambda: crop_to(None)))
        whole.props("no-caps flat dense")
    else:
        hint("Drag over the photograph to crop it.")


def _draw_edges(edges: list[float], crop_to: Any) -> None:
    """Draw the crop as four numbers, an alternative to dragging."""

    def apply() -> None:
        values = [field.value for field in numbers]
        if any(value is None for value in values):
            raise ParameterError("Enter all four edges, in percent.")
        left, top, right, bottom = (float(value) / 100 for value in values)
        if not (0 <= left < right <= 1 and 0 <= top < bottom <= 1):
            raise ParameterError("Left must be less than right and top less than bottom, from 0 to 100.")
        crop_to((left, top, right, bottom))

    with ui.row().classes("gap-2 items-center"):
        numbers = [
            ui.number(name, value=round(100 * edge, 1), min=0, max=100)
            .props("outlined dense")
            .style("width: 5rem")
            for name, edge in zip(("Left", "Top", "Right", "Bottom"), edges, strict=True)
        ]
        ui.button("Crop", on_click=report_errors(apply)).props("no-caps outline dense")


def store_photo(folder: Path, name: str, data: bytes) -> str:
    """Store an uploaded picture as PNG under a name with a hash of its pixels, and return the name.

    Raises
    ------
    DataError, ParameterError
        If it is not a picture, or too large.
    """
    image = _limited(read_uploaded_image(name, data))
    digest = hashlib.sha256(image.pixels.tobytes()).hexdigest()[:8]
    stored = f"{Path(safe_name(name)).stem[:60]}-{digest}.png"
    if not (folder / stored).is_file():
        write_image(folder / stored, image)
    return stored


def _limited(image: Image) -> Image:
    """Return an image scaled to at most `MOST_SIDE` on its longer side."""
    if max(image.size) <= MOST_SIDE:
        return image
    picture = Pillow.fromarray(image.pixels)
    picture.thumbnail((MOST_SIDE, MOST_SIDE), Pillow.Resampling.LANCZOS)
    return Image(np.asarray(picture))


# -- vibration -------------------------------------------------------------------------------------------


def draw_vibration(page: MakePage) -> None:
    """Draw the choice of a vibration: a kept result, an upload, or a recording of the training data."""
    state = page.state
    form = state.form
    drawn = form is not None and "vibration" in form.takes
    options = {"": "none (the model draws one from the seed)" if drawn else "none"}
    for path in sorted(state.vibrations.glob("[!.]*.npz")):
        options[state.workspace.name_of(path)] = f"file: {path.stem}"
    for result in state.shelf.all():
        if not result.is_image:
            options[f"studio/kept/{result.id}/signal.npz"] = f"kept: {result.title}"
    chosen = state.request.vibration
    options.setdefault(chosen, chosen)

    def choose(event: Any) -> None:
        state.set(vibration=event.value or "")
        page.committed(redraw=not drawn)

    select = ui.select(options, value=chosen, label="Vibration", on_change=report_errors(choose))
    select.classes("w-full").props("outlined dense options-dense")

    async def uploaded(event: Any) -> None:
        data = await event.file.read()
        upload.reset()
        signal = await in_background(read_uploaded_signal, event.file.name, data)
        _use_vibration(page, Path(safe_name(event.file.name)).stem, signal)

    upload = ui.upload(on_upload=report_errors(uploaded), auto_upload=True).classes("hidden")
    with ui.row().classes("gap-2"):
        button = ui.button("Upload a recording").props("no-caps outline dense")
        button.on("click", js_handler=f"() => window.tactogramMake.choose({upload.id})")
        if not (state.run and state.run.ships):
            training = ui.button(
                "From the training data", on_click=report_errors(lambda: _ask_recording(page))
            )
            training.props("no-caps outline dense")


def _use_vibration(page: MakePage, name: str, signal: Signal) -> None:
    """Store a vibration as a file, so that a command can refer to it, and choose it."""
    digest = hashlib.sha256(signal.samples.tobytes()).hexdigest()[:8]
    path = page.state.vibrations / f"{name[:60]}-{digest}.npz"
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_signal(path, signal)
    page.state.set(vibration=page.state.workspace.name_of(path))
    page.committed(redraw=True)


async def _ask_recording(page: MakePage) -> None:
    """Ask for a recording of the run's training data, and use it."""
    run = page.state.run
    store = None if run is None else await in_background(page.state.runs.store_of, run)
    if store is None:
        raise DataError("The training data of this run is not in this workspace.")
    infos = list(store.index)[:MOST_OFFERED]
    titles = {info.id: f"{info.material or info.source or 'recording'} · {info.id[:8]}" for info in infos}
    with ui.dialog().props('aria-label="Recording of the training data"') as dialog, ui.card():
        heading(f"Recording of {store.name}")
        chosen = ui.select(titles, label="Recording", with_input=True).props("outlined dense")
        chosen.classes("w-80")
        with ui.row():
            ui.button("Use", on_click=lambda: dialog.submit(chosen.value)).props("no-caps unelevated")
            ui.button("Cancel", on_click=lambda: dialog.submit(None)).props("no-caps flat")
    id = await dialog
    if id:
        signal = await in_background(store.signal, id, store.streams_of(id)[0])
        _use_vibration(page, f"{store.info(id).material or 'recording'}-{id[:8]}", signal)


# -- motion ----------------------------------------------------------------------------------------------


def draw_motion(page: MakePage) -> None:
    """Draw the choice of a motion: none, that of a simulated hand, or an uploaded one."""
    state = page.state
    options = {"": "none: one speed and force", "simulated": "a simulated hand"}
    for path in sorted(state.motions.glob("[!.]*.csv")):
        options[state.workspace.name_of(path)] = f"file: {path.stem}"
    options.setdefault(state.request.motion, state.request.motion)

    def choose(motion: str) -> None:
        state.set(motion=motion)
        page.committed(redraw=True)

    select = ui.select(options, value=state.request.motion, label="Motion")
    select.on_value_change(report_errors(lambda event: choose(event.value or "")))
    select.classes("w-full").props('outlined dense options-dense data-motion="1"')

    async def uploaded(event: Any) -> None:
        data = await event.file.read()
        upload.reset()
        name = await in_background(store_motion, state.motions, event.file.name, data)
        choose(state.workspace.name_of(state.motions / name))

    upload = ui.upload(on_upload=report_errors(uploaded), auto_upload=True).classes("hidden")
    upload.props('accept=".csv" data-motion-upload="1"')
    with ui.row():
        button = ui.button("Upload a motion").props("no-caps outline dense")
    button.on("click", js_handler=f"() => window.tactogramMake.choose({upload.id})")
    hint("The surface follows its speed and force, and is silent where the finger rests or is lifted.")


def store_motion(folder: Path, name: str, data: bytes) -> str:
    """Store an uploaded motion under a name with a hash, and return the name.

    Raises
    ------
    DataError
        If it is not a motion file.
    """
    name = check_upload(name, data, kind="signal")
    stored = f"{Path(safe_name(name)).stem[:60]}-{hashlib.sha256(data).hexdigest()[:8]}.csv"
    with atomic_write(folder / stored) as part:
        part.write_bytes(data)
        try:
            MotionFile(part)
        except DataError as error:
            raise DataError(str(error).replace(str(part), name)) from None
    return stored
