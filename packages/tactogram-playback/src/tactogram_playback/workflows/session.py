"""A stream on its backend, with its motion, level, status lines and files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.model import limits_of
from tactogram.rendering import Display, MotionFile, MotionSource, SimulatedHand, carrier_of
from tactogram.signal import Signal
from tactogram.signal.io import WRITABLE, atomic_write, check_writable, write_signal
from tactogram_playback.streaming.backends import (
    Clock,
    clocked_blocks,
    run_audio,
    run_clocked,
    run_miniaudio,
    run_unpaced,
)
from tactogram_playback.streaming.contact import ContactSettings
from tactogram_playback.streaming.engine import Engine
from tactogram_playback.streaming.mouse import MouseMotion
from tactogram_playback.streaming.network import NetworkBlocks, NetworkMotion, parse_address
from tactogram_playback.streaming.noise_texture import ModulatedNoiseTexture
from tactogram_playback.streaming.output import Stream
from tactogram_playback.streaming.textures import AutoregressiveTexture, StreamingTexture, SurfaceTexture
from tactogram_playback.transducer.digilent import PREFILL_S, AnalogDiscovery, generator
from tactogram_playback.transducer.simulation import BenchSettings, SimulatedGenerator
from tactogram_playback.workflows.carrier_tracking import SIMULATED, CarrierTracking
from tactogram_playback.workflows.playback import full_scale_of

BackendKind = Literal["null", "file", "clock", "audio", "osc", "digilent"]
REHEARSAL_S = 5.0
"""Time that the textures are tried under a simulated hand to find the level, s."""
StatusCallback = Callable[[float], None]
DEVICES = "null, audio, audio:NAME, digilent, digilent:SERIAL or osc:HOST:PORT"


@dataclass(frozen=True)
class Backend:
    """Destination of a stream's blocks.

    ``tracking`` keeps a Digilent's carrier at the transducer's resonance.
    ``device`` names a sound card or the serial number of a Digilent; ``to`` is the address for osc, by default
    that of the motion's sender; ``full_scale`` the drive at a sound card's 1.0; ``opened`` opens a Digilent.
    """

    kind: BackendKind
    device: str = ""
    to: str = ""
    full_scale: float = 1.0
    realtime: bool = False
    opened: Callable[..., AnalogDiscovery] = AnalogDiscovery
    tracking: CarrierTracking | None = None

    @classmethod
    def for_display(
        cls,
        device: str,
        display: Display,
        *,
        full_scale: float | None = None,
        tracking: CarrierTracking | None = None,
    ) -> Self:
        """Return the backend for a device that plays ``display``; null keeps time without a device.

        Raises `ParameterError` if there is no such device, it cannot drive the display, or its full scale is not known.
        """
        kind, _, name = device.partition(":")
        match kind:
            case "null":
                return cls("clock")
            case "audio":
                return cls("audio", device=name, full_scale=full_scale_of(display, kind, full_scale))
            case "osc" if name:
                parse_address(name)
                return cls("osc", to=name)
            case "digilent":
                carrier_of(display)
                return cls("digilent", device=name, tracking=tracking)
        raise ParameterError.must("device", f"be {DEVICES}", device)

    @property
    def simulated(self) -> bool:
        """Whether no device receives the blocks."""
        return self.kind in ("null", "file", "clock") or (self.kind, self.device) == ("digilent", SIMULATED)


def motion_of(motion: str, clock: Clock, *, seconds: float, seed: int, listen: str = "") -> MotionSource:
    """Return the source of the finger's motion; ``listen`` is the address of osc."""
    match motion:
        case "simulated":
            return SimulatedHand(seconds + 1, seed=seed)
        case "mouse":
            return MouseMotion()
        case "osc":
            host, port = parse_address(listen or "127.0.0.1")
            return NetworkMotion(host=host, port=port, clock=clock.now)
    return MotionFile(motion)


