"""Page of one store: its materials with pictures, and its recordings, filtered and in pages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import quote

from nicegui import ui

from tactogram.datasets import RecordingInfo, Store
from tactogram.errors import TactogramError
from tactogram_studio.layout import heading, hint, in_background, page, report_errors, route
from tactogram_studio.pages.materials.media import HEAD, MaterialsContext, address, draw_recording, picture
from tactogram_studio.pages.materials.recordings import (
    FIELDS,
    NAMES,
    UNITS,
    RecordingFilter,
    choices,
    filtered,
    page_bounds,
)

PER_PAGE = 20
SHOWN_MATERIALS = 60


def add(context: MaterialsContext) -> None:
    """Register ``/materials/set``."""

    @route("/materials/set")
    async def show(set: str = "", q: str = "", material: str = "", more: str = "", number: int = 1) -> None:
        ui.add_head_html(HEAD)
        with page("Materials"):
            ui.link("All stores", "/materials").classes("small")
            fields = dict(part.split("=", 1) for part in more.split("|") if "=" in part)
            chosen = RecordingFilter(q, material, {name: fields[name] for name in FIELDS if name in fields})

            def read() -> tuple[Store, list[RecordingInfo], dict[str, list[str]]]:
                store = context.store(set)
                return store, filtered(store.index, chosen), choices(store.index)

            try:
                store, shown, options = await in_background(read)
            except (TactogramError, OSError) as error:
                ui.label(str(error)).props('role="alert"')
                return
            _draw_head(set, store)
            if chosen == RecordingFilter():
                _draw_materials(set, store)
            _draw_recordings(set, store, chosen, number, shown, options)


def _draw_head(name: str, store: Store) -> None:
    index = store.index
    counts = [
        (len({info.material for info in index} - {None}), "material"),
        (len(store), "recording"),
        (len({info.subject for info in index} - {None}), "subject"),
        (len({info.session for info in index} - {None}), "session"),
        (len(store.photograph_keys()), "photograph"),
        (0 if store.facts.ratings is None else store.facts.ratings.rows, "rating"),
    ]
    with ui.element("section").classes("card w-full"):
        with ui.row().classes("items-center gap-3"):
            heading(name).style("overflow-wrap: anywhere")
            if store.simulated:
                count = sum(info.simulated for info in index)
                text = "simulated" if count == len(store) else f"{count} of {len(store)} simulated"
                ui.label(text).classes("simulated")
        ui.label(" · ".join(f"{n:,} {what}{'' if n == 1 else 's'}" for n, what in counts if n))
        streams = ", ".join(
            f"{key} in {facts.unit} over {facts.domain} ({','.join(facts.axes)})"
            for key, facts in store.streams.items()
        )
        hint(f"{store.name} · {streams} · licence: {store.licence}")
        hint(f"sha256 {store.sha256[:16]}…").tooltip(store.sha256)
        with ui.row():
            ui.button("Upload a recording", on_click=lambda: ui.navigate.to(address("drop", set=name)))
            train = ui.button("Train a model", on_click=lambda: ui.navigate.to(f"/train?data={quote(name)}"))
            train.props("outline")


def _draw_materials(name: str, store: Store) -> None:
    counts = Counter(info.material for info in store.index if info.material is not None)
    if not counts:
        return
    with ui.element("section").classes("card w-full"):
        heading(f"Materials ({len(counts)})")
        with ui.element("div").classes("swatches w-full"):
            for material, count in sorted(counts.items())[:SHOWN_MATERIALS]:
                with ui.element("div").classes("swatch whole"):
                    keys = store.photographs_of(material)
                    if keys:
                        source = address("picture", set=name, key=keys[0], size=240)
                        picture(source, f"Photograph of {material}")
                    with ui.element("div"):
                        ui.link(material, address("set", set=name, material=material)).classes("whole-link")
                        hint(f"{count} recording{'' if count == 1 else 's'}")
        if len(counts) > SHOWN_MATERIALS:
            hint(f"{len(counts) - SHOWN_MATERIALS} more: select them below.")


def _draw_recordings(
    name: str,
    store: Store,
    chosen: RecordingFilter,
    number: int,
    shown: Sequence[RecordingInfo],
    options: Mapping[str, list[str]],
) -> None:
    number, first, last = page_bounds(len(shown), number, PER_PAGE)
    materials = sorted({info.material for info in store.index if info.material is not None})

    def go(*, number: int = 1, **changes: Any) -> None:
        query = {"q": chosen.text, "material": chosen.material, "fields": chosen.fields} | changes
        more = "|".join(f"{key}={value}" for key, value in query.pop("fields").items() if value)
        ui.navigate.to(address("set", set=name, **query, more=more, number=number if number > 1 else ""))

    def choose(label: str, values: Sequence[str], value: str, change: Any) -> ui.select:
        shown_values = {"": "any", **{value: value for value in values}}
        select = ui.select(shown_values, label=label, value=value, with_input=len(values) > 20)
        return select.props("dense options-dense").on_value_change(lambda event: change(event.value or ""))

    with ui.element("section").classes("card w-full").props('aria-label="Recordings"'):
        heading("Recordings")
        with ui.row().classes("items-end gap-3 w-full"):
            text = ui.input("Search", value=chosen.text, placeholder="name, source or label")
            text.props("dense clearable").on("clear", lambda: go(q=""))
            text.on("keydown.enter", lambda: go(q=text.value or ""))
            if materials:
                choose("Material", materials, chosen.material, lambda m: go(material=m)).classes("w-48")
            for key, values in options.items():
                label = NAMES.get(key, key) + (f" ({UNITS[key]})" if key in UNITS else "")

                def change(value: str, key: str = key) -> None:
                    go(fields={**chosen.fields, key: value})

                choose(label, values, chosen.fields.get(key, ""), change).classes("w-36")
            if chosen != RecordingFilter():
                clear = ui.button("Clear filters", on_click=lambda: ui.navigate.to(address("set", set=name)))
                clear.props("flat dense")
        hint(f"{first + 1 if shown else 0} to {last} of {len(shown):,}").props('role="status"')
        with ui.element("div").classes("w-full"):
            for info in shown[first:last]:
                draw_recording(name, store, info)
        pages = -(-len(shown) // PER_PAGE)
        if pages > 1:
            with ui.row().classes("items-center"):
                turn = ui.pagination(1, pages, direction_links=True, value=number)
                turn.props('max-pages="7" boundary-numbers aria-label="Pages of recordings"')
                turn.on_value_change(report_errors(lambda event: go(number=int(event.value))))
