"""Stimuli of the editor: the grid, the stimuli listed one by one, the form of each, and the names on pages."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from nicegui import ui

from tactogram.model import condition_types
from tactogram.models import available, shipped_run
from tactogram_studio import kit
from tactogram_studio.pages.studies.editor.widgets import (
    Editor,
    Redraw,
    draw_choice,
    draw_fields,
    draw_table,
    draw_texts,
    new_name,
    part,
    row_of_list,
    without,
)
from tactogram_studio.study_draft.fields import Place, StudyField, fields_of
from tactogram_studio.study_draft.stimuli import (
    SOURCES,
    grid_conditions,
    listed,
    named_keys,
    picture_kind,
    place_signal,
    relative,
    simulated_surfaces,
    source_kind,
    summary,
    with_picture,
    with_source,
)
from tactogram_studio.workspace.shelf import SignalSources
from tactogram_studio.workspace.uploads import SUFFIXES
from tactogram_study.stimuli import Stimulus, StimulusGrid

PICTURES = {"": "No picture", "image": "A file of the workspace", "simulated_image": "A simulated picture"}
FURTHER = ("seconds", "level", "seed", "display", "axes", "speed_mm_s", "autoregressive", "reconstructed")


def stimuli(editor: Editor, redraw: Redraw) -> None:
    """Draw the card of all stimuli."""
    with kit.card("Stimuli", classes="w-full stack"):
        if editor.draft.get(("grid",)):
            _grid(editor, redraw)
        part(partial(listed_stimuli, editor, ("stimuli",)))
        with ui.expansion("Names on pages and in reports").classes("w-full"):
            kit.hint("Answers keep the keys; participants and reports see the names.")
            for key in named_keys(editor.draft):
                draw_texts(editor, ("names", key), key)


def _grid(editor: Editor, redraw: Redraw) -> None:
    draft = editor.draft
    ui.label("A stimulus for each item in each condition")
    if draft.get(("grid", "numbered")):
        draw_fields(editor, fields_of(StimulusGrid, ("grid",), only=("count",)))
    else:
        _names(editor, "item", ("grid", "items"), redraw)
    _names(editor, "condition", ("grid", "conditions"), redraw)
    source = draw_table(editor, ("grid", "source"), "Source")
    editor.faults.register(("grid",), source)
    for condition in grid_conditions(draft):
        draw_table(editor, ("grid", "by_condition", condition), f"Changes to the source for {condition}")
    kit.hint(
        'A line per setting, as in the study\'s file: file = "{item}.wav". {item} and {condition} are replaced.'
    )

    def list_them() -> None:
        listed(draft)
        editor.changed()
        redraw()

    ui.button("List them one by one", on_click=list_them).props("outline dense")
    kit.hint("Then each can have a source of its own: a kept result, a file, a recording.")


def _names(editor: Editor, kind: str, place: Place, redraw: Redraw) -> None:
    """Draw the names in a list of the grid, its items or conditions, with buttons to add and remove one."""
    draft = editor.draft
    names = [name for name in draft.get(place, []) if name]

    def resize(changed: list[str]) -> None:
        for gone in set(names) - set(changed):
            if draft.get(("grid", "by_condition", gone)) and kind == "condition":
                draft.set(("grid", "by_condition", gone), None)
        editor.put(place, changed or None)
        redraw()

    with ui.row().classes("gap-1"):
        for number, name in enumerate(names):
            with ui.row().classes("chip items-center no-wrap gap-0"):
                ui.label(name)
                kit.icon_button("close", f"Remove the {kind} {name}", partial(resize, without(names, number)))
    new_name(editor, place, f"Another {kind}", f"Add the {kind}", lambda name: resize([*names, name]))


def listed_stimuli(editor: Editor, place: Place, redraw: Redraw) -> None:
    """Draw the stimuli of a list, each with a button that opens its form."""
    entries = editor.draft.get(place, [])
    for number, stimulus in enumerate(entries):
        name = str(stimulus.get("name", number + 1))
        with row_of_list(editor, (*place, number), name, redraw):
            _stimulus(editor, (*place, number), name, stimulus, redraw)

    def add() -> None:
        names = {entry.get("name") for entry in entries}
        name = next(f"stimulus{n}" for n in range(1, 1000) if f"stimulus{n}" not in names)
        editor.put(place, [*entries, {"name": name}])
        redraw()
        StimulusForm(editor, (*place, len(entries)), redraw)

    ui.button("Add a stimulus", on_click=add).props("outline dense")


def _stimulus(editor: Editor, place: Place, name: str, stimulus: dict[str, Any], redraw: Redraw) -> None:
    with ui.row().classes("w-full items-center gap-2"):
        # An input, so that it can show the fault of its stimulus.
        shown = (
            ui.input(name, value=summary(stimulus))
            .props("readonly borderless", remove="outlined")
            .classes("grow")
        )
        editor.faults.register(place, shown)
        button = ui.button("Change", on_click=lambda: StimulusForm(editor, place, redraw))
        button.props(f'outline dense aria-label="Change {kit.attribute(name)}"')


class StimulusForm:
    """Dialog for the stimulus at a place, with its name, signal, picture and level; ``done`` is called at its end."""

    def __init__(self, editor: Editor, place: Place, done: Redraw) -> None:
        self.editor, self.place, self.done = editor, place, done
        self.workspace = editor.studio.workspace
        self.sources = SignalSources(self.workspace, editor.studio.shelf)
        # Not in the part of the form that is drawn anew.
        with ui.context.client.content, ui.dialog(value=True).props('aria-label="Stimulus"') as self.dialog:
            self._draw()
        self.dialog.on("hide", self._close)

    @property
    def stimulus(self) -> dict[str, Any]:
        """Its values in the draft."""
        return dict(self.editor.draft.get(self.place))

    def _draw(self) -> None:
        kind, picture = source_kind(self.stimulus), picture_kind(self.stimulus)
        pictures = PICTURES | ({} if picture in PICTURES else {picture: "Generated by a trained model"})
        with ui.card().classes("w-full max-w-2xl stack"):
            kit.heading("Stimulus")
            self._fields("name", "item", "condition")
            signal = ui.select(dict(SOURCES), label="Signal", value=kind).classes("w-full")
            self.signal = kit.column(gap=2)
            signal.on_value_change(lambda event: self._choose_signal(event.value))
            self._draw_signal(kind)
            shown = ui.select(pictures, label="Picture", value=picture).classes("w-full")
            self.picture = kit.column(gap=2)
            shown.on_value_change(lambda event: self._choose_picture(event.value))
            self._draw_picture(picture)
            with ui.expansion("Length, level and more").classes("w-full"):
                self._fields(*FURTHER)
            self.summary = ui.label(summary(self.stimulus)).props('role="status"')
            with ui.row().classes("justify-end w-full"):
                ui.button("Done", on_click=self.dialog.close)

    def _fields(self, *names: str) -> None:
        draw_fields(self.editor, fields_of(Stimulus, self.place, only=names))

    def _choose_signal(self, kind: str) -> None:
        if kind == "":
            self._put(with_source(self.stimulus, "", ""))
        self.signal.clear()
        self._draw_signal(kind)

    def _draw_signal(self, kind: str) -> None:
        with self.signal:
            if kind == "":
                self._fields("text")
            elif kind in kit.KINDS:
                kit.signal_choice(self.sources, kind, self._take)
            elif kind == "run":
                self._value_choice("Model", "run", self._runs())
                self._fields("material")
                self._draw_given()
            else:
                self._value_choice("Surface", "simulated", {name: name for name in simulated_surfaces()})

    def _draw_given(self) -> None:
        """Draw the conditions of a model that are numbers; those of a recording where the stimulus has one."""
        fields = [
            StudyField(
                (*self.place, "given", name), f"Given {kind.label[:1].lower()}{kind.label[1:]}", "", "number"
            )
            for name, kind in condition_types().items()
            if kind.unit
            and kind.options
            and ("vibration" in self.stimulus or not name.startswith("vibration_"))
        ]
        draw_fields(self.editor, fields)

    def _runs(self) -> dict[str, str]:
        shipped = {name: f"{name}, ready to use" for name in available() if shipped_run(name) is not None}
        own = {self._relative(run): self.workspace.name_of(run) for run in self.workspace.finished_runs()}
        return shipped | own

    def _choose_picture(self, kind: str) -> None:
        self._put(with_picture(self.stimulus, "", ""))
        self.picture.clear()
        self._draw_picture(kind)

    def _draw_picture(self, kind: str) -> None:
        with self.picture:
            if kind == "image":
                files = self.workspace.user_files(*SUFFIXES["image"])
                named = {self._relative(path): self.workspace.name_of(path) for path in files}
                kept = (result for result in self.sources.shelf.all() if result.is_image)
                named |= {self._relative(result.file): f"kept: {result.title}" for result in kept}
                self._value_choice("Picture file", "image", named)
            elif kind == "simulated_image":
                self._fields("simulated_image")

    def _value_choice(self, label: str, key: str, options: Mapping[str, str]) -> None:
        """Draw the choice of a value of the file, which may be none of those offered."""
        value = self.stimulus.get(key)
        options = dict(options) | ({value: options.get(value, value)} if value else {})
        if not options:
            ui.label("None in this workspace.").classes("quiet")
            return
        put = with_picture if key == "image" else with_source

        def change(chosen: str) -> None:
            if chosen:
                self._put(put(self.stimulus, key, chosen))

        draw_choice(self.editor, (*self.place, key), label, options, change, value=value, with_input=True)

    async def _take(self, identifier: str) -> None:
        """Let the stimulus play a signal of the workspace."""
        with kit.busy("reading the signal"):
            signal = await kit.in_background(self.sources.select, identifier)
            file = await kit.in_background(place_signal, self.workspace, self.editor.draft.path, signal)
        self._put(with_source(self.stimulus, "file", file))

    def _put(self, stimulus: dict[str, Any]) -> None:
        self.editor.put(self.place, stimulus)
        self.summary.text = summary(stimulus)

    def _relative(self, path: Any) -> str:
        return relative(path, self.editor.draft.path)

    def _close(self) -> None:
        self.dialog.delete()
        self.done()
