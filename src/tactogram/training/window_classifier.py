"""A classifier of windows: a recording is named by what its windows say together."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.model import Example, ExportedNetwork, Model, Port, SignalKind
from tactogram.signal import Signal
from tactogram.statistics import pooled
from tactogram.training.seeds import child_generator

COVERAGE = 0.95
"""Share of new recordings whose own material is among `WindowClassifier.candidates`."""
DRAWN = 4
"""Windows in a batch of typical inputs."""


class WindowClassifier(Model):
    """A subclass defines `step`, `window_probabilities` and `embed`, both by `regular_windows`."""

    kind: SignalKind
    embeds = True
    left_out: NDArray[np.float64] = np.zeros(0)
    """Probability of the right material of recordings that were left out of a fit, float64, shape (recording,)."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        if len(self.materials) < 2:
            raise ParameterError(f"a classifier needs at least 2 materials, got {len(self.materials)}")

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return the share of recordings that are named correctly."""
        hits = [
            self.materials[int(np.argmax(self.probabilities(example.signal)))] == example.material
            for example in examples
        ]
        return {"recording_accuracy": float(np.mean(hits))} if hits else {}

    def probabilities(self, signal: Signal) -> NDArray[np.float64]:
        """Return the probabilities of the windows, pooled: shape (material,)."""
        return pooled(self.window_probabilities(signal))

    def candidates(self, probabilities: NDArray[np.float64]) -> tuple[str, ...] | None:
        """Return the materials among which a recording's own is with `COVERAGE`, likeliest first; None if unknown.

        ``probabilities`` has shape (material,).

        A conformal set (Vovk, Gammerman and Shafer 2005): materials with at least the probability that the right one
        has in this share of the recordings left out. 19 of them are needed.
        """
        rank = int((1 - COVERAGE) * (len(self.left_out) + 1) + 1e-9)
        if rank < 1:
            return None
        least = min(np.sort(self.left_out)[rank - 1], probabilities.max())
        order = np.argsort(-probabilities, kind="stable")
        return tuple(self.materials[i] for i in order if probabilities[i] >= least)

    def regular_windows(self, signal: Signal, samples: int, hop: int, *, at_once: int) -> Iterator[Tensor]:
        """Yield windows of ``samples``, ``hop`` apart, ``at_once`` at a time: (window, axis, time), on the CPU.

        Raises
        ------
        ParameterError
            If the signal is of another kind, or shorter than a window.
        """
        self.kind.check(signal)
        if len(signal) < samples:
            must = f"have at least {samples} samples at {signal.rate:g} Hz"
            raise ParameterError.must("signal", must, len(signal))
        return windows_at(signal, samples, np.arange(0, len(signal) - samples + 1, hop), at_once=at_once)

    def exported_classifier(
        self, network: Any, draw: Callable[[Tensor], Tensor], samples: int, hop: int, *, embedding: str
    ) -> dict[str, ExportedNetwork]:
        """Return a network from windows to probabilities and embeddings; ``draw`` makes inputs of normal noise."""
        shape = DRAWN, len(self.kind.axes), samples
        exported = ExportedNetwork(
            network,
            lambda seed: (draw(torch.randn(shape, generator=child_generator(seed, "export"))),),
            {"windows": Port(("batch", "axis", "time"), "windows of a signal", self.kind.unit)},
            {
                "probability": Port(("batch", "material"), "probability of each material"),
                "embedding": Port(("batch", "feature"), embedding),
            },
            note="probabilities of a recording are pooled over its windows",
            facts={"material": list(self.materials), "hop_samples": hop},
        )
        return {"classifier": exported}


def windows_at(signal: Signal, samples: int, starts: NDArray[np.int64], *, at_once: int) -> Iterator[Tensor]:
    """Yield the windows that begin at ``starts``, ``at_once`` at a time: (window, axis, time)."""
    every = np.lib.stride_tricks.sliding_window_view(signal.samples, samples, axis=1)  # A, W, T
    for first in range(0, len(starts), at_once):
        # A copy: windows of one axis would be a read-only view of the signal.
        yield torch.from_numpy(
            np.array(every[:, starts[first : first + at_once]].transpose(1, 0, 2), order="C")
        )
