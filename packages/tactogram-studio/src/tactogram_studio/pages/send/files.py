"""Tab for haptic files: request, downloads and losses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from tactogram.rendering import haptic_format, haptic_formats
from tactogram.signal import Signal
from tactogram_studio.layout import busy, heading, hint, in_background, report_errors
from tactogram_studio.pages.send.cards import SignalFields, command_line, form_and_result, last_result
from tactogram_studio.pages.send.losses import Curve, loss_text, losses_table, strength_curves
from tactogram_studio.pages.send.sending import FileRequest, SendResult, SendService
from tactogram_studio.pages.send.sources import SelectedSignal
from tactogram_studio.pages.send.wording import HOLDS, LOSSES

COLOURS = ("#0b5d66", "#b3541e", "#5b3f8c", "#3d6b1f", "#8c2f52", "#44546a", "#8a6d00", "#1f4e9e", "#a1267f")


def _axis_options(axes: tuple[str, ...]) -> dict[str, str]:
    """Return the ways to reduce several axes to the one of a file."""
    return {
        "": "three combined into one (DFT321), otherwise their mean",
        **{a: f"axis {a} only" for a in axes},
    }


class FileCards:
    """Cards of the tab; parameters as of `DisplayCards`."""

    def __init__(
        self, service: SendService, state: dict[str, Any], selected: Callable[[], SelectedSignal]
    ) -> None:
        self.service, self.state, self.selected = service, state, selected
        self.result = last_result(service, state, "files", FileRequest)
        self._curves: dict[str, Curve] = {}
        form_and_result(self._form, self._result)

    def set_signal(self, signal: Signal) -> None:
        """Show the fields that this signal needs."""
        self._fields.set_signal(signal)

    def _form(self) -> None:
        with ui.element("section").classes("card w-full").props('aria-label="File format"'):
            heading("File format")
            titles = {name: f"{kind.title} ({kind.suffix})" for name, kind in haptic_formats().items()}
            self._format = ui.select(
                {"": "all formats that can store it", **titles},
                label="Format",
                value=self.state.get("format", ""),
                on_change=self._describe_format,
            ).classes("w-full")
            self._holds = hint("")
            self._fields = SignalFields(_axis_options)
            self._full_scale = (
                ui.number("Full scale, in the signal's unit", min=0)
                .props('hint="signal value that becomes 1 in the file; empty: the signal\'s peak"')
                .classes("w-full")
            )
            self._button = ui.button("Write and check", icon="description", on_click=self._write)
        self._describe_format()

    def _describe_format(self) -> None:
        kind = haptic_formats().get(str(self._format.value))
        self._holds.text = "" if kind is None else f"This format {HOLDS[kind.holds]}."

    @report_errors
    async def _write(self) -> None:
        request = FileRequest(
            self.selected().id,
            str(self._format.value or ""),
            self._fields.axis_option,
            self._full_scale.value or None,
            self._fields.speed_mm_s,
        )
        with busy("writing and reading back", button=self._button):
            self.result = await in_background(self.service.file, request)
        self.state.update(files=self.result.id, format=request.format)
        self._curves = {}
        self._result.refresh()

    @ui.refreshable_method
    def _result(self) -> None:
        result = self.result
        with ui.element("section").classes("card w-full").props('aria-label="Files"'):
            if result is None:
                ui.label("The files and their losses will appear here.").classes("quiet")
                return
            files = result.facts["files"]
            with ui.row().classes("items-center gap-2"):
                heading(f"{result.title} as a file")
                if result.facts.get("simulated"):
                    ui.label("simulated signal").classes("simulated")
            _downloads(result, files)
            _loss_table(files)
            ui.label("Strength over time, in the signal's unit: the signal and each file").classes(
                "font-bold mt-2"
            )
            self._chart()
            command_line(result.facts["commands"])
            ui.timer(0.05, self._draw_curves, once=True)

    @report_errors
    async def _draw_curves(self) -> None:
        if self.result is not None:
            self._curves = await in_background(self._compute_curves, self.result)
            self._chart.refresh()

    def _compute_curves(self, result: SendResult) -> dict[str, Curve]:
        request = result.request
        if not isinstance(request, FileRequest):
            return {}
        signal = self.service.sources.select(request.of).signal()
        files = result.facts["files"]
        return strength_curves(signal, result.folder, files, axis=request.axis, play_at=request.play_at)

    @ui.refreshable_method
    def _chart(self) -> None:
        if not self._curves:
            ui.spinner()
            return
        series = [
            {
                "name": name,
                "type": "line",
                "showSymbol": False,
                "lineStyle": {"width": 3 if name == "signal" else 1.5},
                "data": [list(pair) for pair in zip(times, values, strict=True)],
            }
            for name, (times, values) in self._curves.items()
        ]
        ui.echart(
            {
                "color": list(COLOURS),
                "animation": False,
                "grid": {"left": 56, "right": 16, "top": 56, "bottom": 40},
                "legend": {"top": 0},
                "tooltip": {"trigger": "axis"},
                "xAxis": {"type": "value", "name": "s", "min": "dataMin", "max": "dataMax"},
                "yAxis": {"type": "value"},
                "series": series,
            }
        ).classes("w-full h-80").props(
            'role="img" aria-label="Strength over time; the table holds the losses as numbers"'
        )


def _downloads(result: SendResult, files: Mapping[str, Any]) -> None:
    for name, facts in files.items():
        title = haptic_format(name).title
        with ui.row().classes("items-center gap-2 w-full"):
            if "refused" in facts:
                ui.label(f"{title}: {facts['refused']}").classes("text-negative")
                continue
            ui.link(facts["file"], f"/send/result/{result.id}/{facts['file']}").props("download")
            size = facts["written"]["bytes"]
            size_text = f"{size / 1000:.1f} kB" if size >= 1000 else f"{size} bytes"
            verdict = facts["written"].get("verdict", "no verdict in a result of an earlier version")
            hint(f"{title}: {'; '.join(facts['problems']) or 'valid'}, {size_text}. Verdict: {verdict}.")
    constants = [facts["written"].get("constant") for facts in files.values() if "written" in facts]
    for sentence in dict.fromkeys(filter(None, constants)):
        hint(f"{sentence[0].upper()}{sentence[1:]}.")
    if result.facts.get("zip"):
        ui.link("All files and the table (ZIP)", f"/send/result/{result.id}/{result.facts['zip']}").props(
            "download"
        )


def _loss_table(files: Mapping[str, Any]) -> None:
    rows = [row for row in losses_table(files) if "refused" not in row]
    if not rows:
        return
    text_columns = ["Format", *(["Axis"] if any(row["axis"] for row in rows) else [])]
    with ui.element("div").classes("scrolled"), ui.element("table").classes("numbers"):
        with ui.element("caption").classes("sr-only"):
            ui.label("Losses of each file")
        with ui.element("thead"), ui.element("tr"):
            for name in text_columns:
                ui.element("th").props('scope="col"').classes("text")._text = name
            for name, _ in LOSSES.values():
                ui.element("th").props('scope="col"')._text = name
        with ui.element("tbody"):
            for row in rows:
                with ui.element("tr"):
                    ui.element("th").props('scope="row"')._text = haptic_format(row["format"]).title
                    if "Axis" in text_columns:
                        ui.element("td")._text = row["axis"]
                    for key in LOSSES:
                        ui.element("td")._text = loss_text(row, key)
    hint("; ".join(f"{name}: {meaning}" for name, meaning in LOSSES.values()))
