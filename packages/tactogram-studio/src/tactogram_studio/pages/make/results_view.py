"""Results of the page Make: shown, played, kept, and compared with each other and with recordings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from nicegui import ui

from tactogram.errors import DataError, TactogramError
from tactogram_studio.layout import attribute, heading, hint, in_background, report_errors
from tactogram_studio.pages.make.downloads import draw_download
from tactogram_studio.signals.view import SignalEntry, signal_cards
from tactogram_studio.workspace.shelf import KeptResult
from tactogram_studio.workspace.shelf_view import ask_title

if TYPE_CHECKING:
    from tactogram_studio.pages.make.page import MakePage

LETTERS = "ABCDEFGHI"
NEAREST = "Nearest recordings"


def draw_results(page: MakePage) -> None:
    """Draw the selected result, and those it is compared with."""
    state = page.state
    if page.failure:
        with ui.element("section").classes("card").props('role="alert"'):
            heading("Generation failed")
            ui.label(f"{page.failure[:1].upper()}{page.failure[1:].rstrip('.')}.")
    present = state.current_result()
    if present is None:
        if not page.failure:
            with ui.element("section").classes("card"):
                heading("No result yet")
                ui.label("Press Generate to see and play a result here.").classes("quiet")
        return
    name = str(state.storage.get("present"))
    compared = [
        (other, result)
        for other, result in state.compared()
        if other != name and result.is_image == present.is_image
    ]
    shown = [(name, present), *compared]
    _draw_comparison_bar(page, name, present, compared)
    titles = [result.title for _, result in shown]
    if compared:
        titles = [f"{letter}: {title}" for letter, title in zip(LETTERS, titles, strict=False)]
    with ui.element("div").classes("compared" if compared else "single"):
        tops = _draw_images(shown, titles) if present.is_image else _draw_signals(page, shown, titles)
        for number, ((other, result), top) in enumerate(zip(shown, tops, strict=True)):
            with top:
                _draw_actions(page, other, result, first=number == 0)
    _draw_earlier(page, name)


def _draw_signals(page: MakePage, shown: Sequence[tuple[str, KeptResult]], titles: list[str]) -> list[Any]:
    """Draw signals, and return the rows at the top of their cards."""
    entries = [
        SignalEntry(result.file, title, bool(result.facts.get("simulated")), str(number))
        for number, ((_, result), title) in enumerate(zip(shown, titles, strict=True), start=1)
    ]
    return signal_cards(entries, same_gain=bool(page.state.storage.get("true_levels")) and len(shown) > 1)


def _draw_images(shown: Sequence[tuple[str, KeptResult]], titles: list[str]) -> list[Any]:
    """Draw images, and return the rows at the top of their cards."""
    tops = []
    for (name, result), title in zip(shown, titles, strict=True):
        rows, columns = result.image().size
        where, _, id = name.partition(":")
        with ui.element("section").classes("card signal") as card:
            card.props(f'role="group" aria-label="{attribute(result.title)}"')
            with ui.row().classes("w-full items-center gap-2") as top:
                heading(title)
                if result.facts.get("simulated"):
                    ui.label("simulated").classes("simulated")
            hint(f"{columns} x {rows} pixels")
            image = ui.element("img").classes("made-image")
            image.props(f'src="/make/image/{where}/{id}" alt="Generated image: {attribute(result.title)}"')
        tops.append(top)
    return tops


def _draw_comparison_bar(
    page: MakePage, name: str, present: KeptResult, compared: list[tuple[str, KeptResult]]
) -> None:
    """Draw the choice of results to compare with, and the settings of playback."""
    state = page.state
    offers = {f"made:{result.id}": f"earlier: {result.title}" for result in state.results()}
    offers |= {f"kept:{result.id}": f"kept: {result.title}" for result in state.shelf.all()}
    for taken in (name, *(other for other, _ in compared)):
        offers.pop(taken, None)

    def add(event: Any) -> None:
        if event.value:
            state.add_comparison(event.value)
            page.results.refresh()

    def set_levels(event: Any) -> None:
        state.storage["true_levels"] = bool(event.value)
        page.results.refresh()

    with ui.element("section").classes("card bar-compare").props('aria-label="Compare"'):
        if offers:
            select = ui.select(offers, label="Compare with", on_change=report_errors(add))
            select.props("outlined dense options-dense").classes("grow")
        if present.is_image:
            return
        if present.facts.get("what") == "made" and not (state.run and state.run.ships):
            nearest = ui.button(NEAREST).props("no-caps outline dense")
            nearest.on_click(report_errors(lambda: _add_nearest(page, present, nearest)))
        with ui.element("div").props("data-player-loop"):
            state.storage.setdefault("loop", True)
            ui.checkbox("Loop").props("dense").bind_value(state.storage, "loop")
        if compared:
            switch = ui.switch("At their true strengths", value=bool(state.storage.get("true_levels")))
            switch.props("dense").on_value_change(report_errors(set_levels))
            hint("Keys 1 to 9 switch between the results while playing; Escape stops.")


async def _add_nearest(page: MakePage, present: KeptResult, button: ui.button) -> None:
    """Compare the selected result with the recordings most like it."""
    state = page.state
    button.disable()
    button.text = "Searching"
    try:
        run = state.runs.get(str(present.facts.get("run", "")))
        method, recordings = await in_background(lambda: state.runs.nearest(run, present.signal()))
        if not recordings:
            raise DataError("There is no recording to compare with.")
        for title, signal, simulated in recordings[:2]:
            facts = {"what": "recording", "run": run.name, "simulated": simulated, "found": method}
            stored = await in_background(state.made.keep, signal, title=title, facts=facts)
            state.add_comparison(f"made:{stored.id}")
        ui.notify(f"Found the nearest recordings {method}.")
    finally:
        button.enable()
        button.text = NEAREST
        page.results.refresh()


def _draw_actions(page: MakePage, name: str, result: KeptResult, *, first: bool) -> None:
    """Draw the buttons of a result."""
    state = page.state

    async def keep() -> None:
        kept = await in_background(state.shelf.keep_copy, result)
        state.record_kept(name, kept)
        ui.notify(f"Kept: {kept.title}.", type="positive")
        page.results.refresh()

    async def rename() -> None:
        title = await ask_title(result.title)
        if title is not None:
            state.rename(name, title)
            page.results.refresh()

    def remove() -> None:
        state.remove_comparison(name)
        page.results.refresh()

    def show_first() -> None:
        before = str(state.storage.get("present"))
        state.remove_comparison(name)
        state.select_result(name)
        state.add_comparison(before)
        page.results.refresh()

    if described := result.facts.get("described"):
        hint(str(described)).classes("w-full")
    for note in result.facts.get("limited", ()):
        hint(f"{note[:1].upper()}{note[1:]}.").classes("w-full")
    kept = name.removeprefix("kept:") if name.startswith("kept:") else state.kept_id(name)
    if first and result.facts.get("what") == "made" and not result.is_image:
        _draw_class(page, result)
    title = attribute(result.title)
    with ui.element("div").classes("done"):
        draw_download(name, result)
        if kept:
            hint("Kept")
            ui.link("Send", f"/send?of=kept:{kept}").classes("small")
            button = ui.button("Rename", on_click=report_errors(rename))
            button.props(f'no-caps dense flat aria-label="Rename {title}"')
        else:
            button = ui.button("Keep", on_click=report_errors(keep))
            button.props(f'no-caps dense outline aria-label="Keep {title}"')
        if not first:
            button = ui.button("Show first", on_click=report_errors(show_first))
            button.props(f'no-caps dense flat aria-label="Show first: {title}"')
            button = ui.button(icon="close", on_click=report_errors(remove))
            button.props(f'dense flat aria-label="Remove {title}"')


def _draw_class(page: MakePage, result: KeptResult) -> None:
    """Draw the prediction of a fitting classifier once it is known; nothing without a classifier."""
    label = hint("").classes("prediction")
    runs = page.state.runs

    async def fill() -> None:
        try:
            classifier = runs.classifier_for(runs.get(str(result.facts.get("run", ""))))
            if classifier is None:
                return
            found = await in_background(lambda: runs.classify(classifier, result.signal()))
            closest = f"{found['material']}, {found['probability']:.0%}"
            verdict = f"none of these (closest: {closest})" if found["none_of_these"] else closest
            text = f"Classified as {verdict} by {classifier.name}"
        except TactogramError as error:
            text = f"Not classified: {error}"
        if not label.is_deleted:
            label.text = text

    ui.timer(0.05, report_errors(fill), once=True)


def _draw_earlier(page: MakePage, name: str) -> None:
    """Draw the list of earlier results."""
    earlier = [result for result in page.state.results() if f"made:{result.id}" != name]
    if not earlier:
        return

    def show(result: KeptResult) -> None:
        page.state.remove_comparison(f"made:{result.id}")
        page.state.select_result(f"made:{result.id}")
        page.results.refresh()

    with ui.element("section").classes("card"):
        heading("Earlier results")
        with ui.element("ul").classes("earlier"):
            for result in earlier:
                with ui.element("li"):
                    button = ui.button(
                        result.title, on_click=report_errors(lambda result=result: show(result))
                    )
                    button.props("no-caps flat dense align=left")
                    hint(str(result.facts.get("model", "")))
