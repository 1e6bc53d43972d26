"""Participant states, their labels and counts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

NOT_BEGUN = "not begun"
STATES: Mapping[str, str] = {
    "finished": "to the end",
    "active": "begun, and not at the end",
    NOT_BEGUN: "enrolled, and answered no page yet",
    "aborted": "ended by the experimenter",
    "declined": "did not agree to take part",
}
"""Meaning of the states in `SessionStore.progress` and exports."""


def status_label(status: str) -> str:
    """Return the label of a state on pages and in reports."""
    return "going on" if status == "active" else status


def status_counts(statuses: Iterable[str]) -> str:
    """Return counts in the order of `STATES`, then of states in foreign tables: ``1 finished, 2 going on``."""
    counts = Counter(statuses)
    return ", ".join(
        f"{counts[status]} {status_label(status)}"
        for status in dict.fromkeys([*STATES, *counts])
        if counts[status]
    )
