"""A stream on its backend, with its motion and status lines."""

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
from tactogram.workflows.streaming.requests import StreamRequest

StatusCallback = Callable[[str, float], None]


def motion_of(request: StreamRequest, clock: Clock) -> MotionSource:
    """Return the source of the finger's motion."""
    match request.motion:
        case "simulated":
            return SimulatedHand(request.seconds + 1, seed=request.seed)
        case "mouse":
            return MouseMotion()
        case "osc" | "udp":
            host, port = parse_address(request.listen or "127.0.0.1")
            return NetworkMotion(host=host, port=port, clock=clock.now)
    return MotionFile(request.motion)


def run(running: Stream, request: StreamRequest, clock: Clock, motion: MotionSource) -> dict[str, Any]:
    """Run a stream on its backend and return the facts of that, as JSON values: ``device``, ``blocks``."""
    status = None if request.status is None else _status(running, request.status)
    seconds, realtime, card = request.seconds, request.realtime, request.device
    match request.backend:
        case "file":
            run_unpaced(running, seconds=seconds, status=status)
            return {"device": {"library": "none", "paced": False}}
        case "null":
            return {
                "device": run_miniaudio(
                    running, seconds=seconds, clock=clock, null=True, status=status, realtime=realtime
                )
            }
        case "audio":
            return {
                "device": run_audio(
                    running,
                    seconds=seconds,
                    clock=clock,
                    device=int(card) if card is not None and card.isdigit() else card,
                    status=status,
                    realtime=realtime,
                )
            }
        case "osc" | "udp":
            to = parse_address(request.to, default_port=9121) if request.to else None
            heard = motion if isinstance(motion, NetworkMotion) else None
            sink = NetworkBlocks(request.backend, rate=running.engine.rate, to=to, motion=heard)
            granted = run_clocked(
                running, seconds=seconds, clock=clock, sink=sink, status=status, realtime=realtime
            )
            sink.close()
            return {
                "device": {"library": request.backend, "realtime_priority": granted},
                "blocks": {"sent": sink.sent, "unsent": sink.unsent},
            }
    granted = run_clocked(running, seconds=seconds, clock=clock, status=status, realtime=realtime)
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
