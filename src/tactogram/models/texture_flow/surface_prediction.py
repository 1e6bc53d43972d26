"""Prediction of a surface at any speed and force, from one stroke of it or from scores of words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
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
WITHOUT_STROKE = 0.4
"""Share of the surfaces that are predicted from words alone in training, if there are words."""
REACH = 0.8
"""Distance between two strokes, in standard deviations of the logarithms of speed and force, over which a measurement
counts for more than its prediction."""


LEAST_SHARE = 1e-3
"""Weight of the farthest stroke of a material, as a share of that of one at the speed and force wanted."""


class Reference(NamedTuple):
    """A recording that a surface is measured from, and the scores of the surface, (word,), NaN if unknown."""

    id: str
    surface: Surface
    condition: Condition
    words: Tensor


class StrokePair(NamedTuple):
    """Strokes of surfaces, from which those of others are to be predicted.

    Attributes
    ----------
    given, wanted : float32 tensors, shape (pair, number)
        Surfaces, as `vector_of` gives them.
    given_at, wanted_at : float32 tensors, shape (pair, condition)
        Their speeds and forces; NaN if unknown.
    words : float32 tensor, shape (pair, word)
        Scores of the surface, 0 to 1; NaN if unknown.
    """

    given: Tensor
    given_at: Tensor
    wanted: Tensor
    wanted_at: Tensor
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


class Strokes:
    """Strokes of several materials, one material after the other.

    Attributes
    ----------
    vectors : float32 tensor, shape (stroke, number)
        Their surfaces, as `vector_of` gives them.
    at : float32 tensor, shape (stroke, condition)
        Their speeds and forces; NaN if unknown.
    words : float32 tensor, shape (stroke, word)
        Scores of their surfaces, 0 to 1; NaN if unknown.
    counts : int64 tensor, shape (material,)
        Strokes of each material.
    """

    def __init__(self, vectors: Tensor, at: Tensor, words: Tensor, counts: Tensor) -> None:
        self.vectors, self.at, self.words, self.counts = vectors, at, words, counts

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
        """Return the vectors of a material's strokes, and their speeds and forces."""
        end = int(self.counts[: number + 1].sum())
        own = slice(end - int(self.counts[number]), end)
        return self.vectors[own], self.at[own]

    def pairs(self, count: int, rng: np.random.Generator) -> StrokePair:
        """Return pairs of strokes of one material each, which may be the same stroke."""
        counts = self.counts.numpy()
        material = rng.integers(len(counts), size=count)
        first = np.cumsum(counts) - counts
        given, wanted = (torch.from_numpy(first[material] + rng.integers(counts[material])) for _ in range(2))
        return StrokePair(
            self.vectors[given], self.at[given], self.vectors[wanted], self.at[wanted], self.words[wanted]
        )

    def state(self) -> dict[str, Any]:
        """Return the arrays."""
        return {name: getattr(self, name) for name in ("vectors", "at", "words", "counts")}

    @staticmethod
    def from_state(state: Mapping[str, Any]) -> Strokes:
        """Return strokes from `state`."""
        return Strokes(**state)


