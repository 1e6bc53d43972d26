"""Report of a stream: lines for people, a file of the blocks sent, a figure."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactogram.model import limits_of
from tactogram.rendering.streaming.noise_texture import ModulatedNoiseTexture
from tactogram.rendering.streaming.output import Stream
from tactogram.rendering.streaming.textures import AutoregressiveTexture
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.texture_map import NAMES


def limited(running: Stream) -> list[str]:
    """Return a sentence for each texture whose recorded speeds or forces a sliding finger left."""
    engine = running.engine
    track = running.track[running.track[:, 1] > engine.finger.settings.moving_mm_s]
    return [
        str(limit)
        for texture in engine.textures
        if isinstance(texture, AutoregressiveTexture | ModulatedNoiseTexture)
        for name, nodes, seen in zip(
            NAMES, (texture.table.grid.speeds, texture.table.grid.forces), track[:, 1:].T, strict=True
        )
        if nodes[-1] > 0 and seen.any()  # zeros are unknown
        for limit in limits_of(name, seen, (nodes[0], nodes[-1]), f"of {texture.name}")
    ]


def latency_lines(facts: Mapping[str, Any]) -> list[str]:
    """Return the measurements of a stream as lines for people."""
    latency, motion = facts["latency"], facts["motion"]
    words = {
        "compute": "time to compute a block",
        "processor": "of that by the processor",
        "age": "age of the motion it used",
        "total": "motion to the end of the block",
        "tap": "landing or tap to the block's end",
    }
    rows = [f"{'ms':34}{'p50':>8}{'p99':>8}{'max':>8}"]
    for name, text in words.items():
        values = latency[name]
        if values["count"]:
            cells = "".join(f"{values[key]:8.2f}" for key in ("p50_ms", "p99_ms", "max_ms"))
            rows.append(f"{text:34}{cells}")
    of = "simulated " if motion["simulated"] else ""
    dropped = motion["late"] + motion["out_of_order"] + motion["invalid"]
    added = f"textures answer {facts['texture_delay_ms']:.1f} ms later"
    if "equaliser" in (found := facts.get("display", {})):
        filtered = found["equaliser"]
        what = "the equaliser" if filtered["on"] else "the edges of the display's band"
        added += f", {what} {filtered['delay_ms']:.1f} ms at {filtered['reference_hz']:g} Hz"
    return [
        *rows,
        f"blocks of {latency['block_ms']:g} ms; {added}; not in the table",
        underrun_line(facts),
        f"{of}motion: {motion['used']} samples used, {dropped} dropped ({motion['late']} late, "
        f"{motion['out_of_order']} out of order, {motion['invalid']} invalid), "
        f"connection lost {motion['lost_connections']} times",
        "states: " + ", ".join(f"{name} {100 * share:.0f} %" for name, share in facts["states"].items()),
        f"landings: {facts['landings']}",
        *_clipped_lines(facts),
    ]


def _clipped_lines(facts: Mapping[str, Any]) -> list[str]:
    display = facts.get("display", {})
    count = display.get("clipped_samples", 0) + display.get("over_modulated_samples", 0)
    return (
        [f"clipped: {count} samples beyond the limits of {display['display']}; lower the level"]
        if count
        else []
    )


def underrun_line(facts: Mapping[str, Any]) -> str:
    """Return how many blocks were late, the likely reason, and a remedy."""
    latency = facts["latency"]
    count, of = latency["underruns"], latency["compute"]["count"]
    if not count:
        return "underruns: 0"
    line = f"underruns: {count} of {of} blocks"
    worked = latency["processor"]["p99_ms"]
    if worked is not None and worked > latency["block_ms"]:
        return f"{line}; the blocks themselves take too long: stream fewer textures at a time"
    line += "; the blocks were quick enough, other programs had the processor"
    granted = facts.get("device", {}).get("realtime_priority")
    if facts.get("realtime_asked"):
        return (
            line
            if granted
            else f"{line}; real-time priority was requested and not granted (docs/streaming.md)"
        )
    return f"{line}: end them, or try real-time priority"


def write_sent(
    running: Stream, facts: Mapping[str, Any], out: Path | None, figure: Path | None
) -> dict[str, str]:
    """Write the blocks sent and their figure, each where it has a path, and return the paths: ``file``, ``figure``."""
    written: dict[str, str] = {}
    if out is None and figure is None:
        return written
    sent = Signal(running.recorded, running.engine.rate, running.unit, running.channels)
    if out is not None:
        metadata = {name: facts[name] for name in ("simulated", "textures", "weights", "backend", "limited")}
        write_signal(out, sent, metadata=metadata)
        written["file"] = str(out)
    if figure is not None:
        from tactogram.rendering.figures import stream_figure

        count = len(facts["textures"])
        what = facts["textures"][0] if count == 1 else f"{count} textures"
        of = " (simulated)" if facts["textures_simulated"] else ""
        of += (
            " under a simulated hand" if facts["motion"]["simulated"] else f" under {facts['motion']['from']}"
        )
        with atomic_write(figure) as part:
            stream_figure(sent, running.track, title=f"{what}{of}").savefig(part, format="png", dpi=130)
        written["figure"] = str(figure)
    return written