def run(
    running: Stream,
    backend: Backend,
    *,
    seconds: float,
    clock: Clock,
    motion: MotionSource | None = None,
    status: StatusCallback | None = None,
) -> dict[str, Any]:
    """Run a stream on its backend and return the facts of that, as JSON values: ``device``, ``blocks``."""
    paced: dict[str, Any] = {"seconds": seconds, "clock": clock, "status": status}
    match backend.kind:
        case "file":
            run_unpaced(running, seconds=seconds, status=status)
            return {"device": {"library": "none", "paced": False}}
        case "null":
            return {"device": run_miniaudio(running, null=True, realtime=backend.realtime, **paced)}
        case "audio":
            card = int(backend.device) if backend.device.isdigit() else backend.device or None
            paced |= {"device": card, "full_scale": backend.full_scale, "realtime": backend.realtime}
            return {"device": run_audio(running, **paced)}
        case "osc":
            to = parse_address(backend.to, default_port=9121) if backend.to else None
            heard = motion if isinstance(motion, NetworkMotion) else None
            sink = NetworkBlocks(rate=running.engine.rate, to=to, motion=heard)
            granted = run_clocked(running, sink=sink, realtime=backend.realtime, **paced)
            sink.close()
            return {
                "device": {"library": backend.kind, "realtime_priority": granted},
                "blocks": {"sent": sink.sent, "unsent": sink.unsent},
            }
        case "digilent":
            return {"device": _run_digilent(running, backend, **paced)}
    granted = run_clocked(running, realtime=backend.realtime, **paced)
    return {"device": {"library": "none", "paced": True, "realtime_priority": granted}}


def _run_digilent(
    running: Stream, backend: Backend, seconds: float, clock: Clock, status: StatusCallback | None
) -> dict[str, Any]:
    """Send the envelope to a Digilent as it is due; the device is a silence of `PREFILL_S` behind."""
    if running.output is None:
        raise ParameterError.must("display", "be given, with its level: a Digilent plays its envelope")
    settings = carrier_of(running.output.display)
    running.engine.latency.queued_s = PREFILL_S

    def envelope() -> Iterator[NDArray[np.float32]]:
        for block, _ in clocked_blocks(running, seconds=seconds, clock=clock, status=status):
            yield block[0]

    rate, tracking = running.engine.rate, backend.tracking
    if tracking is not None:
        with tracking.generator() as tracked:
            with tracking.following(tracked):
                tracked.play(envelope(), rate=rate, longest_s=seconds)
            return tracked.facts() | {"tracking": tracking.facts()}
    if backend.device == SIMULATED:
        bench = SimulatedGenerator(
            BenchSettings(), gain=settings.amplifier_gain, rng=np.random.default_rng(0)
        )
        bench.play(envelope(), rate=rate)
        return bench.facts()
    with backend.opened(generator(settings, serial=backend.device)) as device:
        device.play(envelope(), rate=rate, longest_s=seconds)
        return device.facts()


def status_lines(running: Stream, status: Callable[[str, float], None]) -> StatusCallback:
    """Return a function that describes a stream in a line, at a time."""

    def tell(now_s: float) -> None:
        engine = running.engine
        motion, latency = engine.tracker.block, engine.latency
        last = max(0, motion.count - 1)
        status(
            f"{now_s:7.1f} s  {engine.tracker.state:5}  {motion.speed_mm_s[last]:4.0f} mm/s  "
            f"{motion.force_n[last]:4.2f} N  compute p50 {1e3 * latency.compute.quantile(0.5):.2f} "
            f"p99 {1e3 * latency.compute.quantile(0.99):.2f} of {1e3 * latency.block_s:g} ms  "
            f"underruns {latency.underruns}  dropped {engine.finger.counts.dropped}",
            now_s,
        )

    return tell


def check_files(out: Path | None, figure: Path | None) -> None:
    """Refuse paths that could not be written in the end: an hour of streaming would be lost."""
    if out is not None and out.suffix.lower() not in WRITABLE:
        raise ParameterError.must("out", f"end in one of {', '.join(WRITABLE)}", out)
    if figure is not None and figure.suffix.lower() != ".png":
        raise ParameterError.must("figure", "end in .png", figure)
    for path in filter(None, (out, figure)):
        check_writable(path)


def only_surface(textures: Sequence[StreamingTexture], display: str) -> SurfaceTexture:
    """Return the only surface of a display that streams one at a time; `ParameterError` if there are others."""
    if len(textures) != 1 or not isinstance(textures[0], SurfaceTexture):
        raise ParameterError(
            display,
            "streams one surface at a time, a friction coefficient over displacement (or over time, with its speed); "
            f"got {', '.join(texture.name for texture in textures)}",
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


def gliding(
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
            ("speed_mm_s", "force_n"),
            (texture.table.grid.speeds, texture.table.grid.forces),
            track[:, 1:].T,
            strict=True,
        )
        if nodes[-1] > 0 and seen.any()  # zeros are unknown
        for limit in limits_of(name, seen, (nodes[0], nodes[-1]), f"of {texture.name}")
    ]


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
        from tactogram_playback.stream_figure import stream_figure

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
