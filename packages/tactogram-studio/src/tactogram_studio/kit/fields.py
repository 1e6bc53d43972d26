"""Fields: checked numbers, forms that survive a reload, declared settings, files that a browser sends, and signals."""

from __future__ import annotations

import html
import json
import math
import secrets
from collections import UserDict
from collections.abc import Awaitable, Callable, Collection, Iterator, Mapping, MutableMapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, TypeVar
from urllib.parse import unquote

from fastapi import HTTPException, Request
from fastapi.responses import JSONResponse
from nicegui import app, ui
from nicegui.elements.mixins.value_element import ValueElement
from starlette.datastructures import UploadFile

from tactogram.errors import ParameterError, TactogramError
from tactogram_studio.kit.cards import hint
from tactogram_studio.layout import address, attribute, in_background
from tactogram_studio.server.guard_rules import RECEIVED
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.received import MOST_FILES, MOST_SENT, ReceivedFolders
from tactogram_studio.workspace.shelf import SignalSources

if TYPE_CHECKING:
    from tactogram.workflows import RecipeField
    from tactogram_studio.study_draft.fields import StudyField

Field = TypeVar("Field", bound=ValueElement[Any])
Options = Sequence[str] | Mapping[Any, str]
"""Choices, or their titles by value."""
CHOOSER = """<div class="chooser">
<span>{text}</span>
<q-btn outline label="Choose a file" aria-label="Choose a file: {text}" @click="props.pickFiles" />
<span hidden><q-uploader-add-trigger /></span>
</div>"""
"""Replaces the button of Quasar's uploader, which is a link around an input, without an accessible name."""
Take = Callable[[str, bytes], Awaitable[Any]]
"""What is done with a file, by its name and content."""
KINDS = {
    "kept": ("Kept result", "No kept results yet: generate one on the page Make and keep it."),
    "file": ("File", "No signal files in this workspace."),
    "recording": ("Store", "No store in this workspace yet."),
}
"""Label and text of an empty list, by kind of signal."""
TABS, MOST_TABS = "tabs", 5
"""Entry of a page's settings with those of its tabs by key, and how many of them are stored; the oldest are dropped."""
RECEIVING_HEAD = '<script type="module" src="/static/receive.js"></script>'
FOLDER_INPUT = '<input type="file" hidden data-receive-input="{0}" {1}>'


class TabSettings(UserDict[str, Any]):
    """Settings of one tab, begun with those that the browser stored last; each change is stored for the next tab.

    The tab's own are stored, too, under a ``key`` that belongs into its address: a reload and the way back find them
    there, whatever other tabs have stored since. An empty key is replaced; with None there are none of its own. Of the
    ``shared`` names there is one entry for all tabs.
    """

    def __init__(
        self, stored: MutableMapping[str, Any], key: str | None = None, *, shared: Collection[str] = ()
    ) -> None:
        super().__init__()
        self._stored, self._shared = stored, shared
        self.key = secrets.token_hex(4) if key == "" else key
        tabs: MutableMapping[str | None, Any] = stored.setdefault(TABS, {})
        last = {name: value for name, value in stored.items() if name != TABS}
        self._own = tabs.pop(self.key, None) or json.loads(json.dumps(last))
        self.data.update(self._own)
        if self.key is not None:
            tabs[self.key] = self._own
            self._own = tabs[self.key]
        for oldest in [*tabs][:-MOST_TABS]:
            del tabs[oldest]

    def __contains__(self, name: object) -> bool:
        return name in (self._stored if name in self._shared else self.data)

    def __getitem__(self, name: str) -> Any:
        return (self._stored if name in self._shared else self.data)[name]

    def __setitem__(self, name: str, value: Any) -> None:
        self.data[name] = self._stored[name] = value
        self._own[name] = value

    def __delitem__(self, name: str) -> None:
        for values in (self.data, self._stored, self._own):
            values.pop(name, None)


class NumberField(ui.number):
    """A number field that leaves bad input as typed; `checked` refuses it.

    NiceGUI's own field silently moves a number into its range when it loses focus.
    """

    def sanitize(self) -> None:
        """Leave the value unchanged."""

    def checked(
        self, *, least: float = -math.inf, most: float = math.inf, whole: bool = False
    ) -> float | None:
        """Return the number, or None if the field is empty; raise `ParameterError` naming the field as `in_range`."""
        return in_range(self.label or "number", self.value, least=least, most=most, whole=whole)


