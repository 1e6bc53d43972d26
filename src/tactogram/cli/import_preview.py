"""Preview of an import as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tactogram.cli.printing import columns, shortened, text_of
from tactogram.signal.io.content import MATERIAL


def preview_text(facts: Mapping[str, Any], said: Sequence[str]) -> str:
    """Return the layouts, then a line for each kind of what is ``said`` of files, then what to know about the whole."""
    lines = [_layout(number, layout) for number, layout in enumerate(facts["layouts"], 1)]
    lines += said
    lines.append(
        f"files: {facts['files']}; photographs: {facts['photographs']}; duplicates: {facts['duplicates']}; "
        f"would be skipped: {facts['skipped_files']}"
    )
    lines += several_rates(facts["several_rates_hz"])
    if facts["proposed_path"] and not facts["question"]:
        lines.append(f"paths: they say more than the material: --set path={facts['proposed_path']}")
    lines += [f"mapping: no file has the columns {', '.join(names)}" for names in facts["unused_layouts"]]
    if facts["mapping"]:
        lines.append(f"mapping: {facts['mapping']}; edit it, and use it with --mapping {facts['mapping']}")
    elif any(layout["skipped"] for layout in facts["layouts"]):
        lines.append(
            "to read columns otherwise: --save-mapping FILE.toml writes these layouts as a file to edit"
        )
    return "\n".join(lines)


def several_rates(rates: Mapping[str, list[float]]) -> list[str]:
    """Return a line for each stream with several rates, with what to do."""
    return [
        f"{stream}: {_listed(each)} Hz; a training needs one rate: train … --set prepare.rate={each[0]:.7g}"
        for stream, each in rates.items()
    ]


def _listed(rates: Sequence[float]) -> str:
    return ", ".join(f"{rate:.7g}" for rate in rates)


def _layout(number: int, layout: Mapping[str, Any]) -> str:
    count = f"{layout['files']} file{'s' * (layout['files'] != 1)}"
    skipped = f", {layout['skipped']} skipped" if layout["skipped"] else ""
    mapped = ", by the mapping" if layout["mapped"] else ""
    lines = [f"layout {number}: {count}{skipped}, e.g. {layout['example']}{mapped}"]
    rows = [(f"  {use['heading']}", use["role"], use["unit"] or "") for use in layout["columns"]]
    lines += [columns(rows)] if rows else []
    for name, stream in layout["streams"].items():
        lines.append(f"  {name}: {', '.join(stream['axes'])} in {stream['unit']}")
    if layout["seconds"]:
        lines.append(f"  {_timing(layout)}")
        lines += [_labels(use["heading"], layout) for use in layout["columns"] if use["role"] == MATERIAL]
        lines.append(f"  materials: {text_of(shortened(layout['materials']))}")
    return "\n".join(lines)


def _labels(heading: str, layout: Mapping[str, Any]) -> str:
    materials, recordings = len(layout["materials"]), sum(layout["materials"].values())
    return (
        f"  column {heading!r}: labels, {materials} material{'s' * (materials != 1)} in {recordings} "
        f"recording{'s' * (recordings != 1)}"
    )


def _timing(layout: Mapping[str, Any]) -> str:
    low, high = layout["seconds"]
    text = f"{_listed(layout['rates_hz'])} Hz"
    if layout["estimated_rates_hz"]:
        least, most = (f"{rate:.7g}" for rate in layout["estimated_rates_hz"])
        text += f" (time stamps: {least if least == most else f'{least} to {most}'} Hz"
        text += f", jitter up to {1e6 * layout['jitter_s']:.3g} us)" if layout["jitter_s"] > 1e-7 else ")"
    text += f", {low:.4g} s" if low == high else f", {low:.4g} to {high:.4g} s"
    if layout["interpolated"]:
        text += f"; {layout['interpolated']} samples interpolated, longest gap {1e3 * layout['largest_gap_s']:.3g} ms"
    return text
