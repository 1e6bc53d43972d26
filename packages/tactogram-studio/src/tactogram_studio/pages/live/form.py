"""Form of the page Live: source, classifier and plan, stored in the browser for its next visit."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from nicegui import app, ui

from tactogram.errors import ParameterError, TactogramError
from tactogram_capture import find_sources
from tactogram_capture.session.plan import SessionPlan, shipped_plans
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.tasks.live import LiveRequest, LiveRunner
from tactogram_studio.tasks.live_choices import (
    SourceChoice,
    confine_address,
    plan_choices,
    session_state,
    source_choices,
    without_materials,
)
from tactogram_studio.workspace.runs import RunCatalogue

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
    """Cards with the settings; ``start`` starts the `request`.

    ``data`` and ``run`` are the store and the classifier of the page's address.
    ``key`` is that of `kit.TabSettings`.
    """

    def __init__(
        self,
        studio: Studio,
        runner: LiveRunner,
        start: Callable[[], Awaitable[None]],
        *,
        data: str = "",
        run: str = "",
        key: str = "",
    ) -> None:
        self.studio, self._start_request = studio, start
        self.state = kit.TabSettings(app.storage.user.setdefault(STATE, {}), key)
        kit.keep_address("/live", key=self.state.key)
        self.fields = kit.Form(self.state)
        self._choices: list[SourceChoice] = []
        self._recording = False
        self.state.update({name: value for name, value in (("data", data), ("run", run)) if value})
        with kit.card("Source"):
            self._address = self.fields.text("source", "Address", hint="choose one below, or type it")
            with ui.column().classes("gap-3 mt-4 w-full"):
                self._sources()
            ui.button("Look for devices again", icon="refresh", on_click=self._look).props("outline dense")
        self._buttons = [self._listen_card(), self._record_card()]
        self.enable(enabled=not runner.running)
        ui.timer(0.05, self._look, once=True)

    def _listen_card(self) -> ui.button:
        with kit.card("Listen"):
            runs = RunCatalogue(self.studio.workspace).own("classification")
            names = {run.name: f"{run.name} ({len(run.kind.materials)} materials)" for run in runs}
            self.fields.choice("run", {"": "no classifier: traces only", **names}, "Classifier", "")
            if not names:
                ui.link("Train a classifier", "/train?purpose=recognition").classes("small")
            return ui.button("Listen", icon="hearing", on_click=lambda: self._start(recording=False))

    def _record_card(self) -> ui.button:
        with kit.card("Record a session"):
            plan = self.fields.choice("plan", plan_choices(self.studio.workspace), "Plan")
            plan.on_value_change(self._describe_plan)
            self._plan_line = kit.hint("")
            self.fields.text("data", "Store (folder)", "recordings")
            self.fields.text("subject", "Subject (a code, not a name)")
            self.fields.text("session", "Session", hint="empty: named after plan and subject")
            with ui.expansion("Change values of the plan").classes("w-full"):
                for name, label in PLAN_FIELDS.items():
                    self.fields.text(name, label)
                kit.hint("Empty fields keep the plan's values.")
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
        switch.props('id="session-sound"').props(f'data-on="{kit.attribute(int(bool(switch.value)))}"')

        def changed() -> None:
            self.state["sound"] = switch.value
            switch.props["data-on"] = int(bool(switch.value))

        switch.on_value_change(changed)

    async def _look(self) -> None:
        try:
            sources = await kit.in_background(find_sources)
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
                kit.hint("Looking for devices …")
        for choice in self._choices:
            if choice.address is None:
                continue
            with ui.row().classes("items-center no-wrap w-full gap-2"):
                use = ui.button("Use", on_click=lambda a=choice.address: self._address.set_value(a))
                use.props(f'outline dense aria-label="Use {kit.attribute(choice.address)}"')
                with ui.column().classes("gap-0"):
                    ui.label(f"{choice.description[:1].upper()}{choice.description[1:]}").classes("small")
                    kit.hint(choice.address).style("overflow-wrap:anywhere")
        missing = [choice for choice in self._choices if choice.address is None]
        if missing:
            with ui.expansion(f"{len(missing)} kinds of sensor are not available").classes("w-full"):
                for choice in missing:
                    kit.hint(choice.missing or choice.description).style("overflow-wrap:anywhere")

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
        name = self.fields.stripped("plan")
        return name if name in shipped_plans() else str(self.studio.workspace.inside(name))

    def enable(self, *, enabled: bool) -> None:
        """Enable or disable the buttons that start a request."""
        for button in self._buttons:
            button.set_enabled(enabled)

    async def _start(self, *, recording: bool) -> None:
        self._recording = recording
        await self._start_request()

    def request(self) -> LiveRequest:
        """Return the request that the form describes; `TactogramError` if a field is invalid."""
        workspace, entry = self.studio.workspace, self.fields.stripped
        if not entry("source"):
            raise ParameterError("choose a source, or type its address")
        source = confine_address(workspace, entry("source"))
        run = str(workspace.inside(entry("run"))) if entry("run") else ""
        if not self._recording:
            return LiveRequest(source, run)
        if not entry("data"):
            raise ParameterError("a session needs a store; enter a folder's name")
        request = LiveRequest(
            without_materials(source),
            run,
            self._plan_path(),
            str(workspace.inside(entry("data"))),
            entry("session"),
            self._plan_changes(),
        )
        session_state(workspace, request.data, request.session_name)  # refuses a name that leads out
        return request

    def _plan_changes(self) -> dict[str, Any]:
        entry = self.fields.stripped
        changes: dict[str, Any] = {"subject": entry("subject"), "materials": entry("materials")}
        for name, key, convert in (
            ("speeds", "speeds_mm_s", lambda text: [float(part) for part in text.split(",")]),
            ("repetitions", "repetitions", int),
            ("seconds", "seconds", float),
        ):
            try:
                changes[key] = convert(entry(name)) if entry(name) else ""
            except ValueError:
                raise ParameterError(f"{PLAN_FIELDS[name]} must be a number, got {entry(name)!r}") from None
        return {key: value for key, value in changes.items() if value != ""}
