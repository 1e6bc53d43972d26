"""The page Live: a sensor's traces, what a classifier makes of it, and recording by a session plan."""

from __future__ import annotations

import shlex
from typing import Any

from nicegui import app, ui
from nicegui.events import KeyEventArguments

from tactogram.errors import ParameterError
from tactogram.studio.context import Studio
from tactogram.studio.layout import in_background, page, report_errors
from tactogram.studio.pages.live.choices import session_state
from tactogram.studio.pages.live.desk import LiveRunner
from tactogram.studio.pages.live.form import LiveForm

LABELS = {"accept": "Accept", "redo": "Repeat", "skip": "Skip", "stop": "Break", "begin": "Begin"}
"""What a session's keys are called here; a break is a stop from which the session goes on later."""
LOOK_S = 0.15
CANVAS = '<canvas id="live-traces" role="img" aria-label="Traces: nothing has come yet"></canvas>'
METER = (
    '<div class="track" aria-hidden="true"><span id="live-level"></span></div>'
    '<p class="small figures"><span id="live-rms"></span> '
    '<span id="live-clip" class="clipped" hidden>CLIPPED</span></p>'
    '<p class="small quiet figures" id="live-facts"></p>'
)


def add(studio: Studio) -> None:
    """Register the page and the route that its pictures are drawn from."""
    desk = LiveRunner(studio.workspace.studio_folder)

    @app.get("/live/now")
    def now(after: int = 0, number: int = 0) -> dict[str, Any]:
        return desk.now(max(0, after), number)

    app.on_shutdown(desk.stop)

    @ui.page("/live")
    def show(data: str = "") -> None:
        ui.add_head_html('<link rel="stylesheet" href="/static/send.css">')
        ui.add_head_html('<link rel="stylesheet" href="/static/live.css">')
        ui.add_body_html('<script type="module" src="/static/live.js"></script>')
        with page("Live"):
            LivePage(studio, desk, data=data)


