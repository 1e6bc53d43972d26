"""Texture stream: motion in, blocks out, latency measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.family import display_family
from tactogram.rendering.level import parse_level
from tactogram.rendering.streaming.backends import Clock, run_unpaced
from tactogram.rendering.streaming.contact import ContactSettings
from tactogram.rendering.streaming.engine import LEAST_RATE, Engine
from tactogram.rendering.streaming.network import NetworkMotion
from tactogram.rendering.streaming.output import DisplayOutput, equalised
from tactogram.rendering.streaming.simulated_hand import SimulatedHand
from tactogram.rendering.streaming.stream import Stream
from tactogram.rendering.streaming.surface import Along, SurfaceTexture
from tactogram.rendering.streaming.textures import StreamingTexture
from tactogram.signal import Signal
from tactogram.workflows.streaming.report import write_sent
from tactogram.workflows.streaming.session import StatusCallback, motion_of, run
from tactogram.workflows.streaming.settings import StreamSettings, check, check_files
from tactogram.workflows.streaming.textures import TextureSettings, textures_of

REHEARSAL_S = 5.0
"""How long the textures are tried under a simulated hand to find the level, s."""


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
    changes: Mapping[str, Any] | None = None,
    status: StatusCallback | None = None,
    tell: Callable[[str], None] | None = None,
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
        See `tactogram.workflows.streaming.textures.TextureSettings`.
    out, figure : Path, optional
        What was sent, as a signal file, and its spectrogram under the finger's speed, as PNG.
    changes : mapping, optional
        Values of the display to change, by dotted key.
    status : callable, optional
        Told a line on how it goes, and the time.
    tell : callable, optional
        Told, before anything plays, what the display's equaliser does and how late it is.

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
    check(settings, display, level)
    check_files(out, figure)
    opened = None if display is None else _display(display, changes or {}, settings)
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
        if display_family(opened.family).stream_surface is not None:
            rehearsed = _only_surface(textures, opened.name)
        else:
            rehearsed = _rehearsal(textures, weights, contact, rate, most, settings.seed)
        output = DisplayOutput(opened, rehearsed, level=parse_level(level))
        if tell is not None and (sentence := output.sentence()) is not None:
            tell(sentence)
    clock = Clock()
    motion = motion_of(settings, clock)
    try:
        engine = Engine(textures, motion, rate=rate, most=most, weights=weights, contact=contact)
        on_block = _gliding(engine, weights or {}, mix_to, settings.seconds) if mix_to else None
        keep = settings.seconds if out is not None or figure is not None else 0.0
        running = Stream(engine, output, record_s=keep, on_block=on_block)
        running.warm_up()
        device = run(running, settings, clock, motion, status)
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
    return facts | write_sent(running, facts, out, figure)


def _display(name: str, changes: Mapping[str, Any], settings: StreamSettings) -> Display:
    opened = open_display(name, changes=changes)
    return opened if settings.equalise is None else equalised(opened, on=settings.equalise)


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
