"""Outcomes in the order of their tasks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, TypeVar

from tactogram.workflows.workers.outcome import Outcome

T = TypeVar("T")
R = TypeVar("R")


def in_order(outcomes: Iterable[Outcome[tuple[int, T], R]]) -> Iterator[Outcome[tuple[int, T], R]]:
    """Yield the outcomes of tasks numbered from 0 in the order of their numbers, each as soon as it can be."""
    waiting: dict[int, Outcome[tuple[int, T], Any]] = {}
    following = 0
    for outcome in outcomes:
        waiting[outcome.task[0]] = outcome
        while following in waiting:
            yield waiting.pop(following)
            following += 1
