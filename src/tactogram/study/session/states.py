"""Participant states: their names for readers, and counts of each."""

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
"""What `SessionStore.progress` and exports say of a participant, and what it means."""


def called(status: str) -> str:
    """Return what people read of a state: who is active is going on."""
    return "going on" if status == "active" else status


def counted(statuses: Iterable[str]) -> str:
    """Return how many stand how, in the order of `STATES`, then of others' tables: ``1 finished, 2 going on``."""
    counts = Counter(statuses)
    return ", ".join(
        f"{counts[status]} {called(status)}" for status in dict.fromkeys([*STATES, *counts]) if counts[status]
    )