def in_range(
    name: str, value: float | None, *, least: float = -math.inf, most: float = math.inf, whole: bool = False
) -> float | None:
    """Return ``value`` unchanged, None included.

    Raises `ParameterError` if it is outside ``least`` to ``most``, or a fraction although ``whole``.
    """
    if value is None:
        return None
    if whole and not float(value).is_integer():
        raise ParameterError(f"{name} must be a whole number, got {value:g}")
    if not least <= value <= most:
        bounds = f"at least {least:g}" if most == math.inf else f"{least:g} to {most:g}"
        raise ParameterError(f"{name} must be {bounds}, got {value:g}")
    return value


@dataclass
class Form:
    """Fields whose entries are in ``values`` by name, such as those of a browser's storage, which survive a reload.

    ``changed`` is called after each change; ``classes`` are the fields' own.
    """

    values: MutableMapping[str, Any]
    changed: Callable[[], Any] | None = None
    classes: str = "w-full"

    def text(self, name: str, label: str, default: str = "", *, hint: str = "", **options: Any) -> ui.input:
        """Draw a field of a text."""
        field = ui.input(label, value=self._value(name, default), **options)
        return self._bound(field.props(f'hint="{attribute(hint)}"') if hint else field, name)

    def number(self, name: str, label: str, default: float | None = None, **options: Any) -> NumberField:
        """Draw a field of a number, which may be empty."""
        return self._bound(NumberField(label, value=self._value(name, default), **options), name)

    def choice(self, name: str, options: Options, label: str, default: Any = None, **more: Any) -> ui.select:
        """Draw a choice; an entry that is no longer offered becomes the default, by default the first."""
        if self.values.get(name) not in options:
            self.values[name] = default if default in options else next(iter(options), None)
        shown = list(options) if isinstance(options, Sequence) else dict(options)
        return self._bound(ui.select(shown, label=label, value=self.values[name], **more), name)

    def box(self, name: str, label: str, default: bool = False) -> ui.checkbox:
        """Draw a box to tick."""
        return self._bound(ui.checkbox(label, value=bool(self._value(name, default))), name)

    def stripped(self, name: str) -> str:
        """Return the entry of a text without spaces around it."""
        return str(self.values.get(name) or "").strip()

    def _value(self, name: str, default: Any) -> Any:
        return self.values.setdefault(name, default)

    def _bound(self, field: Field, name: str) -> Field:
        def store(event: Any) -> Any:
            self.values[name] = event.value
            return self.changed() if self.changed else None

        field.on_value_change(store)
        return field.classes(self.classes)


def declared_field(
    field: RecipeField | StudyField, label: str, value: Any, change: Callable[[Any], Any]
) -> Any:
    """Draw and return the widget of a declared setting, which calls ``change`` with each entry."""
    if field.widget == "switch":
        return ui.switch(label, value=bool(value), on_change=lambda event: change(event.value))
    if field.widget == "choice":
        titles = field.choices if isinstance(field.choices, Mapping) else {key: key for key in field.choices}
        other = {} if value in titles else {value: "none" if value is None else str(value)}
        options = other | dict(titles)
        return ui.select(options, label=label, value=value, on_change=lambda event: change(event.value))
    if field.widget in ("integer", "number"):
        widget: Any = NumberField(label, value=value, format="%.10g")
    else:
        widget = ui.input(label, value=value or "")
    return widget.on_value_change(lambda event: change(event.value)).props("debounce=300")


def file_field(
    text: str, take: Take, *, accept: Sequence[str] = (), most_mib: int | None = None, refused: str = ""
) -> ui.upload:
    """Draw a field with a prompt where a file is dropped or chosen.

    ``accept`` are the suffixes of files that it takes; others, and larger ones, are refused with a text.
    """
    field = _upload(take, refused or f"The file must have at most {most_mib} MiB.", most_mib)
    if accept:
        field.props["accept"] = ",".join(accept)
    field.add_slot("header", CHOOSER.format(text=html.escape(text)))
    return field.props("flat bordered").classes("w-full")


