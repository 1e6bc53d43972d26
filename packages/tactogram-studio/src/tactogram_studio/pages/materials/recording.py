"""Page of one recording: photograph, signal, metadata, and similar recordings."""

from __future__ import annotations

from nicegui import ui
from PIL import Image as Pillow

from tactogram.datasets import RecordingInfo, Store
from tactogram.errors import TactogramError
from tactogram_studio.layout import attribute, heading, in_background, page, route
from tactogram_studio.pages.materials.media import HEAD, MaterialsContext, address
from tactogram_studio.pages.materials.neighbours import draw_similar
from tactogram_studio.pages.materials.recordings import describe_recording, picture_of, stream_of
from tactogram_studio.signals.view import add_routes, signal_card


def add(context: MaterialsContext) -> None:
    """Register ``/materials/recording``."""
    add_routes()

    @route("/materials/recording")
    async def show(set: str = "", id: str = "", stream: str = "") -> None:
        ui.add_head_html(HEAD)
        with page("Materials"):
            ui.link(f"All recordings of {set}", address("set", set=set)).classes("small")
            try:
                store = await in_background(context.store, set)
                info = await in_background(store.info, id)
                name = stream_of(store, id, stream)
                signal = await in_background(store.signal, id, name)
            except (TactogramError, OSError) as error:
                ui.label(str(error)).props('role="alert"')
                return

            def go(stream: str) -> None:
                ui.navigate.to(address("recording", set=set, id=id, stream=stream))

            with ui.element("section").classes("card w-full"):
                with ui.row().classes("items-center gap-3"):
                    heading(info.material or "Recording")
                    if info.simulated:
                        ui.label("simulated").classes("simulated")
                with ui.row().classes("gap-6 items-start w-full"):
                    _draw_photograph(store, info)
                    with (
                        ui.element("div").style("flex: 1 1 18rem"),
                        ui.element("dl").classes("facts"),
                    ):
                        for term, text in describe_recording(info):
                            ui.element("dt")._text = term
                            ui.element("dd")._text = text
                streams = list(store.streams_of(id))
                if len(streams) > 1:
                    select = ui.select(streams, label="Stream", value=name).classes("w-48")
                    select.on_value_change(lambda event: go(event.value))
            signal_card(signal, title=f"{name} of {info.material or id}", simulated=info.simulated)
            draw_similar(context, signal, set_name=set, stream=name, without=(id,))


def _draw_photograph(store: Store, info: RecordingInfo) -> None:
    key = picture_of(store, info)
    if key is None:
        return
    with ui.element("figure").style("margin: 0; width: 16rem"):
        photograph = ui.image(Pillow.fromarray(store.photograph(key).pixels)).style("border-radius: 8px")
        photograph.props(f'alt="Photograph of {attribute(info.material or info.id)}"')
        if store.image_id(info.id) is None:
            ui.element("figcaption").classes("small quiet")._text = "photograph of the material"
