"""Drop a new recording: what is it like, what is it called, and put it into a data set."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

from nicegui import app, events, ui

from tactogram.datasets import Store
from tactogram.errors import ParameterError, TactogramError
from tactogram.signal import Signal
from tactogram.signal.io import READABLE, SignalFile, read_file
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.io.files import SOUND
from tactogram.studio.layout import NumberField, busy, in_background, page, report_errors, upload
from tactogram.studio.pages.materials.media import HEAD, MaterialsContext, address
from tactogram.studio.pages.materials.neighbours import draw_near
from tactogram.studio.pages.train.trainings import free_name
from tactogram.studio.signals.view import add_routes, signal_card
from tactogram.studio.workspace.uploads import checked, read_uploaded_signal, save_upload
from tactogram.workflows.data.stores import add_signal

UNITS = ("", "m/s^2", "g", "m/s", "mm/s", "m", "mm", "N", "V", "1")
PICTURES = ".png,.jpg,.jpeg,.webp,.tif,.tiff,.bmp"


def add(desk: MaterialsContext) -> None:
    """Register ``/materials/drop``."""
    add_routes()

    @ui.page("/materials/drop")
    async def show(file: str = "", set: str = "", unit: str = "", rate: str = "", axes: str = "") -> None:
        ui.add_head_html(HEAD)
        with page("Materials"):
            ui.link("All data sets", "/materials").classes("small")
            drop = _DroppedFile(desk, file, set, unit, rate, axes)
            drop.draw_upload()
            if file:
                await drop.draw_file()


class _DroppedFile:
    """A dropped file, kept in the workspace until it is added or removed, and what is said of it in the address."""

    def __init__(
        self, desk: MaterialsContext, file: str, set_name: str, unit: str, rate: str, axes: str
    ) -> None:
        self.desk, self.file = desk, file
        self.unit, self.rate, self.axes = unit, _number(rate), axes
        workspace = desk.studio.workspace
        self.folder = workspace.own / "dropped"
        self.sets = [workspace.name_of(path) for path in workspace.stores()]
        self.asked = set_name if set_name in self.sets else ""
        self.set = self.asked or (self.sets[0] if self.sets else "")

    @property
    def path(self) -> Path:
        path = self.desk.studio.workspace.inside(self.folder / self.file)
        if path.parent != self.folder or not path.is_file():
            raise ParameterError(f"{self.file[:100]}: is not here any more; drop it again")
        return path

    def go(self, **changes: Any) -> None:
        now = {"file": self.file, "set": self.set, "unit": self.unit, "rate": self.rate, "axes": self.axes}
        ui.navigate.to(address("drop", **(now | changes)))

    # -- the file ------------------------------------------------------------------------------------------

    def draw_upload(self) -> None:
        async def take(event: events.UploadEventArguments) -> None:
            data = await event.file.read()
            with busy(f"reading {event.file.name}"):
                saved = await in_background(keep_signal, self.folder, event.file.name, data)
            self.go(file=saved.name, set=self.asked, unit="", rate="", axes="")

        with ui.element("section").classes("card w-full"):
            ui.label("Drop a new recording").classes("h2").props('role="heading" aria-level="2"')
            ui.label(f"One of {', '.join(READABLE)}. It stays on this machine.").classes("small quiet")
            given = upload("Drop a file here, or choose one", on_upload=report_errors(take))
            given.props(f'accept="{",".join(READABLE)}"').classes("w-full")
            given.on(
                "rejected", lambda: ui.notify(f"It must be one of {', '.join(READABLE)}.", type="negative")
            )

    async def draw_file(self) -> None:
        try:
            known = await in_background(self._read)
        except (TactogramError, OSError, ValueError) as error:
            with ui.element("section").classes("card w-full"):
                ui.label(self.file).classes("h2")
                ui.label(str(error).replace(f"{self.folder}/", "")).classes("text-negative").props(
                    'role="alert"'
                )
                self._ask()
            return
        with ui.element("section").classes("card w-full"):
            ui.label(self.file).classes("h2").props('role="heading" aria-level="2"')
            signal = known.signal
            per = "Hz" if signal.domain == "time" else "per mm"
            ui.label(
                f"{signal.extent:.3g} {'s' if signal.domain == 'time' else 'mm'} at {signal.rate:g} {per}, "
                f"in {signal.unit}, axes {', '.join(signal.axes)}"
            )
            if known.timing is not None and not known.timing.even:
                ui.label("Its time stamps were brought to even spacing.").classes("small quiet")
            self._ask(closed=True)
        self.set = self.asked or self._fitting(signal)
        said_simulated = str(known.metadata.get("simulated", "")).lower() == "true"
        signal_card(signal, title=self.file, simulated=said_simulated)
        if not self.sets:
            ui.label("There is no data set to compare it with or to add it to: simulate or import one first.")
            ui.link("Simulate or import one", "/materials")
            return
        with ui.element("section").classes("card w-full"):
            ui.select(
                self.sets, label="Compared with, and added to", value=self.set, on_change=self._choose
            ).classes("w-full max-w-lg")
        stream = fitting_stream(self.desk.stores.get(self.set), signal)
        draw_near(self.desk, signal, set_name=self.set, stream=stream)
        self._form(said_simulated, stream)

    def _fitting(self, signal: Signal) -> str:
        """Return the first data set with a stream of the signal's unit and domain, else the first."""
        for name in self.sets:
            with suppress(TactogramError, OSError):
                if fitting_stream(self.desk.stores.get(name), signal):
                    return name
        return self.sets[0] if self.sets else ""

    def _read(self) -> SignalFile:
        return read_file(
            self.path,
            unit=self.unit or None,
            rate=float(self.rate) if self.rate else None,
            axes=tuple(name.strip() for name in self.axes.split(",") if name.strip()) or None,
        )

    def _ask(self, *, closed: bool = False) -> None:
        """Ask for what the file does not say."""
        asked = ui.expansion("What the file does not say", value=not closed).classes("w-full").props("dense")
        with asked, ui.row().classes("items-end gap-3"):
            unit = ui.select(
                {name: name or "as the file says" for name in UNITS},
                label="Unit",
                value=self.unit if self.unit in UNITS else "",
            ).classes("w-40")
            rate = NumberField("Rate, Hz", value=float(self.rate) if self.rate else None).classes("w-36")
            axes = ui.input("Axes", value=self.axes, placeholder="x,y,z").classes("w-36")
            ui.button(
                "Read it so",
                on_click=lambda: self.go(
                    unit=unit.value,
                    rate="" if rate.value is None else f"{rate.value:g}",
                    axes=axes.value or "",
                ),
            ).props("outline")
            ui.button("Remove it", on_click=report_errors(self._remove)).props("flat color=negative")

    def _remove(self) -> None:
        self.path.unlink(missing_ok=True)
        ui.navigate.to(address("drop", set=self.set))

    def _choose(self, event: Any) -> None:
        self.go(set=event.value)

    # -- adding --------------------------------------------------------------------------------------------

    def _form(self, said_simulated: bool, stream: str) -> None:
        store = self.desk.stores.get(self.set)
        values: dict[str, Any] = app.storage.user.setdefault("drop", {}).setdefault(self.file, {})
        values.setdefault("simulated", said_simulated)
        materials = sorted({info.material for info in store.index if info.material})
        with ui.element("section").classes("card w-full").props('aria-label="Add it"'):
            ui.label(f"Add it to {self.set}").classes("h2").props('role="heading" aria-level="2"')
            with ui.row().classes("items-end gap-3"):
                ui.input("Material", autocomplete=materials).bind_value(values, "material").classes("w-56")
                if len(store.streams) > 1:
                    if values.get("stream") not in store.streams:
                        values["stream"] = stream or next(iter(store.streams))
                    ui.select(list(store.streams), label="Stream").bind_value(values, "stream").classes(
                        "w-40"
                    )
                NumberField("Speed, mm/s").bind_value(values, "speed_mm_s").classes("w-32")
                NumberField("Force, N").bind_value(values, "force_n").classes("w-32")
                for name in ("contactor", "session", "subject"):
                    ui.input(name.capitalize()).bind_value(values, name).classes("w-32")
            ui.label("A subject is a code, never a name.").classes("small quiet")
            upload("A photograph of it, if there is one", on_upload=report_errors(self._photograph)).props(
                f'accept="{PICTURES}"'
            ).classes("w-full max-w-lg")
            self.pictured = ui.label(
                f"photograph: {values['photograph']}" if values.get("photograph") else ""
            ).classes("small")
            ui.checkbox("It is simulated, or a model made it").bind_value(values, "simulated").set_enabled(
                not said_simulated
            )
            self.mixing = ui.label().classes("small")
            self.agreed = ui.checkbox("Mix them all the same").bind_value(values, "agreed")
            self.refused = ui.label().classes("text-negative").props('role="alert"')
            button = ui.button("Add it")
            button.on_click(report_errors(lambda: self._add(button, values)))
            self.done = ui.column().classes("gap-1").props('role="status"')

        def look() -> None:
            text = mixing(
                store.simulated, all(info.simulated for info in store.index), bool(values["simulated"])
            )
            self.mixing.text = text
            self.agreed.visible = bool(text)

        look()
        ui.timer(0.5, look)

    async def _photograph(self, event: events.UploadEventArguments) -> None:
        data = await event.file.read()
        saved = await in_background(save_upload, self.folder, event.file.name, data, kind="image")
        app.storage.user["drop"][self.file]["photograph"] = saved.name
        self.pictured.text = f"photograph: {saved.name}"

    async def _add(self, button: ui.button, values: dict[str, Any]) -> None:
        self.refused.text = ""
        try:
            if not (values.get("material") or "").strip():
                raise ParameterError("Material: say what was touched")
            if self.agreed.visible and not values.get("agreed"):
                raise ParameterError(
                    "Measured and simulated recordings would be mixed: say that it is meant so"
                )
            with busy("adding it", button=button):
                report = await in_background(self._added, values)
        except (TactogramError, OSError) as error:
            self.refused.text = str(error).replace(f"{self.folder}/", "")
            return
        self.done.clear()
        with self.done:
            if not report["added"]:
                ui.label("The same samples are in this data set already; nothing was changed.")
            else:
                ui.label(f"Added: {self.set} now holds {report['recordings']:,} recordings.")
                ui.label(
                    f"Its sha256 changed from {report['sha256_before'][:12]}… to {report['sha256'][:12]}…: a new "
                    "training learns from it, too; runs that were trained before keep to the recordings they name."
                ).classes("small")
            ui.link(
                "Look at it",
                address("recording", set=self.set, id=report["id"], stream=values.get("stream", "")),
            )

    def _added(self, values: dict[str, Any]) -> dict[str, Any]:
        photograph = values.get("photograph")
        texts = {
            name: (values.get(name) or "").strip() or None for name in ("contactor", "session", "subject")
        }
        numbers = {name: values.get(name) for name in ("speed_mm_s", "force_n")}
        return add_signal(
            self.desk.studio.workspace.inside(self.set),
            self.path,
            material=values["material"].strip(),
            stream=values.get("stream") if len(self.desk.stores.get(self.set).streams) > 1 else None,
            unit=self.unit or None,
            rate=float(self.rate) if self.rate else None,
            axes=tuple(name.strip() for name in self.axes.split(",") if name.strip()) or None,
            photograph=None
            if not photograph
            else self.desk.studio.workspace.inside(self.folder / photograph),
            simulated=bool(values["simulated"]),
            **texts,
            **{name: None if value is None else float(value) for name, value in numbers.items()},
        )


