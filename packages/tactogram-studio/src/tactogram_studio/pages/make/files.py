"""Files of the page Make's form: the photograph with its crop, the vibration, and the motion."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nicegui import ui

from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal
from tactogram_studio import kit
from tactogram_studio.generation.files import store_motion, store_photo, store_vibration
from tactogram_studio.generation.form import Crop
from tactogram_studio.generation.state import MakePageState
from tactogram_studio.workspace.uploads import read_uploaded_signal

MOST_OFFERED = 200
"""Recordings of a store to choose from."""


def draw_photo(state: MakePageState) -> None:
    """Draw the field where a photograph is dropped, pasted, chosen or taken, and the photograph with its crop."""

    async def uploaded(name: str, data: bytes) -> None:
        stored = await kit.in_background(store_photo, state.photographs, name, data)
        state.change(image=state.workspace.name_of(state.photographs / stored), crop=None)

    upload = kit.file_button(
        "",
        uploaded,
        accept="image/*",
        refused="This file is not a supported picture.",
        marks="data-photo-upload=1",
    )
    area = ui.element("div").classes("drop")
    area.props(f'data-drop="{kit.attribute(upload.id)}" role="group" aria-label="Photograph of the surface"')
    with area:
        if "image" in state.request.values:
            _draw_chosen(state)
        else:
            ui.label("Drop a photograph here, or paste one (Ctrl+V).").classes("quiet")
        with ui.row().classes("gap-2"):
            for label, action in (("Choose a file", "choose"), ("Camera", "camera")):
                button = ui.button(label).props("outline dense")
                button.on("click", js_handler=f"() => window.tactogramMake.{action}({upload.id})")
            if "image" in state.request.values:
                ui.button("Remove", on_click=lambda: state.change(image="", crop=None)).props("flat dense")
        ui.element("div").props('data-camera role="status"').classes("camera")


def _draw_chosen(state: MakePageState) -> None:
    request = state.request
    left, top, right, bottom = request.crop or (0.0, 0.0, 1.0, 1.0)

    def dragged(event: Any) -> None:
        edges = [min(1.0, max(0.0, float(event.args[k]))) for k in ("left", "top", "right", "bottom")]
        left, top, right, bottom = (round(edge, 4) for edge in edges)
        if right - left >= 0.02 and bottom - top >= 0.02:
            state.change(crop=(left, top, right, bottom))

    frame = ui.element("div").classes("crop").props("data-crop")
    frame.on("make-crop", dragged, js_handler="(event) => emit(event.detail)")
    with frame:
        image = ui.element("img").props('draggable="false" alt="Selected photograph; drag over it to crop"')
        image.props["src"] = f"/make/photo/{Path(request.values['image']).name}"
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
        _draw_edges(state, (left, top, right, bottom))
    if request.crop is not None:
        whole = ui.button("Use the whole photograph", on_click=lambda: state.change(crop=None))
        whole.props("flat dense")
    else:
        kit.hint("Drag over the photograph to crop it.")


def _draw_edges(state: MakePageState, crop: Crop) -> None:
    """Draw the crop as four numbers, an alternative to dragging."""

    def apply() -> None:
        if any(field.value is None for field in numbers):
            raise ParameterError("Enter all four edges, in percent.")
        left, top, right, bottom = (float(field.value) / 100 for field in numbers)
        if not (0 <= left < right <= 1 and 0 <= top < bottom <= 1):
            raise ParameterError("Left must be less than right and top less than bottom, from 0 to 100.")
        state.change(crop=(left, top, right, bottom))

    with ui.row().classes("gap-2 items-center"):
        numbers = [
            ui.number(name, value=round(100 * edge, 1), min=0, max=100).style("width: 5rem")
            for name, edge in zip(("Left", "Top", "Right", "Bottom"), crop, strict=True)
        ]
        ui.button("Crop", on_click=apply).props("outline dense")


def draw_vibration(state: MakePageState) -> None:
    """Draw the choice of a vibration: a kept result, an upload, or a recording of the training data."""
    drawn = "vibration" in state.form.takes
    options = {"": "none (the model draws one from the seed)" if drawn else "none"}
    options |= _files(state, state.vibrations, ".npz")
    for result in state.shelf.all():
        if not result.is_image:
            options[f"studio/kept/{result.id}/signal.npz"] = f"kept: {result.title}"
    _draw_choice(state, "vibration", "Vibration", options, redraw=not drawn)

    async def uploaded(name: str, data: bytes) -> None:
        _use_vibration(state, name, await kit.in_background(read_uploaded_signal, name, data))

    with ui.row().classes("gap-2"):
        kit.file_button("Upload a recording", uploaded)
        if not (state.run and state.run.ships):
            ui.button("From the training data", on_click=lambda: _ask_recording(state)).props("outline dense")


def _files(state: MakePageState, folder: Path, suffix: str) -> dict[str, str]:
    """Return the titles of the stored files of a kind, by path relative to the workspace."""
    files = sorted(folder.glob(f"[!.]*{suffix}"))
    return {state.workspace.name_of(path): f"file: {path.stem}" for path in files}


def _draw_choice(
    state: MakePageState, name: str, label: str, options: Mapping[str, str], *, redraw: bool
) -> None:
    """Draw the choice of a file of the request, which may no longer be among those offered."""
    chosen = state.request.values.get(name, "")
    select = ui.select(dict(options) | {chosen: options.get(chosen, chosen)}, value=chosen, label=label)
    select.on_value_change(lambda event: state.change(redraw=redraw, **{name: event.value or ""}))
    select.classes("w-full").props[f"data-{name}"] = "1"


def _use_vibration(state: MakePageState, name: str, signal: Signal) -> None:
    """Store and choose a vibration."""
    stored = store_vibration(state.vibrations, name, signal)
    state.change(vibration=state.workspace.name_of(state.vibrations / stored))


async def _ask_recording(state: MakePageState) -> None:
    """Ask for a recording of the run's training data, and use it."""
    run = state.run
    store = None if run is None else await kit.in_background(state.runs.store_of, run)
    if store is None:
        raise DataError("The training data of this run is not in this workspace.")
    infos = list(store.index)[:MOST_OFFERED]
    titles = {info.id: f"{info.material or info.source or 'recording'} · {info.id[:8]}" for info in infos}

    async def use() -> None:
        if id := chosen.value:
            signal = await kit.in_background(store.signal, id, store.streams_of(id)[0])
            _use_vibration(state, f"{store.info(id).material or 'recording'}-{id[:8]}.npz", signal)
        dialog.close()

    with kit.form_dialog(f"Recording of {store.name}", "Use", use) as dialog:
        chosen = ui.select(titles, label="Recording", with_input=True).classes("w-80")


def draw_motion(state: MakePageState) -> None:
    """Draw the choice of a motion: none, that of a simulated hand, or an uploaded one."""
    options = {"": "none: one speed and force", "simulated": "a simulated hand"}
    _draw_choice(state, "motion", "Motion", options | _files(state, state.motions, ".csv"), redraw=True)

    async def uploaded(name: str, data: bytes) -> None:
        stored = await kit.in_background(store_motion, state.motions, name, data)
        state.change(motion=state.workspace.name_of(state.motions / stored))

    with ui.row():
        kit.file_button("Upload a motion", uploaded, accept=".csv", marks='data-motion-upload="1"')
    kit.hint("The surface follows its speed and force, and is silent where the finger rests or is lifted.")
