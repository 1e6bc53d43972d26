"""Files that the form of the page Make goes by: the photograph and its crop, the vibration to start from."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nicegui import ui

from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.io import write_image, write_signal
from tactogram.studio.layout import in_background, report_errors
from tactogram.studio.pages.make.form import Crop
from tactogram.studio.workspace.uploads import read_uploaded_image, read_uploaded_signal, safe_name

if TYPE_CHECKING:
    from tactogram.studio.pages.make.page import MakePage

MOST_SIDE = 4096
"""Pixels of a photograph's longer side that are kept; models take far fewer."""
MOST_OFFERED = 200
"""Recordings of a store that are offered."""


def draw_photo(on: MakePage) -> None:
    """Draw where a photograph is dropped, pasted, chosen or taken, and the chosen one with its crop."""

    async def uploaded(event: Any) -> None:
        data = await event.file.read()
        upload.reset()
        name = await in_background(store_photo, on.desk.photographs(), event.file.name, data)
        on.desk.set(photo=on.desk.workspace.name_of(on.desk.photographs() / name), crop=None)
        on.committed(redraw=True)

    upload = ui.upload(on_upload=report_errors(uploaded), auto_upload=True, max_files=None)
    upload.on(
        "rejected", report_errors(lambda: ui.notify("That is no picture this page takes.", type="negative"))
    )
    upload.classes("hidden").props('accept="image/*" data-photo-upload="1"')
    with (
        ui.element("div")
        .classes("drop")
        .props(f'data-drop="{upload.id}" role="group" aria-label="Photograph of the surface"')
    ):
        if on.desk.asked.photo:
            _chosen(on)
        else:
            ui.label("Drop a photograph here, or paste one (Ctrl+V).").classes("quiet")
        with ui.row().classes("gap-2"):
            choose = ui.button("Choose a file").props("no-caps outline dense")
            choose.on("click", js_handler=f"() => window.tactogramMake.choose({upload.id})")
            camera = ui.button("Camera").props("no-caps outline dense")
            camera.on("click", js_handler=f"() => window.tactogramMake.camera({upload.id})")
            if on.desk.asked.photo:
                ui.button("Take away", on_click=report_errors(lambda: _without_photo(on))).props(
                    "no-caps flat dense"
                )
        ui.element("div").props('data-camera role="status"').classes("camera")


def _without_photo(on: MakePage) -> None:
    on.desk.set(photo="", crop=None)
    on.committed(redraw=True)


def _chosen(on: MakePage) -> None:
    asked = on.desk.asked
    name = Path(asked.photo).name
    left, top, right, bottom = asked.crop or (0.0, 0.0, 1.0, 1.0)

    def crop_to(crop: Crop | None) -> None:
        on.desk.set(crop=crop)
        on.committed(redraw=True)

    def dragged(event: Any) -> None:
        box = [min(1.0, max(0.0, float(event.args[k]))) for k in ("left", "top", "right", "bottom")]
        if box[2] - box[0] < 0.02 or box[3] - box[1] < 0.02:
            return
        crop_to((round(box[0], 4), round(box[1], 4), round(box[2], 4), round(box[3], 4)))

    place = ui.element("div").classes("crop").props("data-crop")
    place.on("make-crop", report_errors(dragged), js_handler="(event) => emit(event.detail)")
    with place:
        ui.element("img").props(
            f'src="/make/photo/{name}" alt="The chosen photograph; drag over it to choose a part" draggable="false"'
        )
        box = ui.element("div").classes("crop-box").props("data-crop-box")
        box.style(
            f"left: {100 * left:.2f}%; top: {100 * top:.2f}%; width: {100 * (right - left):.2f}%; "
            f"height: {100 * (bottom - top):.2f}%"
        )
        if asked.crop is None:
            box.classes("whole")
    with ui.element("details"):
        with ui.element("summary"):
            ui.label("Part of the photograph, in percent").classes("in-line small")
        _edges(on, [left, top, right, bottom], crop_to)
    if asked.crop is not None:
        ui.button("The whole photograph", on_click=report_errors(lambda: crop_to(None))).props(
            "no-caps flat dense"
        )
    else:
        ui.label("Drag over it to take a part.").classes("small quiet")


def _edges(on: MakePage, edges: list[float], crop_to: Any) -> None:
    """Draw the crop as four numbers, for those who do not drag."""
    values = [round(100 * edge, 1) for edge in edges]

    def take() -> None:
        if any(value is None for value in values):
            raise ParameterError("All four edges are needed, in percent.")
        left, top, right, bottom = (float(value) / 100 for value in values)
        if not (0 <= left < right <= 1 and 0 <= top < bottom <= 1):
            raise ParameterError("Left must be less than right and top less than bottom, from 0 to 100.")
        crop_to((left, top, right, bottom))

    def changed(number: int, value: Any) -> None:
        values[number] = value

    with ui.row().classes("gap-2 items-center"):
        for number, name in enumerate(("Left", "Top", "Right", "Bottom")):
            field = ui.number(name, value=values[number], min=0, max=100)
            field.on_value_change(lambda event, number=number: changed(number, event.value))
            field.props("outlined dense").style("width: 5rem")
        ui.button("Take this part", on_click=report_errors(take)).props("no-caps outline dense")


