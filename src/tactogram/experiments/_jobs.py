"""The jobs that an experiment may call: they stand above experiments and are handed down as one value."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Protocol

from tactogram.datasets import Ratings
from tactogram.signal import Image, Signal
from tactogram.training.run import Run

Facts = Callable[..., dict[str, Any]]
"""A job that returns its figures by name."""


class Jobs(Protocol):
    """What `tactogram.jobs.reproduce` hands down; the job of each name says what it takes and returns."""

    @property
    def simulate(self) -> Facts:
        """`tactogram.jobs.simulate.simulate_to_store`."""
        ...

    @property
    def import_store(self) -> Facts:
        """`tactogram.jobs.data.import_store`."""
        ...

    @property
    def train(self) -> Callable[..., Run]:
        """`tactogram.jobs.training.train`."""
        ...

    @property
    def load_run(self) -> Callable[..., Any]:
        """`tactogram.jobs.training.load_run`, which returns a `LoadedRun`."""
        ...

    @property
    def crossval(self) -> Facts:
        """`tactogram.jobs.crossval.crossval`."""
        ...

    @property
    def crossval_ratings(self) -> Facts:
        """`tactogram.jobs.rating_crossval.crossval_ratings`."""
        ...

    @property
    def evaluate(self) -> Facts:
        """`tactogram.jobs.evaluate.evaluate`."""
        ...

    @property
    def judge_pictures(self) -> Facts:
        """`tactogram.jobs.pictures.judge_pictures`."""
        ...

    @property
    def compare_pictures(self) -> Callable[..., Path]:
        """`tactogram.jobs.pictures.compare_pictures`."""
        ...

    @property
    def judge_reproduction(self) -> Facts:
        """`tactogram.jobs.rating_judging.judge_reproduction`."""
        ...

    @property
    def predicted_ratings(self) -> Callable[..., Ratings]:
        """`tactogram.jobs.rating_judging.predicted_ratings`."""
        ...

    @property
    def score(self) -> Facts:
        """`tactogram.jobs.score.score`."""
        ...

    @property
    def generate(self) -> Callable[..., Iterator[Signal | Image]]:
        """`tactogram.jobs.generate.generate`."""
        ...

    @property
    def made_by_words(self) -> Callable[..., Any]:
        """`tactogram.jobs.made_by_words.made_by_words`, which returns a `MadeByWords`."""
        ...

    @property
    def mixing_ladder(self) -> Facts:
        """`tactogram.jobs.mixing.mixing_ladder`."""
        ...

    @property
    def recorded(self) -> Callable[..., list[Signal]]:
        """`tactogram.jobs.mixing.recorded`."""
        ...

    @property
    def capture(self) -> Facts:
        """`tactogram.jobs.capture.capture`."""
        ...

    @property
    def live(self) -> Facts:
        """`tactogram.jobs.live.live`."""
        ...
