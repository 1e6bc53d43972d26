"""Texture stream: motion in, blocks out, latency measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from annotated_types import Ge, Gt, Le

from tactogram.errors import ParameterError, Remedy
from tactogram.parameters import Count, Positive, Settings, checked

if TYPE_CHECKING:
    from tactogram.rendering import Display
    from tactogram_playback.transducer.digilent import AnalogDiscovery
    from tactogram_playback.workflows.session import Backend, BackendKind

PLAIN_RATE = 8000.0
"""Rate of a stream without a display, Hz."""
Duration = Annotated[float, Gt(0), Le(24 * 3600)]
BlockTime = Annotated[float, Gt(0), Le(5)]
Gain = Annotated[float, Ge(0)]
Seed = Annotated[int, Ge(0)]


@checked
def stream(
    sources: Path | str | Sequence[Path | str],
    *,
    motion: str = "simulated",
    backend: Literal["null", "file", "clock", "audio", "osc", "digilent"] = "null",
    display: str | None = None,
    level: str | None = None,
    changes: Settings | None = None,
    seconds: Duration = 10.0,
    mix: Mapping[str, float] | None = None,
    mix_to: Mapping[str, float] | None = None,
    speed_mm_s: float | None = None,
    along: Literal["path", "x", "y"] = "path",
    how: str | None = None,
    block_ms: BlockTime = 5.0,
    listen: str = "",
    to: str = "",
    device: str | None = None,
    full_scale: float | None = None,
    tap_gain: Gain = 4.0,
    realtime: bool = False,
    track: Settings | None = None,
    seed: Seed = 0,
    out: Path | str | None = None,
    figure: Path | str | None = None,
    unit: str | None = None,
    rate: Positive | None = None,
    axes: tuple[str, ...] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    part: Count | None = None,
    status: Callable[[str, float], None] | None = None,
    tell: Callable[[str], None] | None = None,
    opened: Callable[..., AnalogDiscovery] | None = None,
) -> dict[str, Any]:
    """Play textures that follow a finger, and measure how late they are.

    By default ten seconds under a simulated hand, to no actuator. With ``mix_to`` the weights go there evenly over the
    whole time. Without a display the textures themselves are streamed, in their own unit.

    ``status`` receives a line now and then, and the time in s; ``tell`` a line about the display's equaliser before
    anything plays; ``opened`` opens the generator, in tests.

    Parameters
    ----------
    sources : Path, str or sequence of them
        Generators (runs) and signals, streamed at the same time.
    motion : str
        Where the finger's motion comes from: simulated, osc, mouse or a file.
    backend : {"null", "file", "clock", "audio", "osc", "digilent"}
        Where the blocks go.
    display : str, optional
        One of `displays`, or a TOML file.
    level : str, optional
        Level, as for `render`; found under a simulated hand before the stream begins.
    changes : dict, optional
        Change a value of the display, e.g. linear.cap_db=10.
    seconds : float
        Length of the stream, s.
    mix : mapping, optional
        Weights by material or file stem, e.g. A=0.6,B=0.4 (default: all the same).
    mix_to : mapping, optional
        Weights at the end, reached while it plays, e.g. A=0,B=1.
    speed_mm_s : float, optional
        Speed at which signals over time were recorded or are generated, mm/s.
    along : {"path", "x", "y"}
        Path or axis over which a surface is laid out.
    how : str, optional
        How axes become one: dft321 or an axis's name.
    block_ms : float
        Length of a block, ms.
    listen : str
        Address that receives motion, HOST:PORT (default 127.0.0.1:9120).
    to : str
        Address that receives blocks, HOST:PORT (default: the sender of the motion).
    device : str, optional
        A sound card, by name or number; the serial number of a Digilent.
    full_scale : float, optional
        Voltage of the amplifier at the sound card's full scale, for a display driven in V.
    tap_gain : float
        Gain of a landing's transient, 0 for none.
    realtime : bool
        Ask the system for real-time priority.
    track : dict, optional
        Keep a Digilent's carrier at the transducer's resonance, e.g. amps_per_volt=0.1; further keys as of `track`.
    seed : int
        Seed of noise and simulated hand.
    out : Path or str, optional
        File of the blocks sent: .wav, .csv, .npz …
    figure : Path or str, optional
        Its spectrogram under the finger's speed, as .png.
    unit, rate, axes, time, sheet, part
        As of `tactogram.convert`.

    Returns
    -------
    dict
        `Stream.facts`, and ``backend``, ``seconds``, ``simulated`` (motion or textures), ``textures_simulated``,
        ``interrupted`` (from the keyboard), ``realtime_asked``, ``device``, ``network``, ``blocks``,
        ``file``, ``figure``; ``limited``, sentences on speeds and forces outside of what was recorded.

    Raises
    ------
    ParameterError, TactogramError
        If an option is wrong, or something failed on the way (after the display was brought to rest).

    Examples
    --------
    >>> ridges = tactogram.Signal([0, 1, 0, -1] * 500, 20, "1", domain="displacement")
    >>> tactogram.write_signal("ridges.npz", ridges)
    >>> tactogram_playback.stream("ridges.npz", backend="file", seconds=1)["simulated"]
    True
    """
    from tactogram.rendering import display_family, open_display, parse_level
    from tactogram_playback.streaming.backends import Clock
    from tactogram_playback.streaming.contact import ContactSettings
    from tactogram_playback.streaming.engine import Engine
    from tactogram_playback.streaming.network import NetworkMotion
    from tactogram_playback.streaming.output import DisplayOutput, Stream, check_streams
    from tactogram_playback.workflows import session
    from tactogram_playback.workflows.textures import TextureSettings, textures_of

    _check_combination(motion, backend, display, level, track)
    sources = [sources] if isinstance(sources, str | Path) else sources
    files = [None if path is None else Path(path) for path in (out, figure)]
    session.check_files(*files)
    known = None if display is None else open_display(display, changes=changes)
    destination = _backend(
        backend,
        known,
        device=device,
        to=to,
        full_scale=full_scale,
        realtime=realtime,
        track=track,
        opened=opened,
    )
    played_rate = PLAIN_RATE if known is None else known.rate
    if known is not None:
        check_streams(known)
    most = max(1, int(block_ms / 1e3 * played_rate + 1e-9))
    one_axis = how or (known.axes if known is not None else "dft321")
    settings = TextureSettings(played_rate, most, one_axis, speed_mm_s, along, None, seed)
    names = list(dict.fromkeys([*(mix or {}), *(mix_to or {})]))
    textures, simulated = textures_of(
        sources, names, settings, unit=unit, rate=rate, axes=axes, time=time, sheet=sheet, part=part
    )
    weights = dict.fromkeys(names, 0.0) | dict(mix or {}) if names else None
    contact = ContactSettings(gain=tap_gain)
    output = None
    if known is not None and level is not None:
        together: dict[str, Any] = {"most": most, "weights": weights, "contact": contact}
        if display_family(known.family).stream_surface is not None:
            output = DisplayOutput(
                known, session.only_surface(textures, known.name), level=parse_level(level)
            )
        else:
            rehearsed = session.rehearsal(textures, rate=played_rate, seed=seed, **together)
            output = DisplayOutput(known, rehearsed, level=parse_level(level))
        if tell is not None and (sentence := output.sentence()) is not None:
            tell(sentence)
    clock = Clock()
    finger = session.motion_of(motion, clock, seconds=seconds, seed=seed, listen=listen)
    try:
        engine = Engine(textures, finger, rate=played_rate, most=most, weights=weights, contact=contact)
        on_block = session.gliding(engine, weights or {}, mix_to, seconds) if mix_to else None
        running = Stream(engine, output, record_s=seconds if any(files) else 0.0, on_block=on_block)
        running.warm_up()
        lines = None if status is None else session.status_lines(running, status)
        ran = session.run(running, destination, seconds=seconds, clock=clock, motion=finger, status=lines)
        if isinstance(finger, NetworkMotion):
            ran["network"] = finger.facts()
    finally:
        finger.close()
    if running.error is not None:
        raise running.error
    facts = running.facts() | {
        "backend": backend,
        "seconds": seconds,
        "simulated": simulated or finger.simulated,
        "textures_simulated": simulated,
        "interrupted": running.stopped,
        "realtime_asked": realtime,
        "limited": session.limited(running),
        **ran,
    }
    return facts | session.write_sent(running, facts, *files)


def _check_combination(
    motion: str, backend: str, display: str | None, level: str | None, track: Settings | None
) -> None:
    """Refuse what does not go together before anything moves."""
    if display is None and level is not None:
        raise ParameterError.must("display", "be given with a level", remedy=Remedy("or omit", "level"))
    if display is not None and level is None:
        raise ParameterError.must("level", "be given with a display", remedy=Remedy("or omit", "display"))
    if backend in ("audio", "digilent") and display is None:
        needed = f"be given, with its level: the {backend} backend moves an actuator"
        raise ParameterError.must("display", needed)
    if track is not None and backend != "digilent":
        needed = "be digilent to track its carrier"
        raise ParameterError.must("backend", needed, backend, remedy=Remedy("omit", "track"))
    if backend == "file" and motion in ("osc", "mouse"):
        needed = f"be in real time for motion from {motion}"
        raise ParameterError.must("backend", needed, backend, remedy=Remedy("use", "backend", "clock"))


def _backend(
    kind: BackendKind,
    display: Display | None,
    *,
    device: str | None,
    to: str,
    full_scale: float | None,
    realtime: bool,
    track: Settings | None,
    opened: Callable[..., AnalogDiscovery] | None,
) -> Backend:
    from tactogram.rendering import carrier_of
    from tactogram_playback.transducer.digilent import AnalogDiscovery
    from tactogram_playback.workflows.carrier_tracking import CarrierTracking
    from tactogram_playback.workflows.playback import full_scale_of
    from tactogram_playback.workflows.session import Backend

    at_one, tracking = 1.0, None
    if kind == "audio" and display is not None:
        at_one = full_scale_of(display, "audio", full_scale)
    if track is not None and display is not None:
        tracking = CarrierTracking(
            carrier_of(display), track, serial=device or "", opened=opened or AnalogDiscovery
        )
    return Backend(
        kind,
        device=device or "",
        to=to,
        full_scale=at_one,
        realtime=realtime,
        opened=opened or AnalogDiscovery,
        tracking=tracking,
    )


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