class LivePage:
    """One tab that looks at the desk, and may answer while no other tab holds it."""

    def __init__(self, studio: Studio, desk: LiveRunner, *, data: str = "") -> None:
        self.studio, self.desk = studio, desk
        self.tab = ui.context.client.id
        ui.context.client.on_disconnect(self._gone)
        self._unfinished()
        with ui.element("div").classes("grid-2") as self._grid:
            with ui.column().classes("items-stretch gap-4"):
                self.form = LiveForm(studio, desk, self._begin, data=data)
            with ui.column().classes("items-stretch gap-4 happening"):
                self._controls()
                self._session()
                self._traces()
                self._guesses()
        self._seen = self._look()
        self._in_order()
        ui.timer(LOOK_S, self._refresh)
        ui.keyboard(on_key=self._pressed, ignore=["input", "select", "textarea"])

    @property
    def holds(self) -> bool:
        """Whether this tab may answer."""
        return self.desk.holder in (None, self.tab)

    def _gone(self) -> None:
        if self.desk.holder == self.tab:
            self.desk.holder = None

    async def _begin(self) -> None:
        order = self.form.order()
        await in_background(self.desk.start, order)
        self.desk.holder = self.tab
        self.form.remember()
        self._refresh()
        ui.run_javascript("document.querySelector('.happening').scrollIntoView({block: 'start'})")

    @report_errors
    async def _stop(self) -> None:
        self._take_part()
        await in_background(self.desk.stop)
        self._refresh()

    @report_errors
    def _answer(self, number: int, key: str) -> None:
        self._take_part()
        self.desk.console.answer(number, key)
        self._refresh()

    def _take_part(self) -> None:
        if not self.holds:
            raise ParameterError("another tab holds the sensor; take over first")
        self.desk.holder = self.tab

    def _take_over(self) -> None:
        self.desk.holder = self.tab
        self._refresh()

    def _pressed(self, event: KeyEventArguments) -> None:
        question = self.desk.console.question
        if not event.action.keydown or event.action.repeat or question is None or not self.holds:
            return
        if event.modifiers.ctrl or event.modifiers.alt or event.modifiers.meta:
            return
        key = str(event.key.name or "").lower()
        if key in question.keys:
            self._answer(question.number, key)

    def _look(self) -> tuple[Any, ...]:
        desk = self.desk
        question = desk.console.question
        held = None if not desk.running else self.holds
        asked = None if question is None else question.number
        return (
            desk.number,
            desk.state,
            asked,
            len(desk.console.lines),
            held,
            desk.error,
            desk.result is None,
        )

    def _refresh(self) -> None:
        seen = self._look()
        if seen == self._seen:
            return
        self._seen = seen
        self._controls.refresh()
        self._session.refresh()
        self._guesses.refresh()
        self._unfinished.refresh()
        self.form.enable(enabled=not self.desk.running)
        self._in_order()

    def _in_order(self) -> None:
        """Put what happens before what can be chosen on a narrow screen, while something happens."""
        running = self.desk.running
        self._grid.classes(add="running" if running else "", remove="" if running else "running")

    @ui.refreshable_method
    def _unfinished(self) -> None:
        """Offer to go on with a session that a crash, a pulled plug or a break ended."""
        order = self.desk.last_order()
        if order is None or not order.plan or self.desk.running:
            return
        found = session_state(self.studio.workspace, order.data, order.session_name)
        if found is None or not found["left"]:
            return
        with ui.element("section").classes("card w-full").props('aria-label="Unfinished session"'):
            ui.label(f"Session {order.session_name} is not finished").classes("h2")
            ended = "It was cut short. " if found["open"] else ""
            skipped = f", {found['skipped']} skipped" if found["skipped"] else ""
            ui.label(
                f"{ended}{found['accepted']} of {found['total']} takes are in the store{skipped}; "
                f"{found['left']} are left."
            )

            @report_errors
            async def go_on() -> None:
                await in_background(self.desk.start, order)
                self.desk.holder = self.tab
                self._refresh()

            ui.button("Go on with it", icon="play_arrow", on_click=go_on)

    @ui.refreshable_method
    def _controls(self) -> None:
        desk = self.desk
        with ui.element("section").classes("card w-full").props('aria-label="State"'):
            with ui.row().classes("items-center justify-between w-full"):
                with ui.column().classes("gap-0"):
                    ui.label(self._state_line()).classes("h2").props('role="status"')
                    if desk.order is not None:
                        with ui.row().classes("items-center gap-2"):
                            ui.label(self._source_line()).classes("small quiet")
                            if desk.order.source.startswith(("simulated:", "played:")):
                                ui.label("simulated").classes("simulated")
                if desk.running and self.holds:
                    ui.button("Stop", icon="stop", on_click=self._stop, color="negative")
                elif desk.running:
                    with ui.row().classes("items-center"):
                        ui.label("Another tab holds it; this one watches.").classes("quiet")
                        ui.button("Take over", on_click=self._take_over).props("outline")
            if desk.error is not None:
                ui.label(desk.error).classes("text-negative").props('role="alert"')
            elif desk.result is not None and not desk.running:
                for line in result_lines(desk.result):
                    ui.label(line)
            command = self._command()
            if command is not None:
                with ui.expansion("The same on the command line").classes("w-full"):
                    ui.label(command).classes("code")

    def _command(self) -> str | None:
        """Return how the command line does the same; traces alone it does not show."""
        order, folder = self.desk.order, f"{self.studio.workspace.folder}/"
        if order is None or not (order.plan or order.run):
            return None
        if not order.plan:
            words = ["tactogram", "live", order.run, "--source", order.source]
        else:
            words = ["tactogram", "capture", order.plan, "--source", order.source, "--data", order.data]
            words += ["--session", order.session] if order.session else []
            words += ["--recognise", order.run] if order.run else []
            for key, value in order.changes.items():
                words += ["--set", f"{key}={value}"]
        return shlex.join(word.replace(folder, "") for word in words)

    def _state_line(self) -> str:
        return {
            "idle": "Nothing is listened to",
            "opening": "Opening the source …",
            "watching": "Listening",
            "recording": "Recording a session",
        }[self.desk.state]

    def _source_line(self) -> str:
        order = self.desk.order
        if order is None:
            return ""
        return order.source.replace(f"{self.studio.workspace.folder}/", "")

    @ui.refreshable_method
    def _session(self) -> None:
        desk = self.desk
        if desk.order is None or not desk.order.plan or not desk.running:
            return
        question = desk.console.question
        with ui.element("section").classes("card w-full").props('aria-label="Session"'):
            with ui.element("div").props('aria-live="assertive"'):
                place = desk.console.status.place if desk.console.status else "Opening"
                ui.label(place).classes("prompt")
                if question is not None and question.text != place:
                    ui.label(question.text.removeprefix(f"{place}: "))
            if question is not None:
                with ui.row().classes("gap-2 mt-2"):
                    for key, meaning in question.keys.items():
                        button = ui.button(
                            f"{LABELS.get(meaning, meaning)} ({key.upper()})",
                            on_click=lambda k=key, n=question.number: self._answer(n, k),
                        ).props(f'data-key="{key}"')
                        if key != question.default:
                            button.props("outline")
                        if not self.holds:
                            button.disable()
            else:
                ui.html(
                    '<p class="figures" id="session-phase" aria-hidden="true"></p>'
                    '<div class="track" aria-hidden="true"><span id="session-share"></span></div>',
                    sanitize=False,
                )
            ui.html(
                '<p class="small quiet mt-2">Move with the dot: one stroke a beat.</p>'
                '<div class="stroke" data-still aria-hidden="true"><span id="session-dot"></span></div>',
                sanitize=False,
            )
            self.form.sound_switch()
            if desk.console.lines:
                with ui.element("ul").classes("said small quiet"):
                    for line in list(desk.console.lines)[-6:][::-1]:
                        ui.element("li")._text = line

    def _traces(self) -> None:
        with ui.element("section").classes("card w-full").props('aria-label="Traces"'):
            ui.label("Traces").classes("h2")
            ui.html(CANVAS, sanitize=False).classes("w-full")
            ui.html(METER, sanitize=False).classes("w-full")

    @ui.refreshable_method
    def _guesses(self) -> None:
        order = self.desk.order
        if order is None or not order.run or order.plan:
            return
        with ui.element("section").classes("card w-full").props('aria-label="What it is taken for"'):
            with ui.row().classes("items-center"):
                ui.label("What it is taken for").classes("h2")
                ui.html('<span id="live-none" class="clipped" hidden>none of these</span>', sanitize=False)
            ui.html('<p id="live-guess-told" class="quiet small figures"></p>', sanitize=False)
            ui.html('<div id="live-guess"></div>', sanitize=False).classes("w-full")


def result_lines(result: dict[str, Any]) -> list[str]:
    """Return what came of what was listened to, a line each."""
    simulated = " (simulated)" if result.get("simulated") else ""
    if "accepted" in result:
        why = f" {result['stopped']}." if result["stopped"] else ""
        return [
            f"Session {result['session']}{simulated}: {result['accepted']} takes accepted, {result['redone']} made "
            f"again, {result['skipped']} skipped, {result['left']} left.{why}",
            f"{result['recordings']} recordings are in {result['store']}.",
        ]
    if "windows" in result:
        latency = result["latency"]
        late = (
            ""
            if latency["p50_ms"] is None
            else f"; p50 {latency['p50_ms']:.0f} ms, p99 {latency['p99_ms']:.0f} ms after the last sample"
        )
        return [f"{result['judged']} of {result['windows']} windows judged{simulated}{late}."]
    source = result["source"]
    return [f"{source['samples']} samples{simulated}, {source['lost']} lost; {result['stopped']}."]
