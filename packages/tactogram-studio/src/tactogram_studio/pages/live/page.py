"""The page Live: a sensor's traces, a classifier's output, and recording by a session plan."""

from __future__ import annotations

from typing import Any

from nicegui import app, ui
from nicegui.events import KeyEventArguments

from tactogram.errors import ParameterError
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.pages.live.form import LiveForm
from tactogram_studio.tasks.live import LiveRequest, LiveRunner
from tactogram_studio.tasks.live_choices import session_state
from tactogram_studio.workspace.commands import arguments, command_line

LABELS = {"accept": "Accept", "redo": "Repeat", "skip": "Skip", "stop": "Break", "begin": "Begin"}
"""Labels of a session's keys; a session continues after a break."""
STATES = {
    "idle": "Not listening",
    "opening": "Opening the source …",
    "watching": "Listening",
    "recording": "Recording a session",
}
UPDATE_S = 0.15
LINES = 6
CANVAS = '<canvas id="live-traces" role="img" aria-label="Traces: no samples yet"></canvas>'
METER = (
    '<div class="track" aria-hidden="true"><span id="live-level"></span></div>'
    '<p class="small figures"><span id="live-rms"></span> '
    '<span id="live-clip" class="clipped" hidden>CLIPPED</span></p>'
    '<p class="small quiet figures" id="live-facts"></p>'
)
PHASE = (
    '<p class="figures" id="session-phase" aria-hidden="true"></p>'
    '<div class="track" aria-hidden="true"><span id="session-share"></span></div>'
)
BEAT = (
    '<p class="small quiet mt-2">Move with the dot: one stroke per beat.</p>'
    '<div class="stroke" data-still aria-hidden="true"><span id="session-dot"></span></div>'
)


def add(studio: Studio) -> None:
    """Register the page and the route of its data."""
    runner = LiveRunner(studio.workspace.studio_folder)

    @app.get("/live/now")
    def now(after: int = 0, number: int = 0) -> dict[str, Any]:
        return runner.now(max(0, after), number)

    app.on_shutdown(runner.stop)

    @kit.route("/live")
    def show(data: str = "", run: str = "", key: str = "") -> None:
        ui.add_head_html('<link rel="stylesheet" href="/static/live.css">')
        ui.add_body_html('<script type="module" src="/static/live.js"></script>')
        with kit.page("Live"):
            LivePage(studio, runner, data=data, run=run, key=key)