class SurfacePredictor(nn.Module):
    """Predicts the principal components of a surface by a perceptron and a linear map.

    The label is the components of a stroke, its speed and force and those wanted (logarithms, limited to the range of
    the training strokes) and the scores of words: standardised, 0 if unknown, each with a 1 if it is known.
    """

    mean: Tensor
    scale: Tensor
    basis: Tensor
    spread: Tensor
    at_mean: Tensor
    at_deviation: Tensor
    at_range: Tensor
    word_mean: Tensor
    word_deviation: Tensor

    def __init__(self, size: int, *, components: int, conditions: Sequence[str], words: int = 0) -> None:
        super().__init__()
        self.conditions = tuple(conditions)
        count = len(self.conditions)
        for name, shape in (
            ("mean", (size,)), ("scale", (size,)), ("basis", (components, size)), ("spread", (components,)),
            ("at_mean", (count,)), ("at_deviation", (count,)), ("at_range", (2, count)),
            ("word_mean", (words,)), ("word_deviation", (words,)),
        ):  # fmt: skip
            self.register_buffer(name, torch.zeros(shape))
        label = components + 1 + 4 * count + 2 * words
        self.linear = nn.Linear(label, components)
        self.perceptron = nn.Sequential(
            nn.Linear(label, HIDDEN), nn.SiLU(), nn.Dropout(DROPOUT),
            nn.Linear(HIDDEN, HIDDEN), nn.SiLU(), nn.Dropout(DROPOUT),
            nn.Linear(HIDDEN, components),
        )  # fmt: skip

    @torch.no_grad()
    def fit(self, vectors: Tensor, at: Tensor, words: Tensor) -> None:
        """Measure principal components of surfaces, (stroke, number), and the range of ``at``, (stroke, condition).

        A condition that is unknown for any of them counts as unknown, or the same, for all. ``words`` are scores,
        (stroke, word), of which some may be NaN.
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
        self.word_mean.copy_(words.nanmean(0).nan_to_num(0.0))
        self.word_deviation.copy_((words - self.word_mean).square().nanmean(0).sqrt().nan_to_num(0.0))

    def conditions_of(self, condition: Condition, *, prefix: str = "") -> Tensor:
        """Return speed and force of a condition, float32, shape (condition,); NaN if unknown."""
        found = (condition.get(prefix + name) for name in self.conditions)
        return torch.tensor([torch.nan if value is None else float(value) for value in found])

    def loss(self, pair: StrokePair) -> Tensor:
        """Return the squared error of the components, weighed by their variance.

        Some speeds and forces are hidden; so are some words, and where any is known, some strokes.
        """
        device = pair.given.device
        hidden = (torch.rand(pair.given_at.shape) < UNKNOWN).to(device)
        some = torch.rand(pair.words.shape) < torch.rand(len(pair.words), 1)
        words = pair.words.masked_fill(some.to(device), torch.nan)
        alone = (torch.rand(len(words)) < WITHOUT_STROKE).to(device) & words.isfinite().any(1)
        found = self._components(
            self._coordinates(pair.given),
            ~alone,
            pair.given_at.masked_fill(hidden, torch.nan),
            pair.wanted_at,
            words,
        )
        weight = self.spread.square() / self.spread.square().mean()
        return ((found - self._coordinates(pair.wanted)).square() * weight).mean()

    def predict(self, surface: Surface, at: Tensor, wanted: Tensor) -> Surface:
        """Return a surface that was measured ``at`` speed and force, at those ``wanted``; (condition,), NaN if unknown.

        What the prediction lacks of the measured stroke itself is added, the less the further it is away.
        """
        return surface_of(self._predicted(vector_of(surface)[None], at[None], wanted)[0], surface)

    @torch.no_grad()
    def _predicted(self, vectors: Tensor, at: Tensor, wanted: Tensor) -> Tensor:
        """Return surfaces, (stroke, number), measured ``at`` (stroke, condition), at those ``wanted``, (condition,)."""
        device = self.mean.device
        wanted = torch.where(wanted.isnan(), at, wanted).to(device)
        vectors, at = vectors.to(device), at.to(device)
        stroke, unknown = self._coordinates(vectors), self.word_mean.expand(len(at), -1) * torch.nan
        given = torch.ones(len(at), dtype=torch.bool, device=device)
        found = self._vectors(self._components(stroke, given, at, wanted, unknown))
        missed = vectors - self._vectors(self._components(stroke, given, at, at, unknown))
        distance = (self._standardised(wanted) - self._standardised(at)).norm(dim=1) / REACH
        nearness = torch.exp(-distance.square() / 2) * (at.isfinite() == wanted.isfinite()).all(1)
        return (found + nearness[:, None] * missed).cpu()

    def from_strokes(self, vectors: Tensor, at: Tensor, wanted: Tensor, like: Surface) -> Surface:
        """Return the mean of a material's surfaces predicted from each of its strokes, the nearest counting most.

        ``vectors``, (stroke, number), were measured ``at`` speeds and forces, (stroke, condition). ``wanted`` and
        ``like`` are as for `from_words`.
        """
        wanted = self._or_median(wanted)
        distance = (self._standardised(at) - self._standardised(wanted)).norm(dim=1) / REACH
        weights = torch.exp(-distance.square() / 2).clamp_min(LEAST_SHARE)
        found = [surface_of(vector, like) for vector in self._predicted(vectors, at, wanted)]
        return Surface.mixed(found, weights.double().numpy())

    @torch.no_grad()
    def from_words(self, words: Tensor, wanted: Tensor, like: Surface) -> Surface:
        """Return the surface of scores, (word,), 0 to 1, at speed and force, (condition,), medians if NaN.

        Unknown scores are NaN. ``like`` is any surface of as many axes and bins, without a mean.
        """
        device = self.mean.device
        wanted = self._or_median(wanted)[None].to(device)
        nothing = torch.zeros(1, len(self.spread), device=device)
        given = torch.zeros(1, dtype=torch.bool, device=device)
        unknown = torch.full_like(wanted, torch.nan)
        found = self._components(nothing, given, unknown, wanted, words[None].to(device))
        return surface_of(self._vectors(found)[0].cpu(), like)

    def _components(self, stroke: Tensor, given: Tensor, at: Tensor, wanted: Tensor, words: Tensor) -> Tensor:
        """Return the components of what is wanted, (pair, component), standardised.

        ``stroke`` are those of what is given, where ``given``, (pair,), is true; elsewhere it is unknown, ``at`` too.
        """
        at = at.masked_fill(~given[:, None], torch.nan)
        scores = (words - self.word_mean) / self.word_deviation.clamp_min(LEAST_SPREAD)
        label = torch.cat(
            (
                stroke * given[:, None], given[:, None],
                self._standardised(at), self._standardised(wanted), at.isfinite(), wanted.isfinite(),
                scores.nan_to_num(0.0), words.isfinite(),
            ),
            1,
        )  # fmt: skip
        found: Tensor = self.linear(label) + self.perceptron(label)
        return found

    def _or_median(self, wanted: Tensor) -> Tensor:
        """Return a speed and force with medians for those not given; one that training did not vary stays unknown."""
        varied = (self.at_range[0] < self.at_range[1]).cpu()
        return torch.where(wanted.isnan() & varied, self.at_mean.exp().cpu(), wanted)

    def _coordinates(self, vectors: Tensor) -> Tensor:
        return F.linear((vectors - self.mean) / self.scale, self.basis) / self.spread.clamp_min(LEAST_SPREAD)

    def _vectors(self, components: Tensor) -> Tensor:
        return (components * self.spread) @ self.basis * self.scale + self.mean

    def _standardised(self, at: Tensor) -> Tensor:
        low, high, mean, deviation = (
            value.to(at.device) for value in (*self.at_range, self.at_mean, self.at_deviation)
        )
        logs = at.clamp_min(torch.finfo(torch.float32).tiny).log().clamp(low, high)
        found: Tensor = ((logs - mean) / deviation).nan_to_num(0.0)
        return found
