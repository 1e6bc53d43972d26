"""A signal to haptic files: what each holds and loses, checked, to be downloaded one by one or all at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from nicegui import ui

from tactogram.errors import ParameterError
from tactogram.rendering.drive.mean_removal import without_constant
from tactogram.rendering.files.catalogue import haptic_format, haptic_formats
from tactogram.rendering.files.conversion import GRAVITY, read_haptic
from tactogram.rendering.files.envelope import envelope_of
from tactogram.rendering.files.reduction import to_one_axis
from tactogram.signal import Signal
from tactogram.signal.displacement import played
from tactogram.studio.layout import busy, in_background, report_errors
from tactogram.studio.pages.send.cards import SignalFields, command_line, form_beside_result, last_sent, there
from tactogram.studio.pages.send.losses import losses_table
from tactogram.studio.pages.send.sending import FileRequest, SelectedSignal, SendResult, SendService
from tactogram.studio.pages.send.wording import HOLDS, LOSSES

POINTS = 500
"""Of an envelope's picture."""
COLOURS = ("#0b5d66", "#b3541e", "#5b3f8c", "#3d6b1f", "#8c2f52", "#44546a", "#8a6d00")


def _ways(axes: tuple[str, ...]) -> dict[str, str]:
    """Return how several axes become the one of a file."""
    return {"": "three as one (DFT321), others their mean", **{a: f"axis {a} alone" for a in axes}}


class FileCards:
    """The cards of the tab; parameters as of `DisplayCards`."""

    def __init__(
        self, sending: SendService, kept: dict[str, Any], chosen: Callable[[], SelectedSignal | None]
    ) -> None:
        self.sending, self.kept, self.chosen = sending, kept, chosen
        self.sent = last_sent(sending, kept, "files", FileRequest)
        self._curves: dict[str, tuple[list[float], list[float]]] = {}
        form_beside_result(self._form, self._result)

    def signal_chosen(self, signal: Signal) -> None:
        """Ask for what this signal needs."""
        self._signal.signal_chosen(signal)

    def _form(self) -> None:
        with ui.element("section").classes("card w-full").props('aria-label="File format"'):
            ui.label("File format").classes("h2")
            names = {"": "all that can hold it", **self.sending.formats()}
            self._format = ui.select(
                names, label="Format", value=self.kept.get("format", ""), on_change=self._told_format
            ).classes("w-full")
            self._holds = ui.label().classes("small quiet")
            self._signal = SignalFields(_ways)
            self._full_scale = (
                ui.number("Full scale, in the signal's unit", min=0)
                .props('hint="what 1 in the file stands for; empty: the signal\'s peak"')
                .classes("w-full")
            )
            self._button = ui.button("Write and check", icon="description", on_click=self._write)
        self._told_format()

    def _told_format(self) -> None:
        kind = haptic_formats().get(str(self._format.value))
        self._holds.text = "" if kind is None else f"It {HOLDS[kind.holds]}."

    @report_errors
    async def _write(self) -> None:
        order = FileRequest(
            there(self.chosen()).of,
            str(self._format.value or ""),
            self._signal.how,
            self._full_scale.value or None,
            self._signal.speed_mm_s,
        )
        with busy("writing and reading back", button=self._button):
            self.sent = await in_background(self.sending.file, order)
        self.kept.update(files=self.sent.id, format=order.format)
        self._curves = {}
        self._result.refresh()

    @ui.refreshable_method
    def _result(self) -> None:
        sent = self.sent
        with ui.element("section").classes("card w-full").props('aria-label="Files"'):
            if sent is None or not isinstance(sent.order, FileRequest):
                ui.label("The files, and what each of them loses, come here.").classes("quiet")
                return
            files = sent.found["files"]
            with ui.row().classes("items-center gap-2"):
                ui.label(f"{sent.title} as a file").classes("h2")
                if sent.found.get("simulated"):
                    ui.label("simulated signal").classes("simulated")
            self._downloads(sent, files)
            _loss_table(files)
            ui.label(
                "Course of the strength, in the signal's unit: the signal, and what each file gives"
            ).classes("font-bold mt-2")
            self._chart()
            command_line(sent.found["commands"])
            ui.timer(0.05, self._draw, once=True)

    @report_errors
    async def _draw(self) -> None:
        if self.sent is not None:
            self._curves = await in_background(envelopes, self.sending, self.sent)
            self._chart.refresh()

    @ui.refreshable_method
    def _chart(self) -> None:
        if self._curves:
            _envelope_chart(self._curves)
        else:
            ui.spinner()

    def _downloads(self, sent: SendResult, files: Mapping[str, Any]) -> None:
        for name, facts in files.items():
            kind = haptic_format(name)
            with ui.row().classes("items-center gap-2 w-full"):
                if "refused" in facts:
                    ui.label(f"{kind.title}: {facts['refused']}").classes("text-negative")
                    continue
                ui.link(facts["file"], f"/send/result/{sent.id}/{facts['file']}").props("download")
                valid = (
                    "keeps every rule of the format"
                    if not facts["problems"]
                    else "; ".join(facts["problems"])
                )
                size = facts["written"]["bytes"]
                told = f"{size / 1000:.1f} kB" if size >= 1000 else f"{size} bytes"
                ui.label(f"{kind.title}: {valid}, {told}").classes("small quiet")
        for sentence in dict.fromkeys(
            facts["written"]["constant"]
            for facts in files.values()
            if "written" in facts and facts["written"].get("constant")
        ):
            ui.label(f"{sentence[0].upper()}{sentence[1:]}.").classes("small quiet")
        if sent.found.get("zip"):
            ui.link(
                "All of them and the table as a zip", f"/send/result/{sent.id}/{sent.found['zip']}"
            ).props("download")


