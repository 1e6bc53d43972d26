"""Figures of an ``evaluation.json`` by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def evaluation_results(evaluation: Mapping[str, Any]) -> dict[str, float]:
    """Return the results in an ``evaluation.json`` by name; for a generator's measures, the model's column."""
    results = {name: value for name, value in numbers_of(evaluation).items() if "accuracy" in name}
    for measure, row in (evaluation.get("measures") or {}).items():
        if isinstance(row, Mapping) and isinstance(row.get("model"), int | float):
            results[str(measure)] = float(row["model"])
    for table in ("spread", "following", "mean"):
        results |= {f"{table} {name}": value for name, value in numbers_of(evaluation.get(table)).items()}
    return results


def numbers_of(values: Any) -> dict[str, float]:
    """Return the numbers of a JSON object by name; none of anything else."""
    if not isinstance(values, Mapping):
        return {}
    return {
        str(name): float(value)
        for name, value in values.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    }
