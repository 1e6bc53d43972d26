"""Tab for haptic files: request, downloads and losses."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from nicegui import ui

from tactogram.errors import ParameterError
from tactogram.rendering import (
    GRAVITY,
    envelope_of,
    haptic_format,
    haptic_formats,
    read_haptic,
    to_one_axis,
    without_constant,
)
from tactogram.signal import Signal, played
from tactogram_studio import kit
from tactogram_studio.pages.send.cards import RequestCards
from tactogram_studio.workspace.sent import FileRequest, SendResult

MOST_POINTS = 500
Curve = tuple[list[float], list[float]]
"""Times, s, and strengths in the signal's unit."""
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
COLOURS = ("#0b5d66", "#b3541e", "#5b3f8c", "#3d6b1f", "#8c2f52", "#44546a", "#8a6d00", "#1f4e9e", "#a1267f")


def losses_table(files: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return a row per format (and axis): ``format``, ``axis``, ``bytes`` and the fields of `Loss`, or ``refused``."""
    rows: list[dict[str, Any]] = []
    for name, facts in files.items():
        if "refused" in facts:
            rows.append({"format": name, "axis": "", "refused": facts["refused"]})
            continue
        written = facts["written"]
        loss = written["loss"]
        by_axis = loss if isinstance(next(iter(loss.values()), None), Mapping) else {"": loss}
        rows += [
            {"format": name, "axis": axis, "bytes": written["bytes"], **values}
            for axis, values in by_axis.items()
        ]
    return rows


def loss_text(row: Mapping[str, Any], key: str) -> str:
    """Return one loss for people; "none" where a file has no waveform to compare."""
    value = row[key]
    if key in ("waveform_correlation", "snr_db") and haptic_format(row["format"]).holds != "waveform":
        return "none"
    if value is None:
        return "none"
    return f"{value:.0f}" if key == "snr_db" else f"{value + 0.0:.3f}".replace("-0.000", "0.000")


def strength_curves(
    signal: Signal, folder: Path, files: Mapping[str, Any], *, axis: str, play_at: float | None
) -> dict[str, Curve]:
    """Return the strength over time of a signal and of each file, read back with its level, by name."""
    if signal.domain != "time":
        if play_at is None:
            raise ParameterError("the strength over time of a signal over displacement needs a speed")
        signal = played(signal, play_at, signal.rate * play_at)
    one, _ = to_one_axis(without_constant(signal, least=GRAVITY)[0], axis or None)
    curves = {"signal": _curve(one)}
    for name, facts in files.items():
        if "file" in facts:
            stored = read_haptic(folder / facts["file"], format=name).signal
            if stored.domain == "time":
                curves[haptic_format(name).title] = _curve(to_one_axis(stored, None)[0])
    return curves


def _curve(signal: Signal) -> Curve:
    envelope = envelope_of(signal)
    count = min(MOST_POINTS, len(envelope.times))
    places = np.unique(np.linspace(0, len(envelope.times) - 1, count).astype(int))
    strengths = [float(f"{value:.4g}") for value in envelope.amplitude[places]]
    return [round(float(t), 4) for t in envelope.times[places]], strengths


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
            titles = {name: f"{kind.title} ({kind.suffix})" for name, kind in haptic_formats().items()}
            titles = {"": "all formats that can store it"} | titles
            self.fields.choice("format", titles, "Format", "").on_value_change(self._describe_format)
            self._holds = kit.hint("")
            self.signal_fields()
            self._full_scale = ui.number("Full scale, in the signal's unit", min=0).classes("w-full")
            self._full_scale.props(
                'hint="signal value that becomes 1 in the file; empty: the signal\'s peak"'
            )
            self._button = ui.button("Write and check", icon="description", on_click=self._write)
        self._describe_format()

    def _describe_format(self) -> None:
        kind = haptic_formats().get(self.state["format"])
        self._holds.text = "" if kind is None else f"This format {HOLDS[kind.holds]}."

    async def _write(self) -> None:
        request = FileRequest(
            self.selected().id,
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
            with ui.row().classes("items-center gap-2"):
                kit.heading(f"{result.title} as a file")
                kit.mark_simulated(result.facts.get("simulated"), "simulated signal")
            _downloads(result, files)
            _loss_table(files)
            title = ui.label("Strength over time, in the signal's unit: the signal and each file")
            title.classes("font-bold mt-2")
            place = ui.column().classes("w-full")
            with place:
                ui.spinner()
            kit.command_lines(result.facts["commands"])

        async def draw_curves() -> None:
            curves = await kit.in_background(self._curves, result)
            place.clear()
            with place:
                _chart(curves)

        ui.timer(0.05, draw_curves, once=True)

    def _curves(self, result: SendResult) -> dict[str, Curve]:
        request = result.request
        if not isinstance(request, FileRequest):
            return {}
        signal = self.service.sources.select(request.of).signal()
        files = result.facts["files"]
        return strength_curves(signal, result.folder, files, axis=request.axis, play_at=request.play_at)


def _chart(curves: Mapping[str, Curve]) -> None:
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
    options = {
        "color": list(COLOURS),
        "animation": False,
        "grid": {"left": 56, "right": 16, "top": 56, "bottom": 40},
        "legend": {"top": 0},
        "tooltip": {"trigger": "axis"},
        "xAxis": {"type": "value", "name": "s", "min": "dataMin", "max": "dataMax"},
        "yAxis": {"type": "value"},
        "series": series,
    }
    ui.echart(options).classes("w-full h-80").props(
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
            kit.hint(f"{title}: {'; '.join(facts['problems']) or 'valid'}, {size_text}. Verdict: {verdict}.")
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
