"""Form of the page Live: source, classifier and plan, stored in the browser for its next visit."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from nicegui import app, ui

from tactogram.errors import ParameterError, TactogramError
from tactogram_capture import find_sources
from tactogram_capture.session.plan import SessionPlan, shipped_plans
from tactogram_studio.context import Studio
from tactogram_studio.layout import heading, hint, in_background, report_errors
from tactogram_studio.pages.live.choices import (
    SourceChoice,
    classifiers,
    confine_address,
    plan_choices,
    session_state,
    source_choices,
    without_materials,
)
from tactogram_studio.pages.live.runner import LiveRequest, LiveRunner

STATE = "live"
"""Key of the form in the browser's storage."""
PLAN_FIELDS = {
    "materials": "Materials",
    "speeds": "Speeds, mm/s",
    "repetitions": "Repetitions",
    "seconds": "Seconds per take",
}
"""Labels of the plan's values that can be changed, by name in the browser's storage."""


class LiveForm:
    """Cards with the settings; ``start`` starts the `request`, ``data`` is the store that the page was opened with."""

    def __init__(
        self, studio: Studio, runner: LiveRunner, start: Callable[[], Awaitable[None]], *, data: str = ""
    ) -> None:
        self.studio, self._start_request = studio, start
        self.state: dict[str, Any] = app.storage.user.setdefault(STATE, {})
        self._choices: list[SourceChoice] = []
        self._recording = False
        with ui.element("section").classes("card w-full").props('aria-label="Source"'):
            heading("Source")
            self._address = self._text("source", "Address", hint="choose one below, or type it")
            with ui.column().classes("gap-3 mt-4 w-full"):
                self._sources()
            ui.button("Look for devices again", icon="refresh", on_click=self._look).props("flat dense")
        self._buttons = [self._listen_card(), self._record_card(data)]
        self.enable(enabled=not runner.running)
        ui.timer(0.05, self._look, once=True)

    def _text(self, name: str, label: str, *, hint: str = "", default: str = "") -> ui.input:
        field = ui.input(label, value=self.state.get(name, default)).classes("w-full")
        return field.props(f'hint="{hint}"') if hint else field

    def _listen_card(self) -> ui.button:
        with ui.element("section").classes("card w-full").props('aria-label="Listen"'):
            heading("Listen")
            names = classifiers(self.studio.workspace)
            options = {"": "no classifier: traces only", **names}
            run = self.state.get("run", "")
            self._run = ui.select(options, label="Classifier", value=run if run in options else "").classes(
                "w-full"
            )
            if not names:
                hint("No classifier in this workspace yet: train stroke_cnn on the page Train.")
            return ui.button("Listen", icon="hearing", on_click=lambda: self._start(recording=False))

    def _record_card(self, data: str) -> ui.button:
        plans = plan_choices(self.studio.workspace)
        with ui.element("section").classes("card w-full").props('aria-label="Record a session"'):
            heading("Record a session")
            plan = self.state.get("plan", "")
            self._plan = ui.select(
                plans,
                label="Plan",
                value=plan if plan in plans else next(iter(plans), None),
                on_change=self._describe_plan,
            ).classes("w-full")
            self._plan_line = hint("")
            self._data = self._text("data", "Store (folder)", default="recordings")
            if data:
                self._data.value = data
            self._subject = self._text("subject", "Subject (a code, not a name)")
            self._session = self._text("session", "Session", hint="empty: named after plan and subject")
            with ui.expansion("Change values of the plan").classes("w-full"):
                self._changes = {name: self._text(name, label) for name, label in PLAN_FIELDS.items()}
                hint("Empty fields keep the plan's values.")
            button = ui.button(
                "Start or continue",
                icon="fiber_manual_record",
                on_click=lambda: self._start(recording=True),
            )
        self._describe_plan()
        return button

    def sound_switch(self) -> None:
        """Draw the switch of the metronome's sound."""
        switch = ui.switch("Play the beat in this tab", value=self.state.get("sound", True))
        switch.props('id="session-sound"').props(f'data-on="{int(bool(switch.value))}"')

        def changed() -> None:
            self.state["sound"] = switch.value
            switch.props(f'data-on="{int(bool(switch.value))}"')

        switch.on_value_change(changed)

    async def _look(self) -> None:
        try:
            sources = await in_background(find_sources)
        except TactogramError as error:
            sources = [{"kind": "device", "address": None, "what": "device", "missing": str(error)}]
        self._choices = source_choices(self.studio.workspace, sources)
        # Not the first serial port: nearly every machine has one, and nearly none has a sensor on it.
        simulated = [choice.address for choice in self._choices if choice.simulated]
        if not self._address.value and simulated:
            self._address.value = simulated[0]
        self._sources.refresh()

    @ui.refreshable_method
    def _sources(self) -> None:
        if not self._choices:
            with ui.row().classes("items-center"):
                ui.spinner(size="sm")
                hint("Looking for devices …")
        for choice in self._choices:
            if choice.address is None:
                continue
            with ui.row().classes("items-center no-wrap w-full gap-2"):
                ui.button("Use", on_click=lambda a=choice.address: self._address.set_value(a)).props(
                    f'outline dense aria-label="Use {choice.address}"'
                )
                with ui.column().classes("gap-0"):
                    ui.label(choice.address).classes("small").style("overflow-wrap:anywhere")
                    hint(choice.description)
        missing = [choice for choice in self._choices if choice.address is None]
        if missing:
            with ui.expansion(f"{len(missing)} kinds of sensor are not available").classes("w-full"):
                for choice in missing:
                    hint(choice.missing or choice.description).style("overflow-wrap:anywhere")

    def _describe_plan(self) -> None:
        try:
            plan = SessionPlan.load(self._plan_path())
        except TactogramError as error:
            self._plan_line.text = str(error)
            return
        self._plan_line.text = (
            f"{plan.combinations * plan.repetitions} takes of {plan.seconds:g} s: {len(plan.materials)} materials "
            f"({', '.join(plan.materials[:4])}{' …' if len(plan.materials) > 4 else ''}), "
            f"{', '.join(f'{speed:g}' for speed in plan.speeds_mm_s)} mm/s"
        )

    def _plan_path(self) -> str:
        name = str(self._plan.value or "")
        return name if name in shipped_plans() else str(self.studio.workspace.inside(name))

    def enable(self, *, enabled: bool) -> None:
        """Enable or disable the buttons that start a request."""
        for button in self._buttons:
            button.set_enabled(enabled)

    @report_errors
    async def _start(self, *, recording: bool) -> None:
        self._recording = recording
        await self._start_request()

    def request(self) -> LiveRequest:
        """Return the request that the form describes; `TactogramError` if a field is invalid."""
        workspace = self.studio.workspace
        address = _stripped(self._address)
        if not address:
            raise ParameterError("choose a source, or type its address")
        source = confine_address(workspace, address)
        run = str(workspace.inside(self._run.value)) if self._run.value else ""
        if not self._recording:
            return LiveRequest(source, run)
        data = _stripped(self._data)
        if not data:
            raise ParameterError("a session needs a store; enter a folder's name")
        request = LiveRequest(
            without_materials(source),
            run,
            self._plan_path(),
            str(workspace.inside(data)),
            _stripped(self._session),
            self._plan_changes(),
        )
        session_state(workspace, request.data, request.session_name)  # refuses a name that leads out
        return request

    def _plan_changes(self) -> dict[str, Any]:
        texts = {name: _stripped(field) for name, field in self._changes.items()}
        changes: dict[str, Any] = {"subject": _stripped(self._subject), "materials": texts["materials"]}
        for name, key, convert in (
            ("speeds", "speeds_mm_s", lambda text: [float(part) for part in text.split(",")]),
            ("repetitions", "repetitions", int),
            ("seconds", "seconds", float),
        ):
            try:
                changes[key] = convert(texts[name]) if texts[name] else ""
            except ValueError:
                raise ParameterError(f"{PLAN_FIELDS[name]} must be a number, got {texts[name]!r}") from None
        return {key: value for key, value in changes.items() if value != ""}

    def remember(self) -> None:
        """Store the form in the browser."""
        fields = {
            "source": self._address,
            "run": self._run,
            "plan": self._plan,
            "data": self._data,
            "subject": self._subject,
            "session": self._session,
            **self._changes,
        }
        self.state.update({name: field.value for name, field in fields.items()})


def _stripped(field: ui.input) -> str:
    return str(field.value or "").strip()
