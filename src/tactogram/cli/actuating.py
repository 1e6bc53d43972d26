"""Verbs that calibrate, track and drive actuators."""

from __future__ import annotations

import sys

from tactogram.cli.options import Add, Verbs
from tactogram.cli.printing import Arguments, columns, lines_of, print_result
from tactogram.cli.stopping import interrupt_on_sigterm


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    _calibrate_options(verbs.add("calibrate", calibrate))
    verbs.add("transducer", transducer)(
        "sweep",
        metavar="SWEEP.csv",
        help="columns frequency_hz, conductance_s, susceptance_s; or a log of `track`, whose sweep is read",
    )
    _track_options(verbs.add("track", track))
    _play_options(verbs.add("play", play))


def calibrate(a: Arguments) -> None:
    """Fit voltage to friction, person by person, for an electrovibration display."""
    from tactogram.workflows.rendering.actuators import calibrate

    result = calibrate(a.pairs, a.out, normal_force_n=a.force, confidence=a.confidence)
    rows = [("person", "k_e, N/V^2", "interval", "mu_0", "exponent", "square law", "pairs")]
    for name, found in result["people"].items():
        low, high = found["newton_per_v2_interval"]
        exponent = "-" if found["exponent"] is None else f"{found['exponent']:.2f}"
        holds = {True: "not contradicted", False: "contradicted", None: "not tested"}[
            found["square_law_holds"]
        ]
        rows.append(
            (
                name,
                f"{found['newton_per_v2']:.3g}",
                f"{low:.3g} to {high:.3g}",
                f"{found['mu_0']:.3g}",
                exponent,
                holds,
                str(found["pairs"]),
            )
        )
    print_result(a, result, f"{columns(rows)}\n{result['file']}")


def transducer(a: Arguments) -> None:
    """Identify a transducer's resonance and Q from its measured admittance."""
    from tactogram.workflows.rendering.actuators import transducer

    result = transducer(a.sweep)
    print_result(a, result, lines_of(result))


@interrupt_on_sigterm()
def track(a: Arguments) -> None:
    """Keep a carrier at a transducer's resonance, by its measured voltage and current."""
    from tactogram.recipe import parse_changes
    from tactogram.workflows.rendering.resonance import TrackSettings, track

    settings = TrackSettings(
        generator=a.generator,
        source=a.source,
        steps=a.steps,
        every_s=a.every,
        share=a.share,
        channel=a.channel,
        seed=a.seed,
    )
    terminal = sys.stderr.isatty()
    result = track(
        a.display,
        settings,
        amps_per_volt=a.amps_per_volt,
        volts_per_volt=a.volts_per_volt,
        skew_s=a.skew,
        axes=tuple(a.axes) if a.axes else None,
        changes=parse_changes(a.set),
        out=a.out,
        status=_told if terminal else None,
    )
    if terminal:
        sys.stderr.write("\n")
    print_result(a, result, lines_of(result))


def _told(line: str) -> None:
    sys.stderr.write(f"\r{line:78}")
    sys.stderr.flush()


@interrupt_on_sigterm()
def play(a: Arguments) -> None:
    """Play a rendered drive on a sound card, or an envelope on a generator that makes the carrier itself."""
    if a.device.partition(":")[0] in ("audio", "null"):
        from tactogram.workflows.rendering.playback import play_drive

        result = play_drive(
            a.file, a.display, device=a.device, strength=a.strength, loop_s=a.loop, full_scale=a.full_scale
        )
    else:
        from tactogram.workflows.rendering.actuators import play

        result = play(a.file, a.display, device=a.device, channel=a.channel, loop_s=a.loop)
    print_result(a, result, lines_of(result))


def _calibrate_options(add: Add) -> None:
    add(
        "pairs",
        metavar="PAIRS.csv",
        help="columns voltage_v_rms, friction; person and normal_force_n if known",
    )
    add("--out", required=True, metavar="F.toml")
    add("--force", type=float, metavar="N", help="normal force, where the table does not state it")
    add("--confidence", type=float, default=0.95, help="confidence of the intervals (default %(default)g)")


def _track_options(add: Add) -> None:
    add("--display", required=True, metavar="NAME|FILE", help="ultrasonic, output = 'envelope'")
    add(
        "--generator",
        default="simulated",
        metavar="DEVICE",
        help="digilent[:SERIAL], or simulated: a bench of its own (default %(default)s)",
    )
    add(
        "--source",
        default="scope",
        metavar="ADDRESS",
        help="of voltage and current: the generator's own inputs (default %(default)s), or ni:Dev1/ai0:1?rate=250000",
    )
    add("--axes", nargs=2, metavar=("VOLTAGE", "CURRENT"), help="of the source (default: its first two)")
    add("--amps-per-volt", type=float, metavar="A_V", help="1 over the shunt's resistance in ohm")
    add("--volts-per-volt", type=float, default=1.0, metavar="V_V", help="of the voltage's probe (default 1)")
    add(
        "--skew",
        type=float,
        default=0.0,
        metavar="S",
        help="by how much the current is taken later than the voltage",
    )
    add("--share", type=float, default=0.25, help="of the largest voltage (default %(default)g)")
    add("--steps", type=int, default=100, help="after the lock (default %(default)s)")
    add("--every", type=float, default=0.0, metavar="S", help="seconds from step to step")
    add("--channel", type=int, default=1, help="of the generator (default %(default)s)")
    add("--seed", type=int, default=0, help="of the simulated bench")
    add("--out", metavar="F.csv", help="log of everything measured")
    add(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="e.g. method=dither_conductance, timing.settle_s=0.1, scope.rate=200000, bench.drift_hz_per_s=1",
    )


def _play_options(add: Add) -> None:
    add("file", metavar="DRIVE", help="as `render` wrote it for the display")
    add("--display", required=True, metavar="NAME|FILE", help="that display; a Digilent needs an envelope's")
    add(
        "--device",
        default="digilent",
        metavar="DEVICE",
        help="digilent[:SERIAL], audio[:NAME], or null, which plays to nobody (default %(default)s)",
    )
    add("--channel", type=int, default=1, help="of the Digilent (default %(default)s)")
    add("--loop", type=float, metavar="SECONDS", help="again and again for so long")
    add("--strength", type=float, default=1.0, help="share of the drive, on audio and null (default 1)")
    add(
        "--full-scale",
        type=float,
        metavar="V",
        help="what the amplifier behind a sound card makes of full scale, for a display that is driven in V",
    )