class LivePage:
    """One tab; it may answer questions while no other tab controls the sensor."""

    def __init__(
        self, studio: Studio, runner: LiveRunner, *, data: str = "", run: str = "", key: str = ""
    ) -> None:
        self.studio, self.runner = studio, runner
        self.tab = ui.context.client.id
        ui.context.client.on_disconnect(self._release)
        self._drawn = self._parts()
        self._unfinished()
        with ui.element("div").classes("grid-2") as self._grid:
            with ui.column().classes("items-stretch gap-4"):
                self.form = LiveForm(studio, runner, self._start, data=data, run=run, key=key)
            with ui.column().classes("items-stretch gap-4 happening"):
                self._controls()
                self._session()
                with kit.card("Traces"):
                    ui.html(CANVAS, sanitize=False).classes("w-full")
                    ui.html(METER, sanitize=False).classes("w-full")
                self._classification()
        self._order_columns()
        ui.timer(UPDATE_S, self._refresh)
        ui.keyboard(on_key=self._pressed, ignore=["input", "select", "textarea"])

    @property
    def controls_sensor(self) -> bool:
        """Whether this tab may answer questions."""
        return self.runner.holder in (None, self.tab)

    def _release(self) -> None:
        if self.runner.holder == self.tab:
            self.runner.holder = None

    async def _start(self) -> None:
        await self._run(self.form.request())
        ui.run_javascript("document.querySelector('.happening').scrollIntoView({block: 'start'})")

    async def _run(self, request: LiveRequest) -> None:
        await kit.in_background(self.runner.start, request)
        self.runner.holder = self.tab
        self._refresh()

    async def _stop(self) -> None:
        self._take_control()
        await kit.in_background(self.runner.stop)
        self._refresh()

    def _answer(self, number: int, key: str) -> None:
        self._take_control()
        self.runner.console.answer(number, key)
        self._refresh()

    def _take_control(self) -> None:
        if not self.controls_sensor:
            raise ParameterError("another tab controls the sensor; take over first")
        self.runner.holder = self.tab

    def _take_over(self) -> None:
        self.runner.holder = self.tab
        self._refresh()

    def _pressed(self, event: KeyEventArguments) -> None:
        question = self.runner.console.question
        if not event.action.keydown or event.action.repeat or question is None or not self.controls_sensor:
            return
        if event.modifiers.ctrl or event.modifiers.alt or event.modifiers.meta:
            return
        key = str(event.key.name or "").lower()
        if key in question.keys:
            self._answer(question.number, key)

    def _parts(self) -> dict[str, tuple[Any, ...]]:
        """Return what each refreshable part of the page shows.

        A part is redrawn only when this changes: a click on a button that was redrawn meanwhile is lost.
        """
        runner, question = self.runner, self.runner.console.question
        request = (runner.number, runner.running)
        control = self.controls_sensor if runner.running else None
        status = runner.console.status
        stage = None if status is None else status.place
        return {
            "_unfinished": request,
            "_controls": (*request, control, runner.error, runner.result is None),
            "_session": request,
            "_question": (*request, control, None if question is None else question.number, stage),
            "_lines": (*request, *runner.console.lines),
            "_classification": request,
        }

    def _refresh(self) -> None:
        parts, drawn = self._parts(), self._drawn
        self._drawn = parts
        redrawn = [name for name in parts if parts[name] != drawn[name]]
        for name in redrawn:
            getattr(self, name).refresh()
        if redrawn:
            self.form.enable(enabled=not self.runner.running)
            self._order_columns()

    def _order_columns(self) -> None:
        """Put the form last on a narrow screen while a request is running."""
        running = self.runner.running
        self._grid.classes(add="running" if running else "", remove="" if running else "running")

    @ui.refreshable_method
    def _unfinished(self) -> None:
        """Offer to continue a session after a crash, a disconnected sensor or a break."""
        request = self.runner.last_request()
        if request is None or not request.plan or self.runner.running:
            return
        state = session_state(self.studio.workspace, request.data, request.session_name)
        if state is None or not state["left"]:
            return
        with kit.card(f"Session {request.session_name} is not finished", label="Unfinished session"):
            ended = "It was interrupted. " if state["open"] else ""
            skipped = f", {state['skipped']} skipped" if state["skipped"] else ""
            ui.label(
                f"{ended}{state['accepted']} of {state['total']} takes are in the store{skipped}, "
                f"{state['left']} left."
            )
            ui.button("Continue the session", icon="play_arrow", on_click=lambda: self._run(request))

    @ui.refreshable_method
    def _controls(self) -> None:
        runner = self.runner
        with kit.card(label="State"):
            with ui.row().classes("items-center justify-between w-full"):
                with ui.column().classes("gap-0"):
                    state = ui.label().classes("h2").props('role="status"')
                    state.bind_text_from(runner, "state", STATES.__getitem__)
                    if runner.request is None:
                        kit.hint("Listen to a source, or record a session of takes.")
                    else:
                        with ui.row().classes("items-center gap-2"):
                            kit.hint(self._relative(runner.request.source))
                            if runner.request.source.startswith(("simulated:", "played:")):
                                ui.label("simulated").classes("simulated")
                if runner.running and self.controls_sensor:
                    ui.button("Stop", icon="stop", on_click=self._stop, color="negative")
                elif runner.running:
                    with ui.row().classes("items-center"):
                        ui.label("Another tab controls the sensor; this tab only watches.").classes("quiet")
                        ui.button("Take over", on_click=self._take_over).props("outline")
            if runner.error is not None:
                kit.alert(runner.error)
            elif runner.result is not None and not runner.running:
                for line in result_lines(runner.result):
                    ui.label(line)
            if runner.request is not None and (runner.request.plan or runner.request.run):
                kit.command_lines([self._relative(_command(runner.request))])

    def _relative(self, text: str) -> str:
        return text.replace(f"{self.studio.workspace.folder}/", "")

    @ui.refreshable_method
    def _session(self) -> None:
        runner = self.runner
        if runner.request is None or not runner.request.plan or not runner.running:
            return
        with kit.card(label="Session"):
            self._question()
            ui.html(BEAT, sanitize=False)
            self.form.sound_switch()
            self._lines()

    @ui.refreshable_method
    def _question(self) -> None:
        console = self.runner.console
        status, question = console.status, console.question
        with ui.element("div").props('aria-live="assertive"'):
            stage = status.place if status else "Opening"
            ui.label(stage).classes("prompt")
            if question is not None and question.text != stage:
                ui.label(question.text.removeprefix(f"{stage}: "))
        if question is None:
            ui.html(PHASE, sanitize=False)
            return
        with ui.row().classes("gap-2 mt-2"):
            for key, meaning in question.keys.items():
                button = ui.button(
                    f"{LABELS.get(meaning, meaning)} ({key.upper()})",
                    on_click=lambda k=key, n=question.number: self._answer(n, k),
                ).props(f'data-key="{kit.attribute(key)}"')
                if key != question.default:
                    button.props("outline")
                if not self.controls_sensor:
                    button.disable()

    @ui.refreshable_method
    def _lines(self) -> None:
        lines = self.runner.console.lines
        if lines:
            with ui.element("ul").classes("sentences small quiet"):
                for line in list(lines)[: -LINES - 1 : -1]:
                    ui.element("li")._text = line

    @ui.refreshable_method
    def _classification(self) -> None:
        request = self.runner.request
        if request is None or not request.run or request.plan:
            return
        with kit.card(label="Classified as"):
            with ui.row().classes("items-center"):
                kit.heading("Classified as")
                ui.html('<span id="live-none" class="clipped" hidden>none of these</span>', sanitize=False)
            ui.html('<p id="live-guess-line" class="quiet small figures"></p>', sanitize=False)
            ui.html('<div id="live-guess"></div>', sanitize=False).classes("w-full")


