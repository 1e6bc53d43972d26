"""Stream textures to where a finger feels them: motion in, blocks out, latency measured."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from tactogram.errors import ParameterError
from tactogram.jobs.streamed import TextureSettings, textures_of
from tactogram.rendering.catalogue import open_display
from tactogram.rendering.level import parse_level
from tactogram.rendering.streaming.backends import (
    Clock,
    run_audio,
    run_clocked,
    run_miniaudio,
    run_unpaced,
)
from tactogram.rendering.streaming.contact import ContactSettings
from tactogram.rendering.streaming.engine import LEAST_RATE, LONGEST_BLOCK_S, Engine
from tactogram.rendering.streaming.hand import SimulatedHand
from tactogram.rendering.streaming.motion import MotionSource
from tactogram.rendering.streaming.network import NetworkBlocks, NetworkMotion, parse_address
from tactogram.rendering.streaming.output import DisplayOutput
from tactogram.rendering.streaming.recorded_motion import MotionFile, MouseMotion
from tactogram.rendering.streaming.stream import Stream
from tactogram.rendering.streaming.surface import Along, SurfaceTexture
from tactogram.rendering.streaming.textures import StreamingTexture
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram.signal.io.files import WRITABLE, written_beside

Backend = Literal["null", "file", "clock", "audio", "osc", "udp"]
REHEARSAL_S = 5.0
"""How long the textures are tried under a simulated hand to find the level, s."""
NETWORK = ("osc", "udp")

Status = Callable[[str, float], None]


@dataclass(frozen=True)
class StreamSettings:
    """How a stream runs.

    Parameters
    ----------
    motion : str
        ``simulated``, ``osc`` or ``udp`` (one port hears both), ``mouse``, or a CSV.
    backend : {"null", "file", "clock", "audio", "osc", "udp"}
        See `tactogram.rendering.streaming.backends`; ``osc`` and ``udp`` send the blocks over the network.
    seconds : float
    block_ms : float
        At most 5.
    seed : int
        Of noise and simulated hand.
    listen, to : str
        HOST:PORT that motion is heard at, and that blocks go to (by default back to who sent the motion).
    device : str, optional
        A sound card by name or number.
    tap_gain : float
        Of a landing's transient; 0 is none.
    realtime : bool
        Ask the system for real-time priority.
    """

    motion: str = "simulated"
    backend: Backend = "null"
    seconds: float = 10.0
    block_ms: float = 5.0
    seed: int = 0
    listen: str = ""
    to: str = ""
    device: str | None = None
    tap_gain: float = 4.0
    realtime: bool = False


def stream(
    sources: Sequence[str | Path] | str | Path,
    settings: StreamSettings | None = None,
    *,
    mix: Mapping[str, float] | None = None,
    mix_to: Mapping[str, float] | None = None,
    display: str | None = None,
    level: str | None = None,
    how: str | None = None,
    along: Along = "path",
    speed_mm_s: float | None = None,
    out: Path | None = None,
    figure: Path | None = None,
    status: Status | None = None,
    **options: Any,
) -> dict[str, Any]:
    """Stream runs and files, mixed, under a finger, and return what was measured.

    Parameters
    ----------
    sources : path or sequence of path
        Runs of generators and signal files; ``options`` are passed to `read_signal`.
    settings : StreamSettings, optional
        By default ten seconds under a simulated hand, to a device that plays to nobody.
    mix, mix_to : mapping, optional
        Weights by material or file stem; with ``mix_to`` they go there evenly over the whole time.
    display, level : str, optional
        Name of a shipped display or a TOML file, and how strong (both or none); without, the textures themselves are
        streamed, in their own unit.
    how : str, optional
        How several axes become one: dft321 or the name of one; by default as the display says.
    along, speed_mm_s
        See `tactogram.jobs.streamed.TextureSettings`.
    out, figure : Path, optional
        What was sent, as a signal file, and its spectrogram under the finger's speed, as PNG.
    status : callable, optional
        Told a line on how it goes, and the time.

    Returns
    -------
    dict
        `Stream.facts`, and ``backend``, ``seconds``, ``simulated`` (motion or textures), ``textures_simulated``,
        ``interrupted`` (from the keyboard), ``realtime_asked``, ``device``, ``network``, ``blocks``,
        ``file``, ``figure``.

    Raises
    ------
    TactogramError
        If an option is wrong, or something failed on the way (after the display was brought to rest).
    """
    settings = settings or StreamSettings()
    sources = [sources] if isinstance(sources, str | Path) else sources
    _check(settings, display, level)
    _check_files(out, figure)
    opened = None if display is None else open_display(display)
    rate = LEAST_RATE if opened is None else opened.rate
    if rate < LEAST_RATE:
        raise ParameterError(
            f"{display}: streaming needs a drive of at least {LEAST_RATE:g} Hz, this display takes {rate:g}: "
            "render a file"
        )
    most = max(1, int(settings.block_ms / 1e3 * rate + 1e-9))
    axes = how or (opened.axes if opened is not None else "dft321")
    texture_settings = TextureSettings(rate, most, axes, speed_mm_s, along, None, settings.seed)
    names = list(dict.fromkeys([*(mix or {}), *(mix_to or {})]))
    textures, simulated = textures_of(sources, names, texture_settings, **options)
    weights = dict.fromkeys(names, 0.0) | dict(mix or {}) if mix or mix_to else None
    contact = ContactSettings(gain=settings.tap_gain)
    output = None
    if opened is not None and level is not None:
        rehearsed: Signal | SurfaceTexture
        if opened.family == "electrovibration":
            rehearsed = _only_surface(textures, opened.name)
        else:
            rehearsed = _rehearsal(textures, weights, contact, rate, most, settings.seed)
        output = DisplayOutput(opened, rehearsed, level=parse_level(level))
    clock = Clock()
    motion = _motion(settings, clock)
    try:
        engine = Engine(textures, motion, rate=rate, most=most, weights=weights, contact=contact)
        on_block = _gliding(engine, weights or {}, mix_to, settings.seconds) if mix_to else None
        keep = settings.seconds if out is not None or figure is not None else 0.0
        running = Stream(engine, output, record_s=keep, on_block=on_block)
        running.warm_up()
        device = _run(running, settings, clock, motion, status)
        if isinstance(motion, NetworkMotion):
            device["network"] = motion.facts()
    finally:
        motion.close()
    if running.error is not None:
        raise running.error
    facts = running.facts() | {
        "backend": settings.backend,
        "seconds": settings.seconds,
        "simulated": simulated or motion.simulated,
        "textures_simulated": simulated,
        "interrupted": running.ends_s < 0,
        "realtime_asked": settings.realtime,
        **device,
    }
    return facts | _written(running, facts, out, figure)


def latency_lines(facts: Mapping[str, Any]) -> list[str]:
    """Return what a stream measured as lines for people."""
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
    if "display" in facts and "equaliser_delay_ms" in facts["display"]:
        added += f", the equaliser {facts['display']['equaliser_delay_ms']:.1f} ms at 250 Hz"
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
    """Return what of the drive was cut off, if anything was."""
    display = facts.get("display", {})
    count = display.get("clipped_samples", 0) + display.get("over_modulated_samples", 0)
    return (
        [f"clipped: {count} samples beyond the limits of {display['display']}; lower --level"]
        if count
        else []
    )


def underrun_line(facts: Mapping[str, Any]) -> str:
    """Return how many blocks were not ready in time, why as far as it can be told, and what helps."""
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
            else f"{line}; real-time priority was asked for and not granted (docs/streaming.md)"
        )
    return f"{line}: end them, or try --realtime"


def _check(settings: StreamSettings, display: str | None, level: str | None) -> None:
    if settings.backend not in get_args(Backend):
        raise ParameterError(
            f"backend must be one of {', '.join(get_args(Backend))}, got {settings.backend!r}"
        )
    if not 0 < settings.seconds <= 24 * 3600:
        raise ParameterError(f"seconds must be > 0 and at most a day, got {settings.seconds:g}")
    if not 0 < settings.block_ms <= 1e3 * LONGEST_BLOCK_S:
        raise ParameterError(
            f"block must be > 0 and at most {1e3 * LONGEST_BLOCK_S:g} ms, got {settings.block_ms:g}"
        )
    if (display is None) != (level is None):
        raise ParameterError(
            "a display needs a level and a level a display: give --display and --level, or neither"
        )
    if settings.backend == "audio" and display is None:
        raise ParameterError(
            "the audio backend moves an actuator: say which --display it is, and the --level"
        )
    if settings.backend == "file" and settings.motion in (*NETWORK, "mouse"):
        raise ParameterError(
            f"backend file does not keep the time, so motion cannot come from {settings.motion}: use clock"
        )


def _check_files(out: Path | None, figure: Path | None) -> None:
    """Refuse what could not be written in the end: an hour of streaming would be lost."""
    if out is not None and out.suffix.lower() not in WRITABLE:
        raise ParameterError(f"{out}: suffix must be one of {', '.join(WRITABLE)}, got {out.suffix}")
    if figure is not None and figure.suffix.lower() != ".png":
        raise ParameterError(f"{figure}: a figure's suffix must be .png, got {figure.suffix}")
    for path in filter(None, (out, figure)):
        there = next(folder for folder in path.absolute().parents if folder.exists())
        if not there.is_dir() or not os.access(there, os.W_OK):
            raise ParameterError(f"{path}: {there} is no folder that may be written to")


def _motion(settings: StreamSettings, clock: Clock) -> MotionSource:
    match settings.motion:
        case "simulated":
            return SimulatedHand(settings.seconds + 1, seed=settings.seed)
        case "mouse":
            return MouseMotion()
        case "osc" | "udp":
            host, port = parse_address(settings.listen or "127.0.0.1")
            return NetworkMotion(host=host, port=port, clock=clock.now)
    return MotionFile(settings.motion)


def _only_surface(textures: Sequence[StreamingTexture], display: str) -> SurfaceTexture:
    if len(textures) != 1 or not isinstance(textures[0], SurfaceTexture):
        raise ParameterError(
            f"{display}: streams one surface at a time, a friction coefficient over displacement (or over time, with "
            f"--speed); got {', '.join(texture.name for texture in textures)}"
        )
    return textures[0]


def _rehearsal(
    textures: Sequence[StreamingTexture],
    weights: Mapping[str, float] | None,
    contact: ContactSettings,
    rate: float,
    most: int,
    seed: int,
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
    """Return what sets the weights on their way from one mix to another."""
    goal = {name: end.get(name, 0.0) for name in engine.names}
    start = {name: begin.get(name, 0.0) for name in engine.names}

    def at(now_s: float) -> None:
        share = min(1.0, max(0.0, now_s / seconds))
        engine.set_weights({name: (1 - share) * start[name] + share * goal[name] for name in engine.names})

    return at


def _run(
    running: Stream, settings: StreamSettings, clock: Clock, motion: MotionSource, status: Status | None
) -> dict[str, Any]:
    """Run the stream on its backend and return what is known of it."""
    told = None if status is None else _status(running, status)
    seconds, realtime, card = settings.seconds, settings.realtime, settings.device
    match settings.backend:
        case "file":
            run_unpaced(running, seconds=seconds, status=told)
            return {"device": {"library": "none", "paced": False}}
        case "null":
            return {
                "device": run_miniaudio(
                    running, seconds=seconds, clock=clock, null=True, status=told, realtime=realtime
                )
            }
        case "audio":
            return {
                "device": run_audio(
                    running,
                    seconds=seconds,
                    clock=clock,
                    device=int(card) if card is not None and card.isdigit() else card,
                    status=told,
                    realtime=realtime,
                )
            }
        case "osc" | "udp":
            to = parse_address(settings.to, default_port=9121) if settings.to else None
            heard = motion if isinstance(motion, NetworkMotion) else None
            sink = NetworkBlocks(settings.backend, rate=running.engine.rate, to=to, motion=heard)
            granted = run_clocked(
                running, seconds=seconds, clock=clock, sink=sink, status=told, realtime=realtime
            )
            sink.close()
            return {
                "device": {"library": settings.backend, "realtime_priority": granted},
                "blocks": {"sent": sink.sent, "unsent": sink.unsent},
            }
    granted = run_clocked(running, seconds=seconds, clock=clock, status=told, realtime=realtime)
    return {"device": {"library": "none", "paced": True, "realtime_priority": granted}}


def _status(running: Stream, status: Status) -> Callable[[float], None]:
    def tell(now_s: float) -> None:
        engine = running.engine
        motion, latency = engine.follower.block, engine.latency
        last = max(0, motion.count - 1)
        status(
            f"{now_s:7.1f} s  {engine.follower.state:5}  {motion.speed_mm_s[last]:4.0f} mm/s  "
            f"{motion.force_n[last]:4.2f} N  compute p50 {1e3 * latency.compute.quantile(0.5):.2f} "
            f"p99 {1e3 * latency.compute.quantile(0.99):.2f} of {1e3 * latency.block_s:g} ms  "
            f"underruns {latency.underruns}  dropped {engine.finger.counts.dropped}",
            now_s,
        )

    return tell


def _written(
    running: Stream, facts: Mapping[str, Any], out: Path | None, figure: Path | None
) -> dict[str, str]:
    """Write what was sent and its figure, and return where."""
    written: dict[str, str] = {}
    if out is None and figure is None:
        return written
    sent = Signal(running.recorded, running.engine.rate, running.unit, running.channels)
    if out is not None:
        said = {name: facts[name] for name in ("simulated", "textures", "weights", "backend")}
        write_signal(out, sent, metadata=said)
        written["file"] = str(out)
    if figure is not None:
        from tactogram.rendering.streaming.figures import stream_figure

        count = len(facts["textures"])
        what = facts["textures"][0] if count == 1 else f"{count} textures"
        of = " (simulated)" if facts["textures_simulated"] else ""
        of += (
            " under a simulated hand" if facts["motion"]["simulated"] else f" under {facts['motion']['from']}"
        )
        with written_beside(figure) as part:
            stream_figure(sent, running.track, title=f"{what}{of}").savefig(part, format="png", dpi=130)
        written["figure"] = str(figure)
    return written
