"""One data set: its materials with pictures, and its recordings, filtered and page by page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import quote

from nicegui import ui

from tactogram.datasets import RecordingInfo, Store
from tactogram.errors import TactogramError
from tactogram.studio.layout import in_background, page, report_errors
from tactogram.studio.pages.materials.media import HEAD, MaterialsContext, address, draw_recording, picture
from tactogram.studio.pages.materials.recordings import (
    FIELDS,
    NAMES,
    UNITS,
    RecordingFilter,
    choices,
    filtered,
    page_of,
)

PER_PAGE = 20
SHOWN_MATERIALS = 60


def add(desk: MaterialsContext) -> None:
    """Register ``/materials/set``."""

    @ui.page("/materials/set")
    async def show(set: str = "", q: str = "", material: str = "", more: str = "", number: int = 1) -> None:
        ui.add_head_html(HEAD)
        with page("Materials"):
            ui.link("All data sets", "/materials").classes("small")
            try:
                store = await in_background(desk.stores.get, set)
                await in_background(
                    lambda: [info.material for info in store.index]
                )  # reads what lies on the disk
            except (TactogramError, OSError) as error:
                ui.label(str(error)).props('role="alert"')
                return
            fields = dict(part.split("=", 1) for part in more.split("|") if "=" in part)
            asked = RecordingFilter(
                q, material, {name: value for name, value in fields.items() if name in FIELDS}
            )
            found, fields_of = await in_background(
                lambda: (filtered(store.index, asked), choices(store.index))
            )
            _head(set, store)
            if not asked.text and not asked.material and not asked.fields:
                _materials(set, store)
            _recordings(set, store, asked, number, found, fields_of)


def _head(name: str, store: Store) -> None:
    index = store.index
    counts = [
        (len({info.material for info in index} - {None}), "material"),
        (len(store), "recording"),
        (len({info.subject for info in index} - {None}), "subject"),
        (len({info.session for info in index} - {None}), "session"),
        (len(store.photograph_keys()), "photograph"),
        (0 if store.facts.ratings is None else store.facts.ratings.rows, "score"),
    ]
    with ui.element("section").classes("card w-full"):
        with ui.row().classes("items-center gap-3"):
            ui.label(name).classes("h2").props('role="heading" aria-level="2"').style(
                "overflow-wrap: anywhere"
            )
            if store.simulated:
                made = sum(info.simulated for info in index)
                ui.label("simulated" if made == len(store) else f"{made} of {len(store)} simulated").classes(
                    "simulated"
                )
        ui.label(" · ".join(f"{n:,} {what}{'' if n == 1 else 's'}" for n, what in counts if n))
        streams = ", ".join(
            f"{key} in {facts.unit} over {facts.domain} ({','.join(facts.axes)})"
            for key, facts in store.streams.items()
        )
        ui.label(f"{store.name} · {streams} · licence: {store.licence}").classes("small quiet")
        ui.label(f"sha256 {store.sha256[:16]}…").classes("small quiet").tooltip(store.sha256)
        with ui.row():
            ui.button("Drop a recording", on_click=lambda: ui.navigate.to(address("drop", set=name)))
            ui.button("Train on it", on_click=lambda: ui.navigate.to(f"/train?data={quote(name)}")).props(
                "outline"
            )


def _materials(name: str, store: Store) -> None:
    counts = Counter(info.material for info in store.index if info.material is not None)
    if not counts:
        return
    with ui.element("section").classes("card w-full"):
        ui.label(f"Materials ({len(counts)})").classes("h2").props('role="heading" aria-level="2"')
        with ui.element("div").classes("swatches w-full"):
            for material, count in sorted(counts.items())[:SHOWN_MATERIALS]:
                with ui.element("div").classes("swatch"):
                    keys = store.photographs_of(material)
                    if keys:
                        picture(
                            address("picture", set=name, key=keys[0], size=240), f"Photograph of {material}"
                        )
                    with ui.element("div"):
                        ui.link(material, address("set", set=name, material=material))
                        ui.label(f"{count} recording{'' if count == 1 else 's'}").classes("small quiet")
        if len(counts) > SHOWN_MATERIALS:
            ui.label(f"and {len(counts) - SHOWN_MATERIALS} more: choose them below").classes("quiet small")


def _recordings(
    name: str,
    store: Store,
    asked: RecordingFilter,
    number: int,
    found: Sequence[RecordingInfo],
    fields_of: Mapping[str, list[str]],
) -> None:
    number, first, last = page_of(len(found), number, PER_PAGE)
    materials = sorted({info.material for info in store.index if info.material is not None})

    def go(**changes: Any) -> None:
        now: dict[str, Any] = {
            "q": asked.text,
            "material": asked.material,
            "fields": dict(asked.fields),
            "number": 1,
        }
        now |= changes
        more = "|".join(f"{key}={value}" for key, value in now.pop("fields").items() if value)
        page_number = now.pop("number")
        ui.navigate.to(
            address("set", set=name, **now, more=more, number=page_number if page_number > 1 else "")
        )

    with ui.element("section").classes("card w-full").props('aria-label="Recordings"'):
        ui.label("Recordings").classes("h2").props('role="heading" aria-level="2"')
        with ui.row().classes("items-end gap-3 w-full"):
            text = ui.input("Search", value=asked.text, placeholder="words of name, source, labels").props(
                "dense clearable"
            )
            text.on("keydown.enter", lambda: go(q=text.value or ""))
            text.on("clear", lambda: go(q=""))
            if materials:
                ui.select(
                    {"": "any", **{material: material for material in materials}},
                    label="Material",
                    value=asked.material,
                    with_input=len(materials) > 20,
                    on_change=lambda e: go(material=e.value or ""),
                ).props("dense options-dense").classes("w-48")
            for key, values in fields_of.items():
                unit = f" ({UNITS[key]})" if key in UNITS else ""
                ui.select(
                    {"": "any", **{value: value for value in values}},
                    label=NAMES.get(key, key) + unit,
                    value=asked.fields.get(key, ""),
                    on_change=lambda e, key=key: go(fields={**asked.fields, key: e.value or ""}),
                ).props("dense options-dense").classes("w-36")
            if asked.text or asked.material or asked.fields:
                ui.button("All", on_click=lambda: ui.navigate.to(address("set", set=name))).props(
                    "flat dense"
                )
        ui.label(f"{first + 1 if found else 0} to {last} of {len(found):,}").classes("small quiet").props(
            'role="status"'
        )
        with ui.element("div").classes("w-full"):
            for info in found[first:last]:
                draw_recording(name, store, info)
        pages = max(1, -(-len(found) // PER_PAGE))
        if pages > 1:
            with ui.row().classes("items-center"):
                turn = ui.pagination(1, pages, direction_links=True, value=number)
                turn.props('max-pages="7" boundary-numbers aria-label="Pages of recordings"')
                turn.on_value_change(report_errors(lambda e: go(number=int(e.value))))