def _command(request: LiveRequest) -> str:
    if not request.plan:
        return command_line(arguments("live", request.run, source=request.source))
    words = arguments(
        "capture",
        request.plan,
        source=request.source,
        data=request.data,
        session=request.session,
        recognise=request.run,
        changes=[f"{key}={value}" for key, value in request.changes.items()],
    )
    return command_line(words)


def result_lines(result: dict[str, Any]) -> list[str]:
    """Return a request's result in lines for people."""
    simulated = " (simulated)" if result.get("simulated") else ""
    if "accepted" in result:
        reason = f" {result['stopped']}." if result["stopped"] else ""
        return [
            f"Session {result['session']}{simulated}: {result['accepted']} takes accepted, {result['redone']} "
            f"repeated, {result['skipped']} skipped, {result['left']} left.{reason}",
            f"{result['recordings']} recordings are in {result['store']}.",
        ]
    if "windows" in result:
        latency = result["latency"]
        delay = (
            ""
            if latency["p50_ms"] is None
            else f"; p50 {latency['p50_ms']:.0f} ms, p99 {latency['p99_ms']:.0f} ms after the last sample"
        )
        return [f"{result['judged']} of {result['windows']} windows classified{simulated}{delay}."]
    source = result["source"]
    return [f"{source['samples']} samples{simulated}, {source['lost']} lost; {result['stopped']}."]
