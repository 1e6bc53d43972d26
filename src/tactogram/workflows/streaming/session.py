"""A stream on its backend: which one, with which motion, and how it is told that it goes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tactogram.rendering.streaming.backends import (
    Clock,
    run_audio,
    run_clocked,
    run_miniaudio,
    run_unpaced,
)
from tactogram.rendering.streaming.motion import MotionSource
from tactogram.rendering.streaming.network import NetworkBlocks, NetworkMotion, parse_address
from tactogram.rendering.streaming.recorded_motion import MotionFile, MouseMotion
from tactogram.rendering.streaming.simulated_hand import SimulatedHand
from tactogram.rendering.streaming.stream import Stream
from tactogram.workflows.streaming.settings import StreamSettings

StatusCallback = Callable[[str, float], None]


def motion_of(settings: StreamSettings, clock: Clock) -> MotionSource:
    """Return where the finger's motion comes from."""
    match settings.motion:
        case "simulated":
            return SimulatedHand(settings.seconds + 1, seed=settings.seed)
        case "mouse":
            return MouseMotion()
        case "osc" | "udp":
            host, port = parse_address(settings.listen or "127.0.0.1")
            return NetworkMotion(host=host, port=port, clock=clock.now)
    return MotionFile(settings.motion)


def run(
    running: Stream,
    settings: StreamSettings,
    clock: Clock,
    motion: MotionSource,
    status: StatusCallback | None,
) -> dict[str, Any]:
    """Run a stream on its backend and return what is known of that, as JSON values: ``device``, ``blocks``."""
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


def _status(running: Stream, status: StatusCallback) -> Callable[[float], None]:
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
