"""Texture stream: motion in, blocks out, latency measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.family import display_family
from tactogram.rendering.drive.modulation import carrier_of
from tactogram.rendering.level import parse_level
from tactogram.rendering.streaming.backends import Clock, run_unpaced
from tactogram.rendering.streaming.contact import ContactSettings
from tactogram.rendering.streaming.engine import Engine
from tactogram.rendering.streaming.network import NetworkMotion
from tactogram.rendering.streaming.output import DisplayOutput, Stream, check_streams
from tactogram.rendering.streaming.simulated_hand import SimulatedHand
from tactogram.rendering.streaming.surface import SurfaceTexture
from tactogram.rendering.streaming.textures import StreamingTexture
from tactogram.rendering.transducer.digilent import AnalogDiscovery
from tactogram.signal import Signal
from tactogram.signal.io.files import WRITABLE
from tactogram.signal.io.writable import check_writable
from tactogram.workflows.rendering.carrier_tracking import CarrierTracking
from tactogram.workflows.rendering.playback import full_scale_of
from tactogram.workflows.request import takes
from tactogram.workflows.streaming.report import limited, write_sent
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
