"""What the pieces of a long signal are made from: a latent and noise each, the same in every signal of a seed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.model import Condition
from tactogram.models.stroke_gan.config import Config
from tactogram.models.stroke_gan.excitation import white_noise
from tactogram.training.seeds import child_generator, child_rng

AT_ONCE = 8
"""Pieces that are made together, at most."""


class Pieces:
    """Pieces of a long signal, made 1, 1, 2, 4, 8, 8, … at a time: piece k is the same in every signal.

    Parameters
    ----------
    make : callable
        From the number of a piece, and how many, to float32 (piece, axis, time).
    """

    def __init__(self, make: Callable[[int, int], NDArray[np.float32]]) -> None:
        self.make = make
        self.first, self.made = 0, np.empty((0, 0, 0), np.float32)

    def __getitem__(self, number: int) -> NDArray[np.float32]:
        """Return one piece, shape (axis, time); none before those that were made last."""
        if number >= self.first + len(self.made):
            self.first += len(self.made)
            self.made = self.make(self.first, min(max(1, self.first), AT_ONCE))
        piece: NDArray[np.float32] = self.made[number - self.first]
        return piece


def drawn(
    first: int, count: int, config: Config, *, axes: int, given: Tensor | None, seed: int
) -> tuple[Tensor, Tensor]:
    """Return latents, (piece, latent), and white noise, (piece, axis, time), of pieces ``first`` and on.

    Each piece has seeds of its own. ``given``, shape (latent,), is the latent of piece 0 where there is one.
    """
    latents, noises = [], []
    for number in range(first, first + count):
        rng = child_rng(seed, "latent", number)
        latent = torch.from_numpy(rng.uniform(-1, 1, config.latents).astype(np.float32))
        latents.append(given if number == 0 and given is not None else latent)
        generator = child_generator(seed, "noise", number)
        noises.append(white_noise(1, axes, config.length, generator=generator))
    return torch.stack(latents), torch.cat(noises)


def given_latent(condition: Condition, config: Config) -> Tensor | None:
    """Return the ``latent`` that was asked for, float32, shape (latent,); None where none was.

    Raises
    ------
    ParameterError
        If it has another shape, or a number outside of -1 to 1.
    """
    given = condition.get("latent")
    if given is None:
        return None
    latent = np.asarray(given, np.float32)
    if latent.shape != (config.latents,) or not (np.abs(latent) <= 1).all():
        raise ParameterError(f"latent must be {config.latents} numbers in -1 to 1, got shape {latent.shape}")
    return torch.from_numpy(latent)
