"""Verbs that calibrate, track and drive actuators."""

import sys
from dataclasses import dataclass
from typing import Annotated

from tactogram.cli.printing import Printer, columns, lines_of
from tactogram.cli.stopping import interrupt_on_sigterm
from tactogram.cli.verbs import Verb
from tactogram.workflows.rendering.requests import CalibrationRequest, PlayRequest, TrackRequest
from tactogram.workflows.request import Argument, Request


@dataclass(frozen=True)
class _TransducerRequest(Request):
    sweep: Annotated[
        str,
        Argument(
            "columns frequency_hz, conductance_s, susceptance_s; or a log of `track`, whose sweep is read",
            "SWEEP.csv",
        ),
    ]


def _calibrate(request: CalibrationRequest, show: Printer) -> None:
    from tactogram.workflows.rendering.actuators import calibrate

    result = calibrate(**vars(request))
    rows = [("person", "k_e, N/V^2", "interval", "mu_0", "exponent", "square law", "pairs")]
    for name, fit in result["people"].items():
        low, high = fit["newton_per_v2_interval"]
        exponent = "-" if fit["exponent"] is None else f"{fit['exponent']:.2f}"
        holds = {True: "not contradicted", False: "contradicted", None: "not tested"}[fit["square_law_holds"]]
        rows.append(
            (
                name,
                f"{fit['newton_per_v2']:.3g}",
                f"{low:.3g} to {high:.3g}",
                f"{fit['mu_0']:.3g}",
                exponent,
                holds,
                str(fit["pairs"]),
            )
        )
    show(result, f"{columns(rows)}\n{result['file']}")


def _transducer(request: _TransducerRequest, show: Printer) -> None:
    from tactogram.workflows.rendering.actuators import transducer

    show(result := transducer(request.sweep), lines_of(result))


@interrupt_on_sigterm()
def _track(request: TrackRequest, show: Printer) -> None:
    from tactogram.workflows.rendering.carrier_tracking import track

    terminal = sys.stderr.isatty()
    result = track(**vars(request) | {"status": _show_status if terminal else None})
    if terminal:
        sys.stderr.write("\n")
    show(result, lines_of(result))


def _show_status(line: str) -> None:
    sys.stderr.write(f"\r{line:78}")
    sys.stderr.flush()


@interrupt_on_sigterm()
def _play(request: PlayRequest, show: Printer) -> None:
    if request.device.partition(":")[0] in ("audio", "null"):
        from tactogram.workflows.rendering.playback import play_drive as play
    else:
        from tactogram.workflows.rendering.actuators import play
    show(result := play(**vars(request)), lines_of(result))


VERBS = {
    "calibrate": Verb(CalibrationRequest, _calibrate),
    "transducer": Verb(_TransducerRequest, _transducer),
    "track": Verb(TrackRequest, _track),
    "play": Verb(PlayRequest, _play),
}
