"""Table of the experiment on Hatori & Takemura 2023, Figure 7."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactogram.evaluation import STRAIGHT

RATER_MODEL = "a rater model"
KNOWS_NEAREST = (
    "The rater model was trained on the display signals, so its error is smaller for the nearest of them, or a copy, "
    "than for a new signal."
)
HEADER = ("condition", "MAE", "SE", "n", "plates", "p as printed", "p by rater", "p by plate")


def figure7_text(result: Mapping[str, Any], conditions: tuple[str, ...]) -> str:
    """Return the errors of each condition (a row each, in this order) by raters, from the result of ``run``."""
    lines = [
        f"Figure 7 on {result['data']}, recipe {result['recipe']}"
        + (f" at {result['iterations']} iterations" if result["iterations"] else "")
        + "; p against the sensor's signal. Published: B, C and D below it with p < 0.01, A not, E failed."
    ]
    for by, told in result["told_by"].items():
        lines.append(f"Rated by {by}:")
        lines.append("  " + "".join(f"{name:>14}" for name in HEADER))
        rows = _rows(result, by, conditions)
        lines += ["  " + "".join(f"{_cell(value):>14}" for value in row) for row in rows]
        lines += [f"  {name}: {value:.3f}" for name, value in told["beside"].items()]
        if by.startswith(RATER_MODEL):
            lines.append(f"  {KNOWS_NEAREST}")
    for name, row in result["spread_over_trainings"].items():
        if row["mean"] is not None:
            sd = "" if row["sd"] is None else f" ± {row['sd']:.3f}"
            lines.append(
                f"group {name} over {len(row['values'])} trainings, by the rater model: {row['mean']:.3f}{sd}"
            )
    for name, failed in result["failed"].items():
        lines += [f"group {name}, {item}: {why}" for item, why in failed.items()]
    return "\n".join(lines)


def _rows(result: Mapping[str, Any], by: str, conditions: tuple[str, ...]) -> list[tuple[Any, ...]]:
    """Return a row per condition: error, standard errors, n, p as printed and by rater, against the sensor."""
    told = result["told_by"][by]
    rows = []
    for name in conditions:
        found = told["conditions"].get(name)
        if found is None:
            rows.append((name, None, None, None, "failed", None, None, None))
            continue
        ps = [_p(told["tests"][test], name) for test in ("as_printed", "by_rater", "by_target")]
        rows.append((name, found["mae"], found["se"], found["n"], found["targets"], *ps))
    return rows


def _p(pairs: list[dict[str, Any]] | None, name: str) -> float | None:
    for pair in pairs or ():
        if {pair["first"], pair["second"]} == {STRAIGHT, name}:
            return pair["p"]  # type: ignore[no-any-return]
    return None


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.2g}" if abs(value) < 0.01 else f"{value:.3f}"
    return "-" if value is None else str(value)
