"""Prediction of a surface at another speed and force or under another contactor, from one stroke of it or from words.

All in closed form. Real spectra hardly move with speed, they grow; so what is predicted from a stroke is the stroke
itself plus a law that is pooled over all training surfaces: for each contactor a slope of every number of a surface per
step of the conditions. (A law that depends on the stroke was learned from simulated surfaces, too, and did not hold on
real ones.) From words: the mean of a surface's components given the scores that are
known, as if both were Gaussian.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.model import Condition, contactor_number
from tactogram.models.texture_flow.surfaces import LEAST_DEVIATION, LEAST_POWER, Surface

LEAST_SPREAD = 1e-3
"""Least standard deviation that a measurement is divided by."""
REACH = 0.8
"""Distance between two strokes, in standard deviations of the logarithms of speed and force, over which the farther one
counts for less."""
LEAST_SHARE = 1e-3
"""Weight of the farthest stroke of a material, as a share of that of one at the speed and force wanted."""
RIDGE = 0.1
"""Of the law, as a share of the pairs of strokes that it is fitted to: 0.01 to 0.3 differ by 0.1 dB on real strokes."""
WORD_RIDGE = 0.1
"""Of the words, added to the variance of 1 that each score has."""
LARGEST = 2.5
"""Scores, and components of words, count at most as so many standard deviations from the mean of those in training."""


class Reference(NamedTuple):
    """A recording that a surface is measured from, and the scores of the surface, (word,), NaN if unknown."""

    id: str
    surface: Surface
    condition: Condition
    words: Tensor


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


def empty_numbers(surface: Surface, bands: Sequence[slice]) -> Tensor:
    """Return which numbers of the vector are of bins or bands without power, as above half the rate of a recording."""
    root = surface.log_root
    power = torch.linalg.eigvalsh(root).mul(2).exp().mean(1)  # K
    empty = power < 4 * LEAST_POWER * power.mean()  # K
    by_bin = empty.expand(len(surface.mean), -1)  # A, K
    by_band = torch.stack([empty[band].all() for band in bands])
    return torch.cat((
        empty.repeat_interleave(2 * root[0].numel()), by_bin.ravel(), by_bin.ravel(),
        by_band.repeat(len(surface.code) // len(bands)),
    ))  # fmt: skip


class Strokes(NamedTuple):
    """Strokes of several materials, one material after the other.

    Attributes
    ----------
    vectors : float32 tensor, shape (stroke, number)
        Their surfaces, as `vector_of` gives them.
    at : float32 tensor, shape (stroke, condition)
        Their speeds, forces and contactors; NaN if unknown.
    words : float32 tensor, shape (stroke, word)
        Scores of their surfaces, 0 to 1; NaN if unknown.
    counts : int64 tensor, shape (material,)
        Strokes of each material.
    """

    vectors: Tensor
    at: Tensor
    words: Tensor
    counts: Tensor

    @staticmethod
    def of(materials: Sequence[Sequence[Reference]], predictor: SurfacePredictor) -> Strokes:
        """Return the strokes of materials."""
        strokes = [reference for references in materials for reference in references]
        return Strokes(
            torch.stack([vector_of(stroke.surface) for stroke in strokes]),
            torch.stack([predictor.conditions_of(stroke.condition) for stroke in strokes]),
            torch.stack([stroke.words for stroke in strokes]),
            torch.tensor([len(references) for references in materials]),
        )

    def of_material(self, number: int) -> tuple[Tensor, Tensor]:
        """Return the vectors of a material's strokes, and their speeds, forces and contactors."""
        end = int(self.counts[: number + 1].sum())
        own = slice(end - int(self.counts[number]), end)
        return self.vectors[own], self.at[own]

    def pairs(self) -> tuple[Tensor, Tensor]:
        """Return the numbers of both strokes of every pair of one material, in either order."""
        first = self.counts.cumsum(0) - self.counts
        pairs = [
            begin + torch.cartesian_prod(torch.arange(count), torch.arange(count)).view(-1, 2)
            for begin, count in zip(first, self.counts.tolist(), strict=True)
        ]
        one, other = torch.cat(pairs).T
        return one[one != other], other[one != other]


