"""Results of the page Make: shown, played, kept, downloaded, and compared with each other and with recordings."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from nicegui import ui

from tactogram.errors import DataError, TactogramError
from tactogram_studio import kit
from tactogram_studio.generation.files import downloads, encoded
from tactogram_studio.generation.state import MakePageState
from tactogram_studio.signals.view import SignalEntry, signal_cards
from tactogram_studio.workspace.commands import stem_of
from tactogram_studio.workspace.shelf import LONGEST_TITLE, KeptResult

LETTERS = "ABCDEFGHI"
NEAREST = "Nearest recordings"


def draw_results(state: MakePageState) -> None:
    """Draw the selected result, and those it is compared with."""
    if state.failure:
        with kit.card("Generation failed") as failed:
            failed.props('role="alert"')
            ui.label(f"{state.failure[:1].upper()}{state.failure[1:].rstrip('.')}.")
    present = state.current_result()
    if present is None:
        if not state.failure:
            with kit.card("No result yet"):
                ui.label("Press Generate to see and play a result here.").classes("quiet")
        return
    name = str(state.storage.get("present"))
    compared = [
        (other, result)
        for other, result in state.compared()
        if other != name and result.is_image == present.is_image
    ]
    shown = [(name, present), *compared]
    _draw_comparison_bar(state, name, present, compared)
    titles = [result.title for _, result in shown]
    if compared:
        titles = [f"{letter}: {title}" for letter, title in zip(LETTERS, titles, strict=False)]
    with ui.element("div").classes("compared" if compared else "single"):
        tops = _draw_images(shown, titles) if present.is_image else _draw_signals(state, shown, titles)
        for number, ((other, result), top) in enumerate(zip(shown, tops, strict=True)):
            with top:
                _draw_actions(state, other, result, first=number == 0)
    _draw_earlier(state, name)


def _draw_signals(
    state: MakePageState, shown: Sequence[tuple[str, KeptResult]], titles: list[str]
) -> list[Any]:
    """Draw signals, and return the rows at the top of their cards."""
    entries = [
        SignalEntry(result.file, title, bool(result.facts.get("simulated")), str(number))
        for number, ((_, result), title) in enumerate(zip(shown, titles, strict=True), start=1)
    ]
    return signal_cards(entries, same_gain=bool(state.storage.get("true_levels")) and len(shown) > 1)


def _draw_images(shown: Sequence[tuple[str, KeptResult]], titles: list[str]) -> list[Any]:
    """Draw images, and return the rows at the top of their cards."""
    tops = []
    for (name, result), title in zip(shown, titles, strict=True):
        rows, columns = result.image().size
        with kit.card(label=result.title, classes="signal"):
            tops.append(kit.title_row(title, result.facts.get("simulated")))
            kit.hint(f"{columns} x {rows} pixels")
            image = ui.element("img").classes("made-image")
            image.props.update(src=_image_address(name), alt=f"Generated image: {result.title}")
    return tops


def _image_address(name: str) -> str:
    return f"/make/image/{name.replace(':', '/')}"


def _draw_comparison_bar(
    state: MakePageState, name: str, present: KeptResult, compared: list[tuple[str, KeptResult]]
) -> None:
    """Draw the choice of results to compare with, and how they are played, where there is one."""
    offers = {f"made:{result.id}": f"earlier: {result.title}" for result in state.results()}
    offers |= {f"kept:{result.id}": f"kept: {result.title}" for result in state.shelf.all()}
    for taken in (name, *(other for other, _ in compared)):
        offers.pop(taken, None)

    def add(event: Any) -> None:
        if event.value:
            state.add_comparison(event.value)
            state.redraw_results()

    def set_levels(event: Any) -> None:
        state.storage["true_levels"] = bool(event.value)
        state.redraw_results()

    trained = present.facts.get("what") == "made" and present.facts.get("run") != present.facts.get("model")
    if not (offers or compared or (trained and not present.is_image)):
        return
    with kit.card(label="Compare", classes="bar-compare"):
        if offers:
            select = ui.select(offers, label="Compare with", on_change=add)
            select.classes("grow")
        if present.is_image:
            return
        if trained:
            nearest = ui.button(NEAREST).props("outline dense")
            nearest.on_click(lambda: _add_nearest(state, present, nearest))
        if compared:
            levels = bool(state.storage.get("true_levels"))
            ui.switch("At their true strengths", value=levels, on_change=set_levels).props("dense")
            kit.hint("Keys 1 to 9 switch between the results while playing; Escape stops.")


async def _add_nearest(state: MakePageState, present: KeptResult, button: ui.button) -> None:
    """Compare the selected result with the recordings most like it."""
    button.disable()
    button.text = "Searching"
    try:
        run = state.runs.get(str(present.facts.get("run", "")))
        method, recordings = await kit.in_background(lambda: state.runs.nearest(run, present.signal()))
        if not recordings:
            raise DataError("There is no recording to compare with.")
        for title, signal, simulated in recordings[:2]:
            facts = {"what": "recording", "run": run.name, "simulated": simulated, "found": method}
            stored = await kit.in_background(state.made.keep, signal, title=title, facts=facts)
            state.add_comparison(f"made:{stored.id}")
        ui.notify(f"Found the nearest recordings {method}.")
    finally:
        button.enable()
        button.text = NEAREST
        state.redraw_results()


def _draw_actions(state: MakePageState, name: str, result: KeptResult, *, first: bool) -> None:
    """Draw the buttons of a result."""

    async def keep() -> None:
        kept = await kit.in_background(state.shelf.keep_copy, result)
        state.record_kept(name, kept)
        ui.notify(f"Kept: {kept.title}.", type="positive")
        state.redraw_results()

    def rename(title: str) -> None:
        state.rename(name, title)
        state.redraw_results()

    def remove() -> None:
        state.remove_comparison(name)
        state.redraw_results()

    def show_first() -> None:
        before = str(state.storage.get("present"))
        state.remove_comparison(name)
        state.select_result(name)
        state.add_comparison(before)
        state.redraw_results()

    def button(text: str, press: Any, label: str = "", look: str = "flat") -> None:
        named = f"{label or text} {kit.attribute(result.title)}"
        ui.button(text, on_click=press).props(f'dense aria-label="{kit.attribute(named)}"').props(look)

    run = result.facts.get("run")
    if result.facts.get("what") == "made" and run != state.request.run:
        kit.hint(f"Made by {run}, not by the run of the form.").classes("w-full")
    if described := result.facts.get("described"):
        kit.hint(str(described)).classes("w-full")
    for note in result.facts.get("limited", ()):
        kit.hint(f"{note[:1].upper()}{note[1:]}.").classes("w-full")
    kept = name.removeprefix("kept:") if name.startswith("kept:") else state.kept_id(name)
    if first and result.facts.get("what") == "made" and not result.is_image:
        _draw_class(state, result)
    with ui.element("div").classes("done"):
        if first and not result.is_image:
            state.storage.setdefault("loop", True)
            ui.checkbox("Loop").props("dense data-player-loop").bind_value(state.storage, "loop")
        _draw_download(name, result)
        if kept:
            kit.hint("Kept")
            if not result.is_image:
                ui.link("Touch", f"/touch?where=kept&of={kept}").classes("small")
            ui.link("Send", f"/send?of=kept:{kept}").classes("small")
            button("Rename", lambda: kit.ask_title(result.title, LONGEST_TITLE, rename))
        else:
            button("Keep", keep, look="outline")
        if not first:
            button("Show first", show_first, "Show first:")
            close = ui.button(icon="close", on_click=remove)
            close.props(f'dense flat aria-label="Remove {kit.attribute(result.title)}"')


def _draw_class(state: MakePageState, result: KeptResult) -> None:
    """Draw the prediction of a fitting classifier once it is known; nothing without a classifier."""
    label = kit.hint("").classes("prediction")
    runs = state.runs

    async def fill() -> None:
        try:
            classifier = runs.classifier_for(runs.get(str(result.facts.get("run", ""))))
            if classifier is None:
                return
            prediction = await kit.in_background(lambda: runs.classify(classifier, result.signal()))
            closest = f"{prediction['material']}, {100 * prediction['probability']:.0f} %"
            verdict = f"none of these (closest: {closest})" if prediction["none_of_these"] else closest
            text = f"Classified as {verdict} by {classifier.name}"
        except TactogramError as error:
            text = f"Not classified: {error}"
        if not label.is_deleted:
            label.text = text

    ui.timer(0.05, fill, once=True)


def _draw_earlier(state: MakePageState, name: str) -> None:
    """Draw the list of earlier results."""
    earlier = [result for result in state.results() if f"made:{result.id}" != name]
    if not earlier:
        return

    def show(result: KeptResult) -> None:
        state.remove_comparison(f"made:{result.id}")
        state.select_result(f"made:{result.id}")
        state.redraw_results()

    with kit.card("Earlier results"), ui.element("ul").classes("earlier"):
        for result in earlier:
            with ui.element("li"):
                ui.button(result.title, on_click=partial(show, result)).props("flat dense align=left")
                kit.hint(str(result.facts.get("model", "")))


def _draw_download(name: str, result: KeptResult) -> None:
    """Draw the button with the formats of a result: WAV and other formats of signals, and haptic files."""

    async def download(format: str) -> None:
        with kit.busy(f"Writing {format}"):
            file, data, loss = await kit.in_background(encoded, result, format)
        ui.download.content(data, file)
        if loss:
            ui.notify(f"{file} {loss}.")

    button = ui.button("Download").props(f'dense flat aria-label="Download {kit.attribute(result.title)}"')
    if result.is_image:
        button.on_click(lambda: ui.download.from_url(_image_address(name), f"{stem_of(result.title)}.png"))
        return
    with button, ui.menu():
        for purpose, formats in downloads(result).items():
            with ui.element("div").props(f'role="group" aria-label="{kit.attribute(purpose)}"'):
                kit.hint(purpose).classes("q-px-md q-pt-sm")
                for format, title in formats.items():
                    item = ui.menu_item(title, partial(download, format))
                    item.props('role="menuitem" dense')
