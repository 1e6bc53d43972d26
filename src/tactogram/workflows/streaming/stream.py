"""Texture stream: motion in, blocks out, latency measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.model import limits_of
from tactogram.rendering.displays.catalogue import display_family, open_display
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.modulation import carrier_of
from tactogram.rendering.level import parse_level
from tactogram.rendering.streaming.backends import Clock, run_unpaced
from tactogram.rendering.streaming.contact import ContactSettings
from tactogram.rendering.streaming.engine import Engine
from tactogram.rendering.streaming.network import NetworkMotion
from tactogram.rendering.streaming.noise_texture import ModulatedNoiseTexture
from tactogram.rendering.streaming.output import DisplayOutput, Stream, check_streams
from tactogram.rendering.streaming.recorded_motion import SimulatedHand
from tactogram.rendering.streaming.textures import AutoregressiveTexture, StreamingTexture, SurfaceTexture
from tactogram.rendering.transducer.digilent import AnalogDiscovery
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram.signal.io.atomic import atomic_write, check_writable
from tactogram.signal.io.files import WRITABLE
from tactogram.signal.texture_map import NAMES
from tactogram.workflows.rendering.carrier_tracking import CarrierTracking
from tactogram.workflows.rendering.playback import full_scale_of
from tactogram.workflows.request import takes
from tactogram.workflows.streaming.requests import StreamRequest
from tactogram.workflows.streaming.session import Backend, motion_of, run, status_lines
from tactogram.workflows.streaming.textures import TextureSettings, textures_of

PLAIN_RATE = 8000.0
"""Rate of a stream without a display, Hz."""
REHEARSAL_S = 5.0
"""Time that the textures are tried under a simulated hand to find the level, s."""


@takes(StreamRequest)
def stream(request: StreamRequest) -> dict[str, Any]:
    """Stream runs and files, mixed, under a finger, and return the measurements.

    With ``mix_to`` the weights go there evenly over the whole time. Without a display the textures themselves are
    streamed, in their own unit.

    Returns
    -------
    dict
        `Stream.facts`, and ``backend``, ``seconds``, ``simulated`` (motion or textures), ``textures_simulated``,
        ``interrupted`` (from the keyboard), ``realtime_asked``, ``device``, ``network``, ``blocks``,
        ``file``, ``figure``; ``limited``, sentences on speeds and forces outside of what was recorded.

    Raises
    ------
    TactogramError
        If an option is wrong, or something failed on the way (after the display was brought to rest).
    """
    sources = [request.sources] if isinstance(request.sources, str | Path) else request.sources
    out = Path(request.out) if request.out is not None else None
    figure = Path(request.figure) if request.figure is not None else None
    _check_files(out, figure)
    display = None
    if request.display is not None:
        display = open_display(request.display, changes=request.changes)
    backend = _backend(request, display)
    rate = PLAIN_RATE if display is None else display.rate
    if display is not None:
        check_streams(display)
    most = max(1, int(request.block_ms / 1e3 * rate + 1e-9))
    axes = request.how or (display.axes if display is not None else "dft321")
    texture_settings = TextureSettings(
        rate, most, axes, request.speed_mm_s, request.along, None, request.seed
    )
    mix, mix_to = request.mix or {}, request.mix_to or {}
    names = list(dict.fromkeys([*mix, *mix_to]))
    textures, simulated = textures_of(sources, names, texture_settings, **request.reading)
    weights = dict.fromkeys(names, 0.0) | dict(mix) if names else None
    contact = ContactSettings(gain=request.tap_gain)
    output = None
    if display is not None and request.level is not None:
        rehearsed: Signal | SurfaceTexture
        if display_family(display.family).stream_surface is not None:
            rehearsed = _only_surface(textures, display.name)
        else:
            rehearsed = rehearsal(
                textures, rate=rate, most=most, seed=request.seed, weights=weights, contact=contact
            )
        output = DisplayOutput(display, rehearsed, level=parse_level(request.level))
        if request.tell is not None and (sentence := output.sentence()) is not None:
            request.tell(sentence)
    clock = Clock()
    motion = motion_of(request, clock)
    try:
        engine = Engine(textures, motion, rate=rate, most=most, weights=weights, contact=contact)
        on_block = _gliding(engine, weights or {}, mix_to, request.seconds) if mix_to else None
        keep = request.seconds if out is not None or figure is not None else 0.0
        running = Stream(engine, output, record_s=keep, on_block=on_block)
        running.warm_up()
        status = None if request.status is None else status_lines(running, request.status)
        device = run(running, backend, seconds=request.seconds, clock=clock, motion=motion, status=status)
        if isinstance(motion, NetworkMotion):
            device["network"] = motion.facts()
    finally:
        motion.close()
    if running.error is not None:
        raise running.error
    facts = running.facts() | {
        "backend": request.backend,
        "seconds": request.seconds,
        "simulated": simulated or motion.simulated,
        "textures_simulated": simulated,
        "interrupted": running.stopped,
        "realtime_asked": request.realtime,
        "limited": limited(running),
        **device,
    }
    return facts | write_sent(running, facts, out, figure)


def _check_files(out: Path | None, figure: Path | None) -> None:
    """Refuse paths that could not be written in the end: an hour of streaming would be lost."""
    if out is not None and out.suffix.lower() not in WRITABLE:
        raise ParameterError(f"{out}: suffix must be one of {', '.join(WRITABLE)}, got {out.suffix}")
    if figure is not None and figure.suffix.lower() != ".png":
        raise ParameterError(f"{figure}: a figure's suffix must be .png, got {figure.suffix}")
    for path in filter(None, (out, figure)):
        check_writable(path)


def _backend(request: StreamRequest, display: Display | None) -> Backend:
    full_scale = 1.0
    if request.backend == "audio" and display is not None:
        full_scale = full_scale_of(display, "audio", request.full_scale)
    tracking = None
    if request.track is not None and display is not None:
        tracking = CarrierTracking(
            carrier_of(display),
            request.track,
            serial=request.device or "",
            opened=request.opened or AnalogDiscovery,
        )
    return Backend(
        request.backend,
        device=request.device or "",
        to=request.to,
        full_scale=full_scale,
        realtime=request.realtime,
        opened=request.opened or AnalogDiscovery,
        tracking=tracking,
    )


def _only_surface(textures: Sequence[StreamingTexture], display: str) -> SurfaceTexture:
    if len(textures) != 1 or not isinstance(textures[0], SurfaceTexture):
        raise ParameterError(
            f"{display}: streams one surface at a time, a friction coefficient over displacement (or over time, with "
            f"`speed_mm_s`); got {', '.join(texture.name for texture in textures)}"
        )
    return textures[0]


def rehearsal(
    textures: Sequence[StreamingTexture],
    *,
    rate: float,
    most: int,
    seed: int,
    weights: Mapping[str, float] | None = None,
    contact: ContactSettings | None = None,
) -> Signal:
    """Return some seconds of the textures under a simulated hand, for the level."""
    hand = SimulatedHand(REHEARSAL_S + 1, seed=seed + 1)
    engine = Engine(textures, hand, rate=rate, most=most, weights=weights, contact=contact)
    tried = Stream(engine, record_s=REHEARSAL_S)
    run_unpaced(tried, seconds=REHEARSAL_S)
    if tried.error is not None:
        raise tried.error
    return Signal(tried.recorded, rate, engine.unit, engine.axes)


def _gliding(
    engine: Engine, begin: Mapping[str, float], end: Mapping[str, float], seconds: float
) -> Callable[[float], None]:
    """Return a function that sets the weights at a time between one mix and another."""
    goal = {name: end.get(name, 0.0) for name in engine.names}
    start = {name: begin.get(name, 0.0) for name in engine.names}

    def at(now_s: float) -> None:
        share = min(1.0, max(0.0, now_s / seconds))
        engine.set_weights({name: (1 - share) * start[name] + share * goal[name] for name in engine.names})

    return at


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
