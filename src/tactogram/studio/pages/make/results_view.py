"""The results of the page Make: seen, heard, kept, and compared with others and with real recordings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import ui

from tactogram.errors import DataError, TactogramError
from tactogram.studio.layout import in_background, report_errors
from tactogram.studio.signals.view import SignalEntry, signal_cards
from tactogram.studio.workspace.shelf import KeptResult
from tactogram.studio.workspace.shelf_view import ask_title

if TYPE_CHECKING:
    from tactogram.studio.pages.make.page import MakePage

LETTERS = "ABCDEFGHI"


def draw_results(on: MakePage) -> None:
    """Draw the present result and what stands beside it."""
    if on.failed:
        with ui.element("section").classes("card").props('role="alert"'):
            ui.label("Nothing was made").classes("h2")
            ui.label(f"{on.failed[:1].upper()}{on.failed[1:].rstrip('.')}.")
    desk = on.desk
    present = desk.current_result()
    if present is None:
        if not on.failed:
            with ui.element("section").classes("card"):
                ui.label("Nothing made yet").classes("h2")
                ui.label("Press Make: what comes out is drawn and can be played here.").classes("quiet")
        return
    name = str(desk.held.get("present"))
    beside = [
        (other, made)
        for other, made in desk.compared()
        if other != name and made.is_image == present.is_image
    ]
    shown = [(name, present), *beside]
    _compare_bar(on, name, present, beside)
    titles = [
        f"{LETTERS[number]}: {made.title}" if len(shown) > 1 else made.title
        for number, (_, made) in enumerate(shown)
    ]
    with ui.element("div").classes("beside" if len(shown) > 1 else "alone"):
        if present.is_image:
            tops = [
                _image_card(made, other, title) for (other, made), title in zip(shown, titles, strict=True)
            ]
        else:
            entries = [
                SignalEntry(made.file, title, bool(made.facts.get("simulated")), str(number))
                for number, ((_, made), title) in enumerate(zip(shown, titles, strict=True), start=1)
            ]
            tops = signal_cards(entries, same_gain=bool(desk.held.get("true_levels")) and len(shown) > 1)
        for number, ((other, made), top) in enumerate(zip(shown, tops, strict=True)):
            with top:
                _actions(on, other, made, first=number == 0)
    _earlier(on, name)


def _compare_bar(on: MakePage, name: str, present: KeptResult, beside: list[tuple[str, KeptResult]]) -> None:
    """Draw what is put beside the present result, and how they are played."""
    desk = on.desk
    taken = {name, *(other for other, _ in beside)}
    offers = {f"made:{made.id}": f"made: {made.title}" for made in desk.results()}
    offers |= {f"kept:{made.id}": f"kept: {made.title}" for made in desk.shelf.all()}
    offers = {key: title for key, title in offers.items() if key not in taken}

    def put(event: Any) -> None:
        if event.value:
            desk.add_comparison(event.value)
            on.results.refresh()

    def levels(event: Any) -> None:
        desk.held["true_levels"] = bool(event.value)
        on.results.refresh()

    with ui.element("section").classes("card bar-compare").props('aria-label="Compare"'):
        if offers:
            select = ui.select(offers, label="Compare with", on_change=report_errors(put))
            select.props("outlined dense options-dense").classes("grow")
        if not present.is_image and present.facts.get("what") == "made":
            nearest = ui.button("Nearest recordings").props("no-caps outline dense")
            nearest.on_click(report_errors(lambda: _nearest(on, present, nearest)))
        if not present.is_image:
            with ui.element("div").props("data-player-loop"):
                loop = ui.checkbox("Loop").props("dense")
                desk.held.setdefault("loop", True)
                loop.bind_value(desk.held, "loop")
        if beside and not present.is_image:
            switch = ui.switch("At their true strengths", value=bool(desk.held.get("true_levels")))
            switch.props("dense").on_value_change(report_errors(levels))
            ui.label("Keys 1 to 9 change between them while they play; Escape stops.").classes("small quiet")


async def _nearest(on: MakePage, present: KeptResult, button: ui.button) -> None:
    """Put the real recordings that are most like the present result beside it."""
    button.disable()
    button.text = "Searching"
    try:
        choice = on.desk.runs.choice(str(present.facts.get("run", "")))
        how, found = await in_background(lambda: on.desk.runs.nearest(choice, present.signal()))
        if not found:
            raise DataError("There is no recording to compare with.")
        for title, signal, simulated in found[:2]:
            facts = {
                "what": "recording",
                "run": choice.name,
                "simulated": simulated,
                "found": how,
            }
            held = await in_background(on.desk.made.keep, signal, title=title, facts=facts)
            on.desk.add_comparison(f"made:{held.id}")
        ui.notify(f"Found {how}.")
    finally:
        button.enable()
        button.text = "Nearest recordings"
        on.results.refresh()


def _actions(on: MakePage, name: str, made: KeptResult, *, first: bool) -> None:
    """Draw what can be done with a result, in the row at its top."""
    desk = on.desk

    async def keep() -> None:
        kept = await in_background(desk.shelf.keep_copy, made)
        desk.record_kept(name, kept)
        ui.notify(f"Kept: {kept.title}.", type="positive")
        on.results.refresh()

    async def rename() -> None:
        title = await ask_title(made.title)
        if title is not None:
            desk.rename(name, title)
            on.results.refresh()

    def away() -> None:
        desk.remove_comparison(name)
        on.results.refresh()

    def promote() -> None:
        before = str(desk.held.get("present"))
        desk.remove_comparison(name)
        desk.select_result(name)
        desk.add_comparison(before)
        on.results.refresh()

    kept = name.removeprefix("kept:") if name.startswith("kept:") else desk.kept_id(name)
    if first and made.facts.get("what") == "made" and not made.is_image:
        _taken_for(on, made)
    with ui.element("div").classes("done"):
        if kept:
            ui.label("Kept").classes("small quiet")
            ui.link("Send", f"/send?of=kept:{kept}").classes("small")
            ui.button("Rename", on_click=report_errors(rename)).props(
                f'no-caps dense flat aria-label="Rename {_plain(made)}"'
            )
        else:
            ui.button("Keep", on_click=report_errors(keep)).props(
                f'no-caps dense outline aria-label="Keep {_plain(made)}"'
            )
        if not first:
            ui.button("Put first", on_click=report_errors(promote)).props(
                f'no-caps dense flat aria-label="Put first: {_plain(made)}"'
            )
            ui.button(icon="close", on_click=report_errors(away)).props(
                f'dense flat aria-label="Take away {_plain(made)}"'
            )


def _plain(made: KeptResult) -> str:
    return made.title.replace('"', "'").replace("\\", "/")


def _taken_for(on: MakePage, made: KeptResult) -> None:
    """Say, as soon as it is known, what a classifier takes a result for; nothing where there is no classifier."""
    said = ui.label("").classes("small quiet taken")

    async def fill() -> None:
        try:
            choice = on.desk.runs.choice(str(made.facts.get("run", "")))
            classifier = on.desk.runs.classifier_for(choice)
            if classifier is None:
                return
            found = await in_background(lambda: on.desk.runs.classify(classifier, made.signal()))
            unlike = ", but unlike all it knows" if found["none_of_these"] else ""
            text = f"Taken for {found['material']} ({found['probability']:.0%}{unlike}) by {classifier.name}"
        except TactogramError as error:
            text = f"Not classified: {error}"
        if not said.is_deleted:
            said.text = text

    ui.timer(0.05, report_errors(fill), once=True)


def _image_card(made: KeptResult, name: str, title: str) -> Any:
    """Draw an image, and return the row at its top."""
    rows, columns = made.image().size
    with ui.element("section").classes("card signal").props(f'role="group" aria-label="{_plain(made)}"'):
        with ui.row().classes("w-full items-center gap-2") as top:
            ui.label(title).classes("h2")
            if made.facts.get("simulated"):
                ui.label("simulated").classes("simulated")
        ui.label(f"{columns} x {rows} pixels").classes("small quiet")
        where, _, id = name.partition(":")
        ui.element("img").classes("made-image").props(
            f'src="/make/image/{where}/{id}" alt="Generated image: {_plain(made)}"'
        )
    return top


def _earlier(on: MakePage, name: str) -> None:
    """List the earlier results of this page."""
    earlier = [made for made in on.desk.results() if f"made:{made.id}" != name]
    if not earlier:
        return

    def look(made: KeptResult) -> None:
        on.desk.remove_comparison(f"made:{made.id}")
        on.desk.select_result(f"made:{made.id}")
        on.results.refresh()

    with ui.element("section").classes("card"):
        ui.label("Made before").classes("h2")
        with ui.element("ul").classes("earlier"):
            for made in earlier:
                with ui.element("li"):
                    button = ui.button(made.title, on_click=report_errors(lambda made=made: look(made)))
                    button.props("no-caps flat dense align=left")
                    ui.label(str(made.facts.get("model", ""))).classes("small quiet")
