"""One recording: photograph, signal, all that is known of it, and what is near it."""

from __future__ import annotations

from nicegui import ui
from PIL import Image as Pillow

from tactogram.datasets import Store
from tactogram.errors import TactogramError
from tactogram.studio.layout import in_background, page
from tactogram.studio.pages.materials.media import HEAD, MaterialsContext, address, facts_list
from tactogram.studio.pages.materials.neighbours import draw_near
from tactogram.studio.pages.materials.recordings import describe_recording, picture_of, stream_of
from tactogram.studio.signals.view import add_routes, signal_card


def add(desk: MaterialsContext) -> None:
    """Register ``/materials/recording``."""
    add_routes()

    @ui.page("/materials/recording")
    async def show(set: str = "", id: str = "", stream: str = "") -> None:
        ui.add_head_html(HEAD)
        with page("Materials"):
            ui.link(f"All of {set}", address("set", set=set)).classes("small")
            try:
                store = await in_background(desk.stores.get, set)
                info = await in_background(store.info, id)
                name = stream_of(store, id, stream)
                signal = await in_background(store.signal, id, name)
            except (TactogramError, OSError) as error:
                ui.label(str(error)).props('role="alert"')
                return
            with ui.element("section").classes("card w-full"):
                with ui.row().classes("items-center gap-3"):
                    ui.label(info.material or "Recording").classes("h2").props(
                        'role="heading" aria-level="2"'
                    )
                    if info.simulated:
                        ui.label("simulated").classes("simulated")
                with ui.row().classes("gap-6 items-start w-full"):
                    _photograph(store, id, info.material)
                    with ui.element("div").style("flex: 1 1 18rem"):
                        facts_list(dict(describe_recording(info)))
                streams = store.streams_of(id)
                if len(streams) > 1:
                    ui.select(
                        list(streams),
                        label="Stream",
                        value=name,
                        on_change=lambda e: ui.navigate.to(
                            address("recording", set=set, id=id, stream=e.value)
                        ),
                    ).classes("w-48")
            signal_card(signal, title=f"{name} of {info.material or id}", simulated=info.simulated)
            draw_near(desk, signal, set_name=set, stream=name, without=(id,))


def _photograph(store: Store, id: str, material: str | None) -> None:
    key = picture_of(store, store.info(id))
    if key is None:
        return
    with ui.element("figure").style("margin: 0; width: 16rem"):
        ui.image(Pillow.fromarray(store.photograph(key).pixels)).props(
            f'alt="Photograph of {material or id}"'
        ).style("border-radius: 8px")
        own = store.image_id(id) is not None
        ui.element("figcaption").classes("small quiet")._text = "" if own else "a photograph of the material"
