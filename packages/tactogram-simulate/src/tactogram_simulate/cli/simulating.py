"""Verbs on simulated surfaces: the demo, and data sets of them."""

from __future__ import annotations

from typing import Any

from tactogram.cli.printing import accuracies, lines_of
from tactogram.cli.verbs import Verb

WORKFLOWS = "tactogram_simulate.workflows"


def _demo_text(result: dict[str, Any]) -> str:
    unmet = result["none_of_these"]
    return "\n".join(
        [
            f"simulated strokes classified correctly: {accuracies(result)}",
            f"of {unmet['unknown']} strokes over a surface absent from training, "
            f"{100 * unmet['unknown_rejected']:.0f} % are classified as none of these",
            f"mixtures: {result['mixing']}",
            f"report with pictures and sounds (open it in a browser): {result['report']}",
            "to explore the same in the browser: tactogram studio",
        ]
    )


VERBS = {
    "demo": Verb(f"{WORKFLOWS}.demo:demo", _demo_text),
    "data simulate": Verb(f"{WORKFLOWS}.simulate:simulate_to_store", lines_of),
}
