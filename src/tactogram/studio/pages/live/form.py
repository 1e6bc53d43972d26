"""Form of the page Live: source, classifier, plan; kept for the next visit."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from nicegui import app, ui

from tactogram.capture.session.plan import SessionPlan, shipped_plans
from tactogram.errors import ParameterError, TactogramError
from tactogram.studio.context import Studio
from tactogram.studio.layout import in_background, report_errors
from tactogram.studio.pages.live.choices import (
    SourceChoice,
    classifiers,
    confined,
    needs_material,
    plan_choices,
    session_state,
    source_choices,
)
from tactogram.studio.pages.live.desk import LiveRequest, LiveRunner
from tactogram.workflows.capture.logs import list_sources

KEPT = "live"
"""Under which the form is kept for a browser."""


class LiveForm:
    """The cards on the left.

    Parameters
    ----------
    studio : Studio
    desk : Desk
    begin : callable
        Begins what `order` says.
    data : str
        Store that the page was opened with.
    """

    def __init__(
        self, studio: Studio, desk: LiveRunner, begin: Callable[[], Awaitable[None]], *, data: str = ""
    ) -> None:
        self.studio, self.desk, self._begin_order = studio, desk, begin
        kept: dict[str, Any] = app.storage.user.setdefault(KEPT, {})
        self.kept = kept
        self._choices: list[SourceChoice] = []
        self._buttons: list[ui.button] = []
        with ui.element("section").classes("card w-full").props('aria-label="Source"'):
            ui.label("Source").classes("h2")
            self._address = ui.input("Address").classes("w-full").props('hint="choose below, or type one"')
            self._address.value = kept.get("source", "")
            with ui.column().classes("gap-3 mt-4 w-full"):
                self._sources()
            ui.button("Look for devices again", icon="refresh", on_click=self._look).props("flat dense")
        self._listen_card()
        self._record_card(data)
        self.enable(enabled=not desk.running)
        ui.timer(0.05, self._look, once=True)

    def _listen_card(self) -> None:
        with ui.element("section").classes("card w-full").props('aria-label="Listen"'):
            ui.label("Listen").classes("h2")
            names = classifiers(self.studio.workspace)
            options = {"": "no classifier: traces only", **names}
            run = self.kept.get("run", "")
            self._run = ui.select(options, label="Classifier", value=run if run in options else "").classes(
                "w-full"
            )
            if not names:
                ui.label("No classifier in this workspace yet: train stroke_cnn on the page Train.").classes(
                    "small quiet"
                )
            self._buttons.append(
                ui.button(
                    "Listen", icon="hearing", on_click=report_errors(lambda: self._start(recording=False))
                )
            )

    def _record_card(self, data: str) -> None:
        kept, plans = self.kept, plan_choices(self.studio.workspace)
        with ui.element("section").classes("card w-full").props('aria-label="Record by a session plan"'):
            ui.label("Record by a session plan").classes("h2")
            plan = kept.get("plan", "")
            self._plan = ui.select(
                plans,
                label="Plan",
                value=plan if plan in plans else next(iter(plans), None),
                on_change=self._plan_chosen,
            ).classes("w-full")
            self._told = ui.label().classes("small quiet")
            self._data = ui.input("Store (folder)", value=data or kept.get("data", "recordings")).classes(
                "w-full"
            )
            self._subject = ui.input("Subject (a code, no name)", value=kept.get("subject", "")).classes(
                "w-full"
            )
            self._session = ui.input("Session", value=kept.get("session", "")).classes("w-full")
            self._session.props('hint="empty: the plan and the subject"')
            with ui.expansion("Change values of the plan").classes("w-full"):
                self._materials = ui.input("Materials", value=kept.get("materials", "")).classes("w-full")
                self._speeds = ui.input("Speeds, mm/s", value=kept.get("speeds", "")).classes("w-full")
                self._repetitions = ui.input("Repetitions", value=kept.get("repetitions", "")).classes(
                    "w-full"
                )
                self._seconds = ui.input("Seconds a take", value=kept.get("seconds", "")).classes("w-full")
                ui.label("Empty: as the plan says.").classes("small quiet")
            self._buttons.append(
                ui.button(
                    "Begin or go on",
                    icon="fiber_manual_record",
                    on_click=report_errors(lambda: self._start(recording=True)),
                )
            )
        self._plan_chosen()

    def sound_switch(self) -> None:
        """Draw the switch of the metronome's sound."""
        switch = ui.switch("Sound the beat in this tab", value=self.kept.get("sound", True))
        switch.props('id="session-sound"').props(f'data-on="{int(bool(switch.value))}"')

        def changed() -> None:
            self.kept["sound"] = switch.value
            switch.props(f'data-on="{int(bool(switch.value))}"')

        switch.on_value_change(changed)

    async def _look(self) -> None:
        try:
            found = await in_background(list_sources)
        except TactogramError as error:
            found = [{"kind": "device", "address": None, "what": "device", "missing": str(error)}]
        self._choices = source_choices(self.studio.workspace, found)
        # A serial port is nearly always there, and nearly never has a sensor on it: begin with what surely works.
        simulated = [choice.address for choice in self._choices if choice.simulated]
        if not self._address.value and simulated:
            self._address.value = simulated[0]
        self._sources.refresh()

    @ui.refreshable_method
    def _sources(self) -> None:
        if not self._choices:
            with ui.row().classes("items-center"):
                ui.spinner(size="sm")
                ui.label("looking for devices").classes("quiet small")
        for choice in self._choices:
            if choice.address is None:
                continue
            with ui.row().classes("items-center no-wrap w-full gap-2"):
                ui.button("Use", on_click=lambda c=choice: self._use(c)).props(
                    f'outline dense aria-label="Use {choice.address}"'
                )
                with ui.column().classes("gap-0"):
                    ui.label(choice.address).classes("small").style("overflow-wrap:anywhere")
                    ui.label(choice.what).classes("small quiet")
        missing = [choice for choice in self._choices if choice.address is None]
        if missing:
            with ui.expansion(f"{len(missing)} kinds of sensor are not there").classes("w-full"):
                for choice in missing:
                    ui.label(choice.missing or choice.what).classes("small quiet").style(
                        "overflow-wrap:anywhere"
                    )

    def _use(self, choice: SourceChoice) -> None:
        self._address.value = choice.address or ""

    def _plan_chosen(self) -> None:
        name = str(self._plan.value or "")
        try:
            values = SessionPlan.load(self._plan_path(name))
        except TactogramError as error:
            self._told.text = str(error)
            return
        count = values.combinations * values.repetitions
        self._told.text = (
            f"{count} takes of {values.seconds:g} s: {len(values.materials)} materials "
            f"({', '.join(values.materials[:4])}{' …' if len(values.materials) > 4 else ''}), "
            f"{', '.join(f'{speed:g}' for speed in values.speeds_mm_s)} mm/s"
        )

    def _plan_path(self, name: str) -> str:
        return name if name in shipped_plans() else str(self.studio.workspace.inside(name))

    def enable(self, *, enabled: bool) -> None:
        """Let begin, or not while something runs."""
        for button in self._buttons:
            button.set_enabled(enabled)

    async def _start(self, *, recording: bool) -> None:
        self._recording = recording
        await self._begin_order()

    def order(self) -> LiveRequest:
        """Return what is asked for.

        Raises
        ------
        TactogramError
            If something of it cannot be; one sentence.
        """
        workspace = self.studio.workspace
        address = str(self._address.value or "").strip()
        if not address:
            raise ParameterError("choose a source, or type its address")
        source = confined(workspace, address)
        run = str(workspace.inside(self._run.value)) if self._run.value else ""
        if not self._recording:
            return LiveRequest(source, run)
        data = str(self._data.value or "").strip()
        if not data:
            raise ParameterError("a session needs a store to record into: give it a folder's name")
        changes = self._changes()
        order = LiveRequest(
            needs_material(source),
            run,
            self._plan_path(str(self._plan.value)),
            str(workspace.inside(data)),
            str(self._session.value or "").strip(),
            changes,
        )
        session_state(workspace, order.data, order.session_name)  # refuses a name that leads out
        return order

    def _changes(self) -> dict[str, Any]:
        changes: dict[str, Any] = {}
        for key, field in (("subject", self._subject), ("materials", self._materials)):
            if str(field.value or "").strip():
                changes[key] = str(field.value).strip()
        for key, field, kind in (
            ("speeds_mm_s", self._speeds, "numbers"),
            ("repetitions", self._repetitions, "whole"),
            ("seconds", self._seconds, "number"),
        ):
            text = str(field.value or "").strip()
            if not text:
                continue
            try:
                if kind == "numbers":
                    changes[key] = [float(part) for part in text.split(",")]
                else:
                    changes[key] = int(text) if kind == "whole" else float(text)
            except ValueError:
                label = str(field.props.get("label", key))
                raise ParameterError(f"{label} must be a number, got {text!r}") from None
        return changes

    def remember(self) -> None:
        """Keep the form for the next visit of this browser."""
        self.kept.update(
            source=self._address.value,
            run=self._run.value,
            plan=self._plan.value,
            data=self._data.value,
            subject=self._subject.value,
            session=self._session.value,
            materials=self._materials.value,
            speeds=self._speeds.value,
            repetitions=self._repetitions.value,
            seconds=self._seconds.value,
        )
