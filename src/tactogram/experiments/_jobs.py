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
    """What `tactogram.workflows.reproduce` hands down; the job of each name says what it takes and returns."""

    @property
    def simulate(self) -> Facts:
        """`tactogram.workflows.data.simulate.simulate_to_store`."""
        ...

    @property
    def import_store(self) -> Facts:
        """`tactogram.workflows.data.stores.import_store`."""
        ...

    @property
    def train(self) -> Callable[..., Run]:
        """`tactogram.workflows.training.train.train`."""
        ...

    @property
    def load_run(self) -> Callable[..., Any]:
        """`tactogram.workflows.training.train.load_run`, which returns a `LoadedRun`."""
        ...

    @property
    def crossval(self) -> Facts:
        """`tactogram.workflows.evaluation.crossval.crossval`."""
        ...

    @property
    def crossval_ratings(self) -> Facts:
        """`tactogram.workflows.evaluation.rating_crossval.crossval_ratings`."""
        ...

    @property
    def evaluate(self) -> Facts:
        """`tactogram.workflows.evaluation.evaluate.evaluate`."""
        ...

    @property
    def judge_pictures(self) -> Facts:
        """`tactogram.workflows.evaluation.pictures.judge_pictures`."""
        ...

    @property
    def compare_pictures(self) -> Callable[..., Path]:
        """`tactogram.workflows.evaluation.pictures.compare_pictures`."""
        ...

    @property
    def judge_reproduction(self) -> Facts:
        """`tactogram.workflows.evaluation.ratings.judge_reproduction`."""
        ...

    @property
    def predicted_ratings(self) -> Callable[..., Ratings]:
        """`tactogram.workflows.evaluation.ratings.predicted_ratings`."""
        ...

    @property
    def score(self) -> Facts:
        """`tactogram.workflows.recognition.score.score`."""
        ...

    @property
    def generate(self) -> Callable[..., Iterator[Signal | Image]]:
        """`tactogram.workflows.generation.generate.generate`."""
        ...

    @property
    def made_by_words(self) -> Callable[..., Any]:
        """`tactogram.workflows.evaluation.word_signals.made_by_words`, which returns a `MadeByWords`."""
        ...

    @property
    def mixing_ladder(self) -> Facts:
        """`tactogram.workflows.evaluation.mixing_ladder.mixing_ladder`."""
        ...

    @property
    def recorded(self) -> Callable[..., list[Signal]]:
        """`tactogram.workflows.evaluation.mixing_ladder.recorded`."""
        ...

    @property
    def capture(self) -> Facts:
        """`tactogram.workflows.capture.session.capture`."""
        ...

    @property
    def live(self) -> Facts:
        """`tactogram.workflows.capture.live.live`."""
        ...
