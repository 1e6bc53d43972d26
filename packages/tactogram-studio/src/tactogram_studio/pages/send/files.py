"""Tab for haptic files: request, downloads and losses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nicegui import ui

from tactogram.rendering import (
    haptic_format,
    haptic_formats,
    haptic_labels,
)
from tactogram.signal import Signal
from tactogram_studio import kit
from tactogram_studio.pages.send.cards import RequestCards
from tactogram_studio.workspace.file_losses import Curve, loss_text, losses_table, strength_curves
from tactogram_studio.workspace.sent import FileRequest, SendResult
from tactogram_studio.workspace.shelf import SelectedSignal

LOSSES = {
    "envelope_correlation": ("Strength over time, r", "1 is perfect"),
    "envelope_error": ("Strength error", "relative to the signal's strength"),
    "level_db": ("Level, dB", "0 equals the signal"),
    "frequency_octaves": ("Frequency error, octaves", "0 equals the signal"),
    "waveform_correlation": ("Waveform, r", "none for an envelope"),
    "snr_db": ("Signal to error, dB", "none for an envelope"),
}
"""Heading and meaning of each loss."""
HOLDS = {
    "waveform": "stores the waveform of all axes",
    "envelope": "stores strength and, in some formats, frequency, but no waveform",
    "on and off": "stores when there is vibration, but not how strong it is",
}


class FileCards(RequestCards):
    """Cards of the tab."""

    key, kind = "files", FileRequest

    def axis_options(self, axes: tuple[str, ...]) -> dict[str, str]:
        """Return the ways to reduce several axes to the one of a file."""
        combined = {"": "three combined into one (DFT321), otherwise their mean"}
        return combined | {axis: f"axis {axis} only" for axis in axes}

    def draw_form(self) -> None:
        """Draw the form."""
        with kit.card("File format"):
            titles = {"": "all formats that can store it"} | haptic_labels()
            self.fields.choice("format", titles, "Format", "").on_value_change(self._describe_format)
            self._holds = kit.hint("")
            self.signal_fields()
            self._full_scale = ui.number("Full scale, in the signal's unit", min=0).classes("w-full")
            self._full_scale.props('hint="becomes 1 in the file; empty: the peak"')
            self._button = ui.button("Write and check", icon="description", on_click=self._write)
        self._describe_format()

    def set_signal(
        self, selected: SelectedSignal | None, signal: Signal | None, result: SendResult | None
    ) -> None:
        """Show the fields that another signal needs, and its newest result; a full scale is of one signal alone."""
        self._full_scale.value = None
        super().set_signal(selected, signal, result)

    def _describe_format(self) -> None:
        kind = haptic_formats().get(self.state["format"])
        self._holds.text = "" if kind is None else f"This format {HOLDS[kind.holds]}."

    async def _write(self) -> None:
        request = FileRequest(
            self.selected.id,
            self.state["format"],
            self.axis_option,
            self._full_scale.value or None,
            self.speed_mm_s,
        )
        with kit.busy("writing and reading back", button=self._button):
            self.show(await kit.in_background(self.service.file, request))

    def draw_cards(self) -> None:
        """Draw the files and their losses."""
        result = self.result
        with kit.card(label="Files"):
            if result is None:
                ui.label("The files and their losses will appear here.").classes("quiet")
                return
            files = result.facts["files"]
            kit.title_row(f"{result.title} as a file", result.facts.get("simulated"), "simulated signal")
            _downloads(result, files)
            _loss_table(files)
            title = ui.label("Strength over time, in the signal's unit: the signal and each file")
            title.classes("font-bold mt-2")
            container = ui.column().classes("w-full")
            with container:
                ui.spinner()
            kit.command_lines(result.facts["commands"])

        async def draw_curves() -> None:
            curves = await kit.in_background(self._curves, result)
            container.clear()
            with container:
                chart = ui.echart(kit.line_chart(curves, x="s", bold="signal")).classes("w-full h-80")
                chart.props(
                    'role="img" aria-label="Strength over time; the table holds the losses as numbers"'
                )

        ui.timer(0.05, draw_curves, once=True)

    def _curves(self, result: SendResult) -> dict[str, Curve]:
        request = result.request
        if not isinstance(request, FileRequest):
            return {}
        signal = self.service.sources.select(request.of).signal()
        files = result.facts["files"]
        return strength_curves(signal, result.folder, files, axis=request.axis, play_at=request.play_at)


def _downloads(result: SendResult, files: Mapping[str, Any]) -> None:
    for name, label in haptic_labels().items():
        if (facts := files.get(name)) is None:
            continue
        with ui.row().classes("items-baseline gap-x-2 gap-y-0 w-full"):
            ui.label(label).classes("small font-bold")
            if "refused" in facts:
                ui.label(facts["refused"]).classes("small text-negative")
                continue
            ui.link(facts["file"], f"/send/result/{result.id}/{facts['file']}").props("download")
            size = facts["written"]["bytes"]
            size_text = f"{size / 1000:.1f} kB" if size >= 1000 else f"{size} bytes"
            verdict = facts["written"]["verdict"]
            kit.hint(f"{'; '.join(facts['problems']) or 'valid'}, {size_text}. Verdict: {verdict}.")
    constants = [facts["written"].get("constant") for facts in files.values() if "written" in facts]
    for sentence in dict.fromkeys(filter(None, constants)):
        kit.hint(f"{sentence[0].upper()}{sentence[1:]}.")


def _loss_table(files: Mapping[str, Any]) -> None:
    rows = [row for row in losses_table(files) if "refused" not in row]
    if not rows:
        return
    several = any(row["axis"] for row in rows)
    kit.table(
        ["Format", *(["Axis"] if several else []), *(name for name, _ in LOSSES.values())],
        [
            [
                haptic_format(row["format"]).title,
                *([row["axis"]] if several else []),
                *(loss_text(row, key) for key in LOSSES),
            ]
            for row in rows
        ],
        caption="Losses of each file",
        hidden=True,
        classes="numbers",
    )
    kit.hint("; ".join(f"{name}: {meaning}" for name, meaning in LOSSES.values()))