def envelopes(sending: SendService, sent: SendResult) -> dict[str, tuple[list[float], list[float]]]:
    """Return times in s and strength of the signal and of what each file gives back, by name, for a picture.

    The strength is the signal's own, in its unit: the file's level is read back with it.
    """
    order = sent.order
    if not isinstance(order, FileRequest):
        raise ParameterError("this result is a drive, not a file")
    signal = sending.chosen(order.of).signal()
    if signal.domain != "time":
        if order.play_at is None:
            raise ParameterError("a signal over displacement has a course of strength at a speed only")
        signal = played(signal, order.play_at, signal.rate * order.play_at)
    one, _ = to_one_axis(without_constant(signal, least=GRAVITY)[0], order.axis or None)
    curves = {"signal": _curve(one)}
    for name, facts in sent.found["files"].items():
        if "file" in facts:
            back = read_haptic(sent.folder / facts["file"], format=name).signal
            if back.domain == "time":
                curves[haptic_format(name).title] = _curve(to_one_axis(back, None)[0])
    return curves


def _curve(signal: Signal) -> tuple[list[float], list[float]]:
    envelope = envelope_of(signal, pulses=False)
    count = min(POINTS, len(envelope.times))
    places = np.unique(np.linspace(0, len(envelope.times) - 1, count).astype(int))
    strengths = [float(f"{value:.4g}") for value in envelope.amplitude[places]]
    return [round(float(t), 4) for t in envelope.times[places]], strengths


def _envelope_chart(curves: Mapping[str, tuple[list[float], list[float]]]) -> None:
    series = [
        {
            "name": name,
            "type": "line",
            "showSymbol": False,
            "lineStyle": {"width": 3 if name == "signal" else 1.5},
            "data": [list(pair) for pair in zip(times, values, strict=True)],
        }
        for name, (times, values) in curves.items()
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
        'role="img" aria-label="Course of the strength over time; its loss is in the table"'
    )


def _loss_table(files: Mapping[str, Any]) -> None:
    rows = [row for row in losses_table(files) if "refused" not in row]
    if not rows:
        return
    axes = any(row["axis"] for row in rows)
    with ui.element("div").classes("scrolled"), ui.element("table").classes("numbers"):
        with ui.element("caption").classes("sr-only"):
            ui.label("What each file loses")
        with ui.element("thead"), ui.element("tr"):
            for heading, _ in [("Format", ""), *((("Axis", ""),) if axes else ()), *LOSSES.values()]:
                column = ui.element("th").props('scope="col"')
                column._text = heading
                if heading in ("Format", "Axis"):
                    column.classes("text")
        with ui.element("tbody"):
            for row in rows:
                with ui.element("tr"):
                    ui.element("th").props('scope="row"')._text = haptic_format(row["format"]).title
                    if axes:
                        ui.element("td")._text = row["axis"]
                    for key in LOSSES:
                        ui.element("td")._text = loss_text(row, key)
    ui.label("; ".join(f"{name}: {meaning}" for name, meaning in LOSSES.values())).classes("small quiet")


def loss_text(row: Mapping[str, Any], key: str) -> str:
    """Return one loss as people read it; of a file without a waveform there is none to compare."""
    value = row[key]
    if key in ("waveform_correlation", "snr_db") and haptic_format(row["format"]).holds != "waveform":
        return "none"
    if value is None:
        return "none"
    return f"{value:.0f}" if key == "snr_db" else f"{value + 0.0:.3f}".replace("-0.000", "0.000")