class SurfacePredictor(nn.Module):
    """Principal components of surfaces, their change with the conditions, and their mean given words.

    Of speed and force logarithms count, limited to the range of the training strokes; a contactor is -1 or 1.
    """

    mean: Tensor
    scale: Tensor
    basis: Tensor
    spread: Tensor
    at_mean: Tensor
    at_deviation: Tensor
    at_range: Tensor
    law: Tensor
    told_mean: Tensor
    told_deviation: Tensor
    told_range: Tensor
    told: Tensor
    tells: Tensor

    def __init__(self, size: int, *, components: int, conditions: Sequence[str], words: int = 0) -> None:
        super().__init__()
        self.conditions = tuple(conditions)
        count = len(self.conditions)
        told = count + words
        for name, shape in (
            ("mean", (size,)), ("scale", (size,)), ("basis", (components, size)), ("spread", (components,)),
            ("at_mean", (count,)), ("at_deviation", (count,)), ("at_range", (2, count)), ("law", (2 * count, size)),
            ("told_mean", (told,)), ("told_deviation", (told,)), ("told_range", (2, told)), ("told", (told, told)),
            ("tells", (told, components)),
        ):  # fmt: skip
            self.register_buffer(name, torch.zeros(shape))

    @torch.no_grad()
    def fit(self, strokes: Strokes) -> None:
        """Measure components, law and words of strokes.

        A condition that is unknown for any of them counts as unknown, or the same, for all.
        """
        vectors, conditions, words = strokes.vectors, strokes.at, strokes.words
        self.mean.copy_(vectors.mean(0))
        self.scale.copy_(vectors.std(0, correction=0).clamp_min(LEAST_SPREAD))
        _, values, basis = torch.linalg.svd((vectors - self.mean) / self.scale, full_matrices=False)
        count = min(len(basis), len(self.basis))
        self.basis[:count], self.spread[:count] = basis[:count], values[:count] / len(vectors) ** 0.5
        numbers = self._numbers(torch.where(conditions.isnan().any(0), 1.0, conditions))
        self.at_mean.copy_(numbers.mean(0))
        self.at_deviation.copy_(numbers.std(0, correction=0).clamp_min(LEAST_SPREAD))
        self.at_range.copy_(torch.stack((numbers.amin(0), numbers.amax(0))))
        standardised, components = self._standardised(conditions), self._components(vectors)
        # The law: within a material, the difference of two strokes is linear in the difference of their conditions.
        # Pairs leave the material itself out; the ridge keeps conditions that hardly varied from having an effect.
        one, other = strokes.pairs()
        steps = self._steps(standardised[one], standardised[other]).double()
        gram = steps.T @ steps + RIDGE * len(one) * torch.eye(steps.shape[1], dtype=torch.float64)
        self.law.copy_(torch.linalg.solve(gram, steps.T @ (vectors[other] - vectors[one]).double()))
        rated = words.isfinite().any(1)
        if not rated.any():
            return
        # Words: components and what is told of them, conditions and scores, as if jointly Gaussian, so that the mean
        # of the components given any part of what is told is linear in it. Scores that nobody gave count as the mean.
        told = torch.cat((standardised, words), 1)[rated]
        self.told_mean.copy_(told.nanmean(0).nan_to_num(0.0))
        self.told_deviation.copy_(
            (told - self.told_mean).square().nanmean(0).sqrt().clamp_min(LEAST_SPREAD).nan_to_num(1.0)
        )
        limits = [value[rated].nan_to_num(nan) for value, nan in ((words, torch.inf), (words, -torch.inf))]
        # Linear laws are wild far out: what is told counts only as far as training went, and no rare extreme does.
        wide = standardised.amin(0), standardised.amax(0)
        reach = LARGEST * self.told_deviation
        self.told_range[0] = torch.cat((wide[0], limits[0].amin(0))).maximum(self.told_mean - reach)
        self.told_range[1] = torch.cat((wide[1], limits[1].amax(0))).minimum(self.told_mean + reach)
        told = self._told(told).nan_to_num(0.0)
        self.told.copy_(told.T @ told / len(told))
        self.tells.copy_(told.T @ components[rated] / len(told))

    def conditions_of(self, condition: Condition, *, prefix: str = "") -> Tensor:
        """Return speed, force and contactor of a condition, float32, shape (condition,); NaN if unknown."""
        values = {name: condition.get(prefix + name) for name in self.conditions}
        if (contactor := values.get("contactor")) is not None:
            values["contactor"] = contactor_number(contactor)
        return torch.tensor([torch.nan if value is None else float(value) for value in values.values()])

    def knows(self, name: str) -> bool:
        """Return whether the training strokes differ in a condition."""
        index = self.conditions.index(name)
        return bool(self.at_range[0, index] < self.at_range[1, index])

    def predict(self, surface: Surface, at: Tensor, wanted: Tensor, bands: Sequence[slice] = ()) -> Surface:
        """Return a surface that was measured ``at`` conditions, at those ``wanted``; (condition,), NaN if unknown.

        One that is unknown counts as the mean of the training strokes; one that is not wanted stays. ``bands`` are
        those of the code: bins and bands without power stay so.
        """
        empty = empty_numbers(surface, bands) if bands else None
        return surface_of(self._predicted(vector_of(surface)[None], at[None], wanted, empty)[0], surface)

    @torch.no_grad()
    def _predicted(self, vectors: Tensor, at: Tensor, wanted: Tensor, empty: Tensor | None = None) -> Tensor:
        """Return surfaces, (stroke, number), measured ``at`` (stroke, condition), at those ``wanted``, (condition,)."""
        wanted = torch.where(wanted.isnan(), at, wanted)
        change = self._steps(self._standardised(at), self._standardised(wanted)) @ self.law
        return vectors + (change if empty is None else change.masked_fill(empty, 0.0))

    def from_strokes(self, vectors: Tensor, at: Tensor, wanted: Tensor, like: Surface) -> Surface:
        """Return the mean of a material's surfaces predicted from each of its strokes, the nearest counting most.

        ``vectors``, (stroke, number), were measured ``at`` conditions, (stroke, condition). ``wanted`` and ``like`` are
        as for `from_words`.
        """
        wanted = self._or_usual(wanted)
        distance = (self._standardised(at) - self._standardised(wanted)).norm(dim=1) / REACH
        weights = torch.exp(-distance.square() / 2).clamp_min(LEAST_SHARE)
        predicted = [surface_of(vector, like) for vector in self._predicted(vectors, at, wanted)]
        return Surface.mixed(predicted, weights.double().numpy())

    @torch.no_grad()
    def from_words(self, words: Tensor, wanted: Tensor, like: Surface) -> Surface:
        """Return the surface of scores, (word,), 0 to 1, at conditions, (condition,), the usual ones if NaN.

        Unknown scores are NaN; others are limited to those of the training surfaces. ``like`` is any surface of as many
        axes and bins, without a mean.
        """
        told = torch.cat((self._standardised(self._or_usual(wanted)), words))
        # Gaussian regression on what is known: E[c|t] = C_ct (C_tt + ridge)^-1 t; the unknown is left out.
        known = told.isfinite()
        told = self._told(told.clamp(*self.told_range))[known]
        cause = self.told[known][:, known]
        weights = torch.linalg.solve(cause + WORD_RIDGE * torch.eye(len(cause)), told)
        components = (weights @ self.tells[known]).clamp(-LARGEST, LARGEST)
        return surface_of((components * self.spread) @ self.basis * self.scale + self.mean, like)

    def _told(self, told: Tensor) -> Tensor:
        return (told - self.told_mean) / self.told_deviation

    def _steps(self, start: Tensor, end: Tensor) -> Tensor:
        """Return the steps from conditions to others, (pair, condition), and these times the first ones' contactor."""
        # Contactors are -1 and 1: with the products, each contactor has a slope of its own.
        step, index = end - start, self.conditions.index("contactor")
        return torch.cat((step, step * start[:, index, None]), 1)

    def _or_usual(self, conditions: Tensor) -> Tensor:
        """Return conditions, for those not given the mean, and the finger if there are several contactors.

        One that training did not vary stays unknown.
        """
        varied = self.at_range[0] < self.at_range[1]
        usual = torch.tensor([
            -1.0 if name == "contactor" else mean.exp().item()
            for name, mean in zip(self.conditions, self.at_mean, strict=True)
        ])  # fmt: skip
        return torch.where(conditions.isnan() & varied, usual, conditions)

    def _components(self, vectors: Tensor) -> Tensor:
        """Return the components of surfaces, standardised."""
        return F.linear((vectors - self.mean) / self.scale, self.basis) / self.spread.clamp_min(LEAST_SPREAD)

    def _numbers(self, conditions: Tensor) -> Tensor:
        """Return logarithms of speed and force, and contactors."""
        logs = conditions.clamp_min(torch.finfo(torch.float32).tiny).log()
        return torch.where(torch.tensor([name == "contactor" for name in self.conditions]), conditions, logs)

    def _standardised(self, conditions: Tensor) -> Tensor:
        low, high = self.at_range
        limited = self._numbers(conditions).clamp(low, high)
        standardised: Tensor = ((limited - self.at_mean) / self.at_deviation).nan_to_num(0.0)
        return standardised
