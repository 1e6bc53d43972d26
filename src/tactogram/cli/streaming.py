"""The verb that streams textures under a finger."""

from __future__ import annotations

import sys

from tactogram.cli.options import Verbs, models_option, signal_arguments, signal_options
from tactogram.cli.printing import Arguments, print_result
from tactogram.cli.stopping import interrupt_on_sigterm


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("stream", stream)
    add("sources", metavar="RUN|FILE", nargs="+", help="generators and signals, streamed at the same time")
    add(
        "--motion",
        default="simulated",
        metavar="simulated|osc|udp|mouse|FILE",
        help="where the finger's motion comes from (default %(default)s)",
    )
    add(
        "--backend",
        default="null",
        choices=("null", "file", "clock", "audio", "osc", "udp"),
        help="where the blocks go (default %(default)s)",
    )
    add("--display", metavar="NAME|FILE", help="one of `displays`, or a TOML file")
    add(
        "--level",
        metavar="LEVEL",
        help="as of `render`; found under a simulated hand before the stream begins",
    )
    add(
        "--equalise",
        choices=("on", "off"),
        help="make up for the display's response (default: as its file says, on wherever the response is known)",
    )
    add(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a value of the display, e.g. linear.cap_db=10",
    )
    add("--seconds", type=float, default=10.0, help="default %(default)s")
    add("--mix", metavar="A=0.6,B=0.4", help="weights by material or file stem (default: all the same)")
    add("--mix-to", metavar="A=0,B=1", help="weights at the end; they go there while it plays")
    add(
        "--speed",
        type=float,
        metavar="MM_S",
        help="at which signals over time were recorded or are generated",
    )
    add("--along", choices=("path", "x", "y"), default="path", help="what a surface is laid out over")
    add("--as", dest="how", metavar="WAY", help="how axes become one: dft321 or an axis's name")
    add("--block", type=float, default=5.0, metavar="MS", help="length of a block, at most 5 ms")
    add("--listen", default="", metavar="HOST:PORT", help="where motion is heard (default 127.0.0.1:9120)")
    add("--to", default="", metavar="HOST:PORT", help="where blocks go (default: to who sends the motion)")
    add("--device", metavar="NAME", help="a sound card")
    add("--tap", type=float, default=4.0, metavar="GAIN", help="of a landing's transient, 0 for none")
    add("--realtime", action="store_true", help="ask the system for real-time priority")
    add("--seed", type=int, default=0, help="of noise and simulated hand")
    add("--out", metavar="F", help="what was sent: .wav, .csv, .npz …")
    add("--figure", metavar="F", help="its spectrogram under the finger's speed, as .png")
    signal_options(add)
    models_option(add)


@interrupt_on_sigterm()
def stream(a: Arguments) -> None:
    """Play textures that follow a finger, and measure how late they are."""
    from pathlib import Path

    from tactogram.recipe import parse_changes
    from tactogram.workflows.generation.generate import parse_mix
    from tactogram.workflows.streaming.report import latency_lines
    from tactogram.workflows.streaming.settings import StreamSettings
    from tactogram.workflows.streaming.stream import stream

    settings = StreamSettings(
        motion=a.motion,
        backend=a.backend,
        seconds=a.seconds,
        block_ms=a.block,
        seed=a.seed,
        listen=a.listen,
        to=a.to,
        device=a.device,
        tap_gain=a.tap,
        realtime=a.realtime,
        equalise=None if a.equalise is None else a.equalise == "on",
    )
    told = _StatusPrinter()
    result = stream(
        a.sources,
        settings,
        mix=parse_mix(a.mix) if a.mix else None,
        mix_to=parse_mix(a.mix_to) if a.mix_to else None,
        display=a.display,
        level=a.level,
        how=a.how,
        along=a.along,
        speed_mm_s=a.speed,
        out=Path(a.out) if a.out else None,
        figure=Path(a.figure) if a.figure else None,
        changes=parse_changes(a.set),
        status=told,
        tell=told.line,
        **signal_arguments(a),
    )
    if sys.stderr.isatty():
        sys.stderr.write("\n")
    of = " (simulated)" if result["simulated"] else ""
    lines = [f"{', '.join(result['textures'])}{of}: {result['seconds']:g} s to {result['backend']}"]
    lines += latency_lines(result)
    lines += [f"{name}: {result[name]}" for name in ("file", "figure") if name in result]
    print_result(a, result, "\n".join(lines))


class _StatusPrinter:
    """Writes a status over the one before on a terminal; elsewhere a line every ten seconds."""

    def __init__(self) -> None:
        self._next_s = 0.0

    def line(self, text: str) -> None:
        """Write a line that stays."""
        sys.stderr.write(text + "\n")
        sys.stderr.flush()

    def __call__(self, line: str, now_s: float) -> None:
        if sys.stderr.isatty():
            sys.stderr.write(f"\r{line[:118]:118}")
        elif now_s >= self._next_s:
            self._next_s = now_s + 10
            sys.stderr.write(line + "\n")
        sys.stderr.flush()
