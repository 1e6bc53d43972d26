"""The page Materials: the stores, a form to simulate one, a place to drop recordings, and the pages of one store."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import quote

from nicegui import app, ui
from PIL import Image as Pillow

from tactogram.datasets import RecordingInfo, Store
from tactogram.errors import TactogramError
from tactogram.parameters import parameters
from tactogram.signal import Signal
from tactogram.workflows import list_sets
from tactogram_simulate import simulate_to_store
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.kit.fields import RECEIVING_HEAD, drop_zone, folder_chooser
from tactogram_studio.kit.tasks import TaskCards, TaskStart
from tactogram_studio.pages.materials import drop, import_page
from tactogram_studio.pages.materials.media import (
    HEAD,
    add_routes,
    address,
    draw_recordings,
    draw_similar,
    picture,
    starts_of,
)
from tactogram_studio.signals import view as signal_view
from tactogram_studio.signals.traits import SignalTraits, unit_text
from tactogram_studio.signals.view import signal_card
from tactogram_studio.tasks.queue import output_name, trainings_of
from tactogram_studio.workspace.commands import arguments, free_name
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.recordings import (
    FIELDS,
    NAMES,
    UNITS,
    RecordingFilter,
    choices,
    describe_recording,
    filtered,
    open_named,
    page_bounds,
    picture_of,
    stream_of,
)

PER_PAGE = 20
SHOWN_MATERIALS = 60
UPDATE_S = 1.5


def _add_store_pages(workspace: Workspace) -> None:
    """Register ``/materials/set`` and ``/materials/recording``."""
    signal_view.add_routes()

    @kit.route("/materials/set")
    async def show(set: str = "", q: str = "", material: str = "", more: str = "", number: int = 1) -> None:
        ui.add_head_html(HEAD)
        with kit.page("Materials"):
            ui.link("All stores", "/materials").classes("small")
            fields = dict(part.split("=", 1) for part in more.split("|") if "=" in part)
            chosen = RecordingFilter(q, material, {name: fields[name] for name in FIELDS if name in fields})

            def read() -> tuple[Store, list[RecordingInfo], dict[str, SignalTraits], dict[str, list[str]]]:
                store = open_named(workspace, set)
                shown = filtered(store.index, chosen)
                _, first, last = page_bounds(len(shown), number, PER_PAGE)
                return store, shown, starts_of(store, shown[first:last]), choices(store.index)

            with workspace.readable_errors():
                store, shown, starts, options = await kit.in_background(read)
            _draw_head(set, store)
            if chosen == RecordingFilter():
                _draw_materials(set, store)
            _draw_recordings(set, store, chosen, number, shown, starts, options)

    @kit.route("/materials/recording")
    async def show_recording(set: str = "", id: str = "", stream: str = "") -> None:
        ui.add_head_html(HEAD)
        with kit.page("Materials"):
            ui.link(f"All recordings of {set}", address("set", set=set)).classes("small")

            def read() -> tuple[Store, str, Signal]:
                store = open_named(workspace, set)
                name = stream_of(store, id, stream)
                return store, name, store.signal(id, name)

            with workspace.readable_errors():
                store, name, signal = await kit.in_background(read)
            info = store.info(id)
            _draw_metadata(set, store, info, name)
            signal_card(signal, title=f"{name} of {info.material or id}", simulated=info.simulated)
            draw_similar(workspace, signal, set_name=set, stream=name, without=(id,))


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
    with kit.card():
        count = sum(info.simulated for info in index)
        text = "simulated" if count == len(store) else f"{count} of {len(store)} simulated"
        kit.title_row(name, store.simulated, text)
        ui.label(" · ".join(f"{n:,} {what}{'' if n == 1 else 's'}" for n, what in counts if n))
        streams = ", ".join(
            f"{key}: {unit_text(facts.unit)} over {facts.domain} ({', '.join(facts.axes)})"
            for key, facts in store.streams.items()
        )
        kit.hint(f"{store.name} · {streams} · licence: {store.licence}")
        kit.hint(f"sha256 {store.sha256[:16]}…").tooltip(store.sha256)
        with ui.row():
            ui.button("Upload a recording", on_click=lambda: ui.navigate.to(address("drop", set=name)))
            train = ui.button("Train a model", on_click=lambda: ui.navigate.to(f"/train?data={quote(name)}"))
            train.props("outline")


def _draw_materials(name: str, store: Store) -> None:
    counts = Counter(info.material for info in store.index if info.material is not None)
    if not counts:
        return
    with kit.card(f"Materials ({len(counts)})"):
        with ui.element("div").classes("swatches w-full"):
            for material, count in sorted(counts.items())[:SHOWN_MATERIALS]:
                with ui.element("div").classes("swatch whole"):
                    keys = store.photographs_of(material)
                    if keys:
                        source = address("picture", set=name, key=keys[0], size=240)
                        picture(source, f"Photograph of {material}")
                    with ui.element("div"):
                        ui.link(material, address("set", set=name, material=material)).classes("whole-link")
                        kit.hint(f"{count} recording{'' if count == 1 else 's'}")
        if len(counts) > SHOWN_MATERIALS:
            kit.hint(f"{len(counts) - SHOWN_MATERIALS} more: select them below.")


def _draw_recordings(
    name: str,
    store: Store,
    chosen: RecordingFilter,
    number: int,
    shown: Sequence[RecordingInfo],
    starts: Mapping[str, SignalTraits],
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
        return select.on_value_change(lambda event: change(event.value or ""))

    with kit.card("Recordings"):
        with ui.row().classes("items-end gap-3 w-full"):
            text = ui.input("Search", value=chosen.text, placeholder="name, source or label")
            text.props("clearable").on("clear", lambda: go(q=""))
            text.on("keydown.enter", lambda: go(q=text.value or ""))
            if materials:
                choose("Material", materials, chosen.material, lambda m: go(material=m)).classes("w-48")
            for key, values in options.items():
                label = NAMES.get(key, key).capitalize() + (f", {UNITS[key]}" if key in UNITS else "")

                def change(value: str, key: str = key) -> None:
                    go(fields={**chosen.fields, key: value})

                choose(label, values, chosen.fields.get(key, ""), change).classes("w-36")
            if chosen != RecordingFilter():
                clear = ui.button("Clear filters", on_click=lambda: ui.navigate.to(address("set", set=name)))
                clear.props("flat dense")
        kit.hint(f"{first + 1 if shown else 0} to {last} of {len(shown):,}").props('role="status"')
        with ui.element("div").classes("w-full"):
            draw_recordings(name, store, shown[first:last], starts)
        pages = -(-len(shown) // PER_PAGE)
        if pages > 1:
            with ui.row().classes("items-center"):
                turn = ui.pagination(1, pages, direction_links=True, value=number)
                turn.props('max-pages="7" boundary-numbers aria-label="Pages of recordings"')
                turn.on_value_change(lambda event: go(number=int(event.value)))


def _draw_metadata(set_name: str, store: Store, info: RecordingInfo, stream: str) -> None:
    def go(stream: str) -> None:
        ui.navigate.to(address("recording", set=set_name, id=info.id, stream=stream))

    with kit.card():
        kit.title_row(info.material or "Recording", info.simulated)
        with ui.row().classes("gap-6 items-start w-full"):
            _draw_photograph(store, info)
            with ui.element("div").style("flex: 1 1 18rem"), ui.element("dl").classes("facts"):
                for term, text in describe_recording(info):
                    ui.element("dt")._text = term
                    ui.element("dd")._text = text
        streams = list(store.streams_of(info.id))
        if len(streams) > 1:
            select = ui.select(streams, label="Stream", value=stream).classes("w-48")
            select.on_value_change(lambda event: go(event.value))


def _draw_photograph(store: Store, info: RecordingInfo) -> None:
    key = picture_of(store, info)
    if key is None:
        return
    with ui.element("figure").style("margin: 0; width: 16rem"):
        photograph = ui.image(Pillow.fromarray(store.photograph(key).pixels)).style("border-radius: 8px")
        photograph.props(f'alt="Photograph of {kit.attribute(info.material or info.id)}"')
        if store.image_id(info.id) is None:
            ui.element("figcaption").classes("small quiet")._text = "photograph of the material"


def add(studio: Studio) -> None:
    """Register ``/materials`` and the pages below it."""
    workspace = studio.workspace
    trainings_of(workspace).keep_advancing()
    add_routes(workspace)
    _add_store_pages(workspace)
    drop.add(workspace)
    import_page.add(workspace)

    @kit.route("/materials")
    async def show() -> None:
        ui.add_head_html(HEAD + RECEIVING_HEAD)
        with kit.page("Materials"), drop_zone(whole_page=True):
            with ui.element("div").classes("grid-2 even"):
                _draw_import()
                with kit.card("Look at one recording", classes=""):
                    kit.hint("See which materials it resembles, and add it to a store.")
                    upload = ui.button("Upload a recording")
                    upload.on_click(lambda: ui.navigate.to("/materials/drop")).props("outline")
            await _StoreOverview(workspace).draw()
            sets = await kit.in_background(list_sets)
            with ui.element("div").classes("grid-2 even"):
                _draw_simulation(workspace, sets["simulate"])


def _draw_simulation(workspace: Workspace, sets: dict[str, str]) -> None:
    with kit.card("Simulate a data set", classes=""):
        kit.hint("Surfaces computed from formulas. Everything derived from them is marked as simulated.")
        options = {name: f"{name}: {text}" for name, text in sets.items()}
        state = kit.TabSettings(app.storage.user.setdefault("simulate", {}))
        kind = kit.Form(state).choice("kind", options, "Set", "stroking9")
        with ui.row().classes("w-full"):
            fields = kit.ParameterFields(
                parameters(simulate_to_store),
                ("per_class", "seconds", "photographs", "seed"),
                labels={"per_class": "Recordings per class", "photographs": "Photographs per surface"},
                examples={"per_class": "default", "seconds": "default", "photographs": "one", "seed": "0"},
                entries=state,
                classes="w-64 grow",
            )
        name = ui.input("Name").classes("w-full")

        def command() -> list[str]:
            out = output_name("data", name.value)
            return arguments("data", "simulate", str(kind.value), out=out, **fields.values())

        def suggest() -> None:
            name.value = free_name(workspace.folder / "data", str(kind.value))

        kind.on_value_change(suggest)
        suggest()
        TaskStart(
            trainings_of(workspace),
            "simulate",
            "Simulate",
            arguments=command,
            output=lambda: output_name("data", name.value),
        )


def _draw_import() -> None:
    with kit.card("Import recordings", classes=""):
        kit.hint(
            "Drop a folder with a folder for each material, or a zip of it, anywhere on this page: the studio shows "
            "how every file would be read before it imports them."
        )
        folder_chooser()
        text = "Import from a folder of the workspace, or a published data set"
        ui.link(text, "/materials/import").classes("small")


class _StoreOverview:
    """Stores and unfinished tasks, updated regularly."""

    def __init__(self, workspace: Workspace) -> None:
        self.workspace = workspace
        self._stores: list[tuple[str, Store | str]] = []

    async def draw(self) -> None:
        """Draw tasks and stores, and keep them up to date."""
        TaskCards(trainings_of(self.workspace), ("simulate", "import")).follow(UPDATE_S)
        self._stores = await kit.in_background(self._gather)
        self._tiles()
        ui.timer(UPDATE_S, self._update)

    async def _update(self) -> None:
        drawn = self._stores
        self._stores = await kit.in_background(self._gather)
        if [name for name, _ in self._stores] != [name for name, _ in drawn]:
            self._tiles.refresh()

    def _gather(self) -> list[tuple[str, Store | str]]:
        """Return the stores, each opened or with the reason why it cannot be."""
        names = [self.workspace.name_of(path) for path in self.workspace.stores()]
        return [(name, self._open(name)) for name in names]

    def _open(self, name: str) -> Store | str:
        try:
            return open_named(self.workspace, name)
        except (TactogramError, OSError) as error:
            return str(error)

    @ui.refreshable_method
    def _tiles(self) -> None:
        kit.heading("Stores")
        if not self._stores:
            ui.label("None yet: import recordings, or simulate some below.").classes("quiet")
        with ui.element("div").classes("tiles w-full"):
            for name, store in self._stores:
                with kit.card(classes="whole"):
                    _draw_tile(name, store)


def _draw_tile(name: str, store: Store | str) -> None:
    ui.link(name, address("set", set=name)).classes("h2 whole-link").style("overflow-wrap: anywhere")
    if isinstance(store, str):
        ui.label(store).classes("small text-negative")
        return
    kit.mark_simulated(store.simulated)
    ui.label(f"{store.name} · {len(store):,} recordings")
    kit.hint(", ".join(f"{key} ({unit_text(facts.unit)})" for key, facts in store.streams.items()))
    kit.hint(f"Licence: {store.licence}")
    ui.link("Train a model", f"/train?data={quote(name)}").classes("small")
