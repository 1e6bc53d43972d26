"""Benchmark of the measures: cost as a multiple of the plainest one, in the same run.

Measures of signals: beside `scipy.signal.welch` (0.25 s segments) over the same signals, two sets of 32 simulated
textures of three axes, 4 s at 1 kHz. Measures of embeddings: beside the product of the two sets' matrices, which any
comparison of all pairs needs, 2,000 points of 256 features each. Each repetition runs the plain one and the measure in
turn; the ratio is the median of nine. One thread (threadpoolctl) for both.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.signal import lfilter, welch
from threadpoolctl import threadpool_limits

from benchmarks.timing import beside
from tactogram.evaluation.measures import (
    classifier_features,
    frechet_distance,
    memorisation,
    precision_recall_density_coverage,
    segments,
    signal_measures,
    transfer_accuracy,
    two_sample_accuracy,
)
from tactogram.signal import Signal

RATE, SECONDS, SIGNALS = 1000.0, 4.0, 32
POINTS, FEATURES = 2000, 256
REPETITIONS = 9


def run() -> list[dict[str, Any]]:
    """Return a row per measure; see the module for what is measured."""
    one, other, unseen = (textures(seed, SIGNALS) for seed in (0, 1, 2))
    random = np.random.default_rng(0)
    a, b = random.standard_normal((2, POINTS, FEATURES))
    signals = "welch of the same signals"

    def plain() -> None:
        for members in (one, other):
            welch(np.stack([s.samples for s in members]).astype(np.float64), RATE, nperseg=250)

    jobs: list[tuple[str, str, Callable[[], object], Callable[[], object]]] = [
        (name, signals, plain, lambda f=measure.function: f(one, other))
        for name, measure in signal_measures().items()
    ]
    jobs += [
        ("memorisation, 8 generated and 8 unseen against 32", signals, plain,
         lambda: memorisation(one[:8], other, unseen[:8])),
        ("classifier_features", signals, plain, lambda: classifier_features([*one, *other])),
        ("transfer_accuracy, linear discriminant, 1 s pieces", signals, plain,
         lambda: transfer_accuracy(*({"a": segments(s[:16], 1.0), "b": segments(s[16:], 1.0)} for s in (one, other)))),
    ]  # fmt: skip
    points = "product of the two matrices"
    jobs += [
        (function.__name__, points, lambda: a @ b.T, lambda f=function: f(a, b))
        for function in (frechet_distance, precision_recall_density_coverage, two_sample_accuracy)
    ]
    with threadpool_limits(1):
        return [
            {"measure": name, "beside": of, **beside(plain, job, REPETITIONS)}
            for name, of, plain, job in jobs
        ]


def textures(seed: int, count: int) -> list[Signal]:
    """Return simulated textures: noise with a resonance near 150 Hz in bursts, as strokes give."""
    random = np.random.default_rng(seed)
    n = round(RATE * SECONDS)
    pole = 0.9 * np.exp(2j * np.pi * 150 / RATE)
    found = []
    for _ in range(count):
        x = lfilter([1], [1, -2 * pole.real, abs(pole) ** 2], random.standard_normal((3, n)))
        bursts = 0.1 + np.abs(np.sin(np.pi * random.uniform(2, 8) * np.arange(n) / RATE))
        found.append(Signal((x * bursts).astype(np.float32), RATE, "m/s^2"))
    return found
