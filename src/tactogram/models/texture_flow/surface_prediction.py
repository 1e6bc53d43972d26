"""A surface at a speed and a force that it was not measured at, from one stroke of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.model import Condition
from tactogram.models.texture_flow.surfaces import LEAST_DEVIATION, Surface

HIDDEN = 256
DROPOUT = 0.1
LEAST_SPREAD = 1e-3
"""Least standard deviation that a measurement is divided by."""
UNKNOWN = 0.3
"""Share of the strokes whose speed, or force, is not told in training."""
REACH = 0.8
"""Distance between two strokes, in standard deviations of the logarithms of speed and force, over which a measurement
counts for more than its prediction."""


class StrokePair(NamedTuple):
    """Strokes of surfaces, from which those of others are to be predicted.

    Attributes
    ----------
    given, wanted : float32 tensors, shape (pair, number)
        Surfaces, as `vector_of` gives them.
    given_at, wanted_at : float32 tensors, shape (pair, condition)
        Their speeds and forces; NaN if unknown.
    """

    given: Tensor
    given_at: Tensor
    wanted: Tensor
    wanted_at: Tensor


def vector_of(surface: Surface) -> Tensor:
    """Return a surface without its mean as a vector, float32."""
    root = torch.view_as_real(surface.log_root).ravel()
    return torch.cat((root, surface.centre.ravel(), surface.deviation.ravel(), surface.code)).float()


def surface_of(vector: Tensor, like: Surface) -> Surface:
    """Return the surface of a vector, with the mean of another and deviations of at least `LEAST_DEVIATION`."""
    sizes = [2 * like.log_root.numel(), like.centre.numel(), like.deviation.numel(), like.code.numel()]
    root, centre, deviation, code = torch.split(vector, sizes)
    return Surface(
        like.mean,
        torch.view_as_complex(root.reshape(*like.log_root.shape, 2).contiguous()),
        centre.reshape(like.centre.shape),
        deviation.reshape(like.deviation.shape).clamp_min(LEAST_DEVIATION),
        code,
    )


class SurfacePredictor(nn.Module):
    """Predicts the principal components of a surface by a perceptron and a linear map.

    The label is the components of a stroke, its speed and force and those wanted: logarithms, standardised and limited
    to the range of the training strokes, 0 if unknown, each with a 1 if it is known.
    """

    mean: Tensor
    scale: Tensor
    basis: Tensor
    spread: Tensor
    at_mean: Tensor
    at_deviation: Tensor
    at_range: Tensor

    def __init__(self, size: int, *, components: int, conditions: Sequence[str]) -> None:
        super().__init__()
        self.conditions = tuple(conditions)
        count = len(self.conditions)
        for name, shape in (
            ("mean", (size,)), ("scale", (size,)), ("basis", (components, size)), ("spread", (components,)),
            ("at_mean", (count,)), ("at_deviation", (count,)), ("at_range", (2, count)),
        ):  # fmt: skip
            self.register_buffer(name, torch.zeros(shape))
        label = components + 4 * count
        self.linear = nn.Linear(label, components)
        self.perceptron = nn.Sequential(
            nn.Linear(label, HIDDEN), nn.SiLU(), nn.Dropout(DROPOUT),
            nn.Linear(HIDDEN, HIDDEN), nn.SiLU(), nn.Dropout(DROPOUT),
            nn.Linear(HIDDEN, components),
        )  # fmt: skip

    @torch.no_grad()
    def fit(self, vectors: Tensor, at: Tensor) -> None:
        """Measure principal components of surfaces, (stroke, number), and the range of ``at``, (stroke, condition).

        A condition that is unknown for any of them counts as unknown, or the same, for all.
        """
        self.mean.copy_(vectors.mean(0))
        self.scale.copy_(vectors.std(0, correction=0).clamp_min(LEAST_SPREAD))
        _, values, basis = torch.linalg.svd((vectors - self.mean) / self.scale, full_matrices=False)
        count = min(len(basis), len(self.basis))
        self.basis[:count], self.spread[:count] = basis[:count], values[:count] / len(vectors) ** 0.5
        logs = torch.where(at.isnan().any(0), 1.0, at).clamp_min(torch.finfo(torch.float32).tiny).log()
        self.at_mean.copy_(logs.mean(0))
        self.at_deviation.copy_(logs.std(0, correction=0).clamp_min(LEAST_SPREAD))
        self.at_range.copy_(torch.stack((logs.amin(0), logs.amax(0))))

    def conditions_of(self, condition: Condition, *, prefix: str = "") -> Tensor:
        """Return speed and force of a condition, float32, shape (condition,); NaN if unknown."""
        found = (condition.get(prefix + name) for name in self.conditions)
        return torch.tensor([torch.nan if value is None else float(value) for value in found])

    def loss(self, pair: StrokePair) -> Tensor:
        """Return the squared error of the components, weighed by their variance; some speeds and forces are hidden."""
        hidden = torch.rand(pair.given_at.shape) < UNKNOWN
        given_at = pair.given_at.masked_fill(hidden.to(pair.given_at.device), torch.nan)
        error = self._components(pair.given, given_at, pair.wanted_at) - self._coordinates(pair.wanted)
        weight = self.spread.square() / self.spread.square().mean()
        return (error.square() * weight).mean()

    @torch.no_grad()
    def predict(self, surface: Surface, at: Tensor, wanted: Tensor) -> Surface:
        """Return a surface that was measured ``at`` speed and force, at those ``wanted``; (condition,), NaN if unknown.

        What the prediction lacks of the measured stroke itself is added, the less the further it is away.
        """
        vector = vector_of(surface)[None].to(self.mean.device)
        at, wanted = (
            at[None].to(vector.device),
            torch.where(wanted.isnan(), at, wanted)[None].to(vector.device),
        )
        found = self._vectors(self._components(vector, at, wanted))
        if torch.equal(at.isfinite(), wanted.isfinite()):
            missed = vector - self._vectors(self._components(vector, at, at))
            distance = (self._standardised(wanted) - self._standardised(at)).norm(dim=1) / REACH
            found = found + torch.exp(-distance.square() / 2) * missed
        return surface_of(found[0].cpu(), surface)

    def _components(self, given: Tensor, at: Tensor, wanted: Tensor) -> Tensor:
        """Return the components of what is wanted, (pair, component), standardised."""
        known = [x.isfinite().float() for x in (at, wanted)]
        numbers = [self._standardised(x) for x in (at, wanted)]
        label = torch.cat((self._coordinates(given), *numbers, *known), 1)
        found: Tensor = self.linear(label) + self.perceptron(label)
        return found

    def _coordinates(self, vectors: Tensor) -> Tensor:
        return F.linear((vectors - self.mean) / self.scale, self.basis) / self.spread.clamp_min(LEAST_SPREAD)

    def _vectors(self, components: Tensor) -> Tensor:
        return (components * self.spread) @ self.basis * self.scale + self.mean

    def _standardised(self, at: Tensor) -> Tensor:
        logs = at.clamp_min(torch.finfo(torch.float32).tiny).log().clamp(*self.at_range)
        return ((logs - self.at_mean) / self.at_deviation).nan_to_num(0.0)
