"""Texture-free models of friction: they know a fabric by its name and never see its photograph.

Each is given the training windows of one fabric and returns as many new ones as asked; all are baselines of FrictGAN.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import torch
from torch import Tensor

from tactogram.signal import Signal
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.synthesis import Synthesizer
from tactogram.training.seeds import child_generator, child_rng


def constant(trained: Tensor, count: int, seed: int) -> Tensor:
    """Return flat windows at the mean level: Coulomb's friction. All windows are (window, axis, samples)."""
    return trained.mean((0, 2), keepdim=True).expand(count, -1, trained.shape[-1])


def autoregressive(trained: Tensor, count: int, seed: int) -> Tensor:
    """Return windows of a process over displacement with the fabric's spectrum (Burg, order by AIC), never below 0."""
    axes = tuple(map(str, range(trained.shape[1])))
    # The fit is for signals over time; any rate will do.
    model = fit_autoregressive([Signal(window, 1000.0, "1", axes) for window in trained.numpy()])
    samples = trained.shape[-1]
    made = [
        Synthesizer(model, seed=child_rng(seed, "autoregressive", number)).next(samples).samples
        for number in range(count)
    ]
    return torch.from_numpy(np.stack(made)).clamp_min(0)


def replay(trained: Tensor, count: int, seed: int) -> Tensor:
    """Return recorded windows, drawn at random: as on a display that replays a recording from any place."""
    return trained[torch.randint(len(trained), (count,), generator=child_generator(seed, "replay"))]


MODELS: Mapping[str, Callable[[Tensor, int, int], Tensor]] = {
    "constant": constant,
    "autoregressive": autoregressive,
    "replay": replay,
}