def store_photo(folder: Path, name: str, data: bytes) -> str:
    """Keep an uploaded picture as PNG under a name that follows from its pixels, and return that name.

    Raises
    ------
    DataError, ParameterError
        If it is no picture, or too large.
    """
    image = _smaller(read_uploaded_image(name, data))
    digest = hashlib.sha256(image.pixels.tobytes()).hexdigest()[:8]
    kept = f"{Path(safe_name(name)).stem[:60]}-{digest}.png"
    if not (folder / kept).is_file():
        write_image(folder / kept, image)
    return kept


def _smaller(image: Image) -> Image:
    """Return an image whose longer side is at most `MOST_SIDE`."""
    longest = max(image.size)
    if longest <= MOST_SIDE:
        return image
    import numpy as np
    from PIL import Image as Pillow

    rows, columns = (max(1, round(side * MOST_SIDE / longest)) for side in image.size)
    picture = Pillow.fromarray(np.asarray(image.pixels), "RGB").resize(
        (columns, rows), Pillow.Resampling.LANCZOS
    )
    return Image(np.asarray(picture))


# -- vibration -------------------------------------------------------------------------------------------


def draw_vibration(on: MakePage) -> None:
    """Draw where the vibration that a model starts from is chosen: kept, uploaded, or a recording."""
    desk = on.desk
    kept = {
        f"studio/kept/{made.id}/signal.npz": f"kept: {made.title}"
        for made in desk.shelf.all()
        if not made.is_image
    }
    files = {
        desk.workspace.name_of(path): f"file: {path.stem}"
        for path in sorted(desk.vibrations().glob("[!.]*.npz"))
    }
    options = {"": "None: the model draws one from the seed", **files, **kept}
    if desk.asked.vibration and desk.asked.vibration not in options:
        options[desk.asked.vibration] = desk.asked.vibration

    def choose(event: Any) -> None:
        desk.set(vibration=event.value or "")
        on.committed()

    select = ui.select(
        options, value=desk.asked.vibration, label="Vibration", on_change=report_errors(choose)
    )
    select.classes("w-full").props("outlined dense options-dense")

    async def uploaded(event: Any) -> None:
        data = await event.file.read()
        upload.reset()
        signal = await in_background(read_uploaded_signal, event.file.name, data)
        _put(on, Path(safe_name(event.file.name)).stem, signal)

    upload = ui.upload(on_upload=report_errors(uploaded), auto_upload=True).classes("hidden")
    with ui.row().classes("gap-2"):
        button = ui.button("Upload a recording").props("no-caps outline dense")
        button.on("click", js_handler=f"() => window.tactogramMake.choose({upload.id})")
        ui.button("From a data set", on_click=report_errors(lambda: _from_store(on))).props(
            "no-caps outline dense"
        )


def _put(on: MakePage, name: str, signal: Signal) -> None:
    """Keep a vibration as a file that the command line can name, and choose it."""
    digest = hashlib.sha256(signal.samples.tobytes()).hexdigest()[:8]
    path = on.desk.vibrations() / f"{name[:60]}-{digest}.npz"
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_signal(path, signal)
    on.desk.set(vibration=on.desk.workspace.name_of(path))
    on.committed(redraw=True)


async def _from_store(on: MakePage) -> None:
    """Ask for a recording of the run's data."""
    choice = on.desk.choice
    store = None if choice is None else await in_background(on.desk.runs.store_of, choice)
    if store is None:
        raise DataError("The data that this run learned from is not in this workspace.")
    infos = list(store.index)[:MOST_OFFERED]
    titles = {info.id: f"{info.material or info.source or 'recording'} · {info.id[:8]}" for info in infos}
    with ui.dialog().props('aria-label="A recording of the data"') as dialog, ui.card():
        ui.label(f"A recording of {store.name}").classes("h2")
        chosen = ui.select(titles, label="Recording", with_input=True).props("outlined dense")
        chosen.classes("w-80")
        with ui.row():
            ui.button("Take it", on_click=lambda: dialog.submit(chosen.value)).props("no-caps unelevated")
            ui.button("Cancel", on_click=lambda: dialog.submit(None)).props("no-caps flat")
    id = await dialog
    if id:
        signal = await in_background(store.signal, id, store.streams_of(id)[0])
        _put(on, f"{store.info(id).material or 'recording'}-{id[:8]}", signal)