def _number(text: str) -> str:
    """Return a number above 0 as it was written; empty for what is none: an address can be edited by hand."""
    with suppress(ValueError):
        return text if float(text) > 0 else ""
    return ""


def keep_signal(folder: Path, name: str, data: bytes) -> Path:
    """Keep an uploaded signal in a folder under a safe name that nothing there has; return its path.

    One that only lacks its rate is kept, too: the page asks for it.

    Raises
    ------
    TactogramError
        In one sentence, if it is no signal; nothing is written then.
    """
    try:
        return save_upload(folder, name, data, kind="signal")
    except TactogramError:
        safe = checked(name, data, kind="signal")
        if Path(safe).suffix in SOUND:
            raise
        read_uploaded_signal(safe, data, rate=1.0)  # raises where it is not the rate that lacks
    path = folder / free_name(folder, Path(safe).stem, Path(safe).suffix)
    with atomic_write(path) as part:
        part.write_bytes(data)
    return path


def fitting_stream(store: Store, signal: Signal) -> str:
    """Return the stream of a data set that a signal is one of by unit and domain, else nothing."""
    found = (
        name
        for name, facts in store.streams.items()
        if (facts.unit, facts.domain) == (signal.unit, signal.domain)
    )
    return next(found, "")


def mixing(any_simulated: bool, all_simulated: bool, adding_simulated: bool) -> str:
    """Return what is to be known before measured and simulated recordings stand beside each other; empty where not.

    Parameters
    ----------
    any_simulated, all_simulated : bool
        Of the data set.
    adding_simulated : bool
        Of the recording.
    """
    if adding_simulated and not any_simulated:
        return (
            "This data set holds measured recordings only. With this one in it, it counts as simulated for good: so "
            "does every run that is trained on it, and every figure of it."
        )
    if not adding_simulated and all_simulated:
        return (
            "This data set is simulated. A measured recording in it is marked as measured, but runs and figures of the "
            "set stay marked as simulated."
        )
    return ""