def file_button(text: str, take: Take, *, accept: str = "", refused: str = "", marks: str = "") -> ui.upload:
    """Draw a button that opens a file, as often as one likes; ``marks`` are properties of the hidden field.

    ``accept`` is as that of an input element. Without a text, there is no button, but that of the page.
    """
    field = _upload(take, refused, None).classes("hidden").props(f'accept="{attribute(accept)}"').props(marks)
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


def signal_choice(sources: SignalSources, kind: str, take: Callable[[str], Any], *, last: str = "") -> None:
    """Draw the choice of a signal of a kind, or of its store and then the recording.

    ``take`` is called with the id of the signal (see `SignalSources.select`); ``last`` is the id that was chosen last.
    """
    label, empty = KINDS[kind]
    if kind != "recording":
        option_choice(
            sources.kept() if kind == "kept" else sources.files(), label, take, empty=empty, last=last
        )
        return

    def recordings(store: str) -> None:
        container.clear()
        with container:
            option_choice(
                sources.recordings(store), "Recording", take, empty="This store is empty.", last=last
            )

    stores = sources.stores()
    first = last.removeprefix("recording:").partition("#")[0]
    first = first if first in stores else next(iter(stores), "")
    option_choice(stores, label, recordings, empty=empty, last=first)
    container = ui.column().classes("w-full")
    if first:
        recordings(first)


def option_choice(
    options: Mapping[str, str], label: str, take: Callable[[str], Any], *, empty: str = "", last: str = ""
) -> ui.select | None:
    """Draw a choice that calls ``take`` with each value; a text if there is none."""
    if not options:
        ui.label(empty).classes("quiet")
        return None
    value = last if last in options else None
    select = ui.select(dict(options), label=label, value=value, with_input=len(options) > 12)
    select.on_value_change(lambda event: take(event.value) if event.value else None)
    return select.classes("w-full")


@cache
def add_receiving_route(workspace: Workspace) -> None:
    """Register the route that takes the files, once."""

    @app.post(RECEIVED)
    async def receive(request: Request) -> JSONResponse:
        try:
            async with request.form(max_files=MOST_FILES, max_fields=0) as form:
                sent = [each for each in form.getlist("file") if isinstance(each, UploadFile)]
                files = [(unquote(each.filename or ""), each.file) for each in sent]
                folder = await in_background(ReceivedFolders(workspace).keep, files)
        except (TactogramError, OSError) as error:
            return JSONResponse({"problem": str(error)}, 422)
        except HTTPException as error:  # Starlette's, of a form that is none
            return JSONResponse({"problem": str(error.detail)}, 422)
        return JSONResponse({"page": import_address(workspace.name_of(folder))})


def import_address(folder: str) -> str:
    """Return the address of the page that imports a folder of the workspace."""
    return address("/materials/import", folder=folder)


@contextmanager
def drop_zone(*, whole_page: bool = False) -> Iterator[None]:
    """Draw a place that takes folders and zips, on a page with `RECEIVING_HEAD`.

    What is drawn in the context belongs to it. Of a ``whole_page`` it is seen only when something is dragged over it.
    """
    with ui.element("div").classes("receive bare" if whole_page else "receive") as zone:
        zone.props(f'data-receive="{RECEIVED}" data-most-files="{MOST_FILES}" data-most-bytes="{MOST_SENT}"')
        yield


def folder_chooser() -> None:
    """Draw the buttons that open a folder or a zip, and the progress, within a drop zone."""
    with ui.row().classes("items-center gap-3"):
        for kind, text in (("folder", "Choose a folder"), ("zip", "Choose a zip file")):
            ui.button(text).props(f'outline data-receive-choose="{attribute(kind)}"')
        for kind, more in (("folder", "webkitdirectory multiple"), ("zip", 'accept=".zip"')):
            ui.html(FOLDER_INPUT.format(kind, more), sanitize=False)
    receiving_status()


def receiving_status(text: str = "") -> None:
    """Draw the place of progress and refusals within a drop zone, with a text until then."""
    hint(text).props('data-receive-status role="status"')
