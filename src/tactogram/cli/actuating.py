"""Verbs that calibrate, track and drive actuators."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from tactogram.cli.printing import columns, lines_of
from tactogram.cli.stopping import interrupt_on_sigterm
from tactogram.cli.verbs import Verb

ACTUATORS = "tactogram.workflows.rendering.actuators"


def _calibrate_text(result: dict[str, Any]) -> str:
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
    return f"{columns(rows)}\n{result['file']}"


@contextmanager
def _tracking() -> Iterator[Mapping[str, Callable[[str], None] | None]]:
    terminal = sys.stderr.isatty()
    with interrupt_on_sigterm():
        yield {"status": _show_status if terminal else None}
    if terminal:
        sys.stderr.write("\n")


def _show_status(line: str) -> None:
    sys.stderr.write(f"\r{line:78}")
    sys.stderr.flush()


VERBS = {
    "calibrate": Verb(f"{ACTUATORS}:calibrate", _calibrate_text),
    "transducer": Verb(f"{ACTUATORS}:transducer", lines_of),
    "track": Verb(f"{ACTUATORS}:track", lines_of, within=_tracking),
    "play": Verb(f"{ACTUATORS}:play", lines_of, within=interrupt_on_sigterm),
}
