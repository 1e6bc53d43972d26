"""Surfaces that a run knows, by material or mix, photograph, recording or words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.features.photo_classifier import PhotoClassifier
from tactogram.model import Condition, Example, SignalKind, material_weights, unit_scores
from tactogram.models.texture_flow.rated_words import word_weights
from tactogram.models.texture_flow.surface_prediction import Strokes, SurfacePredictor
from tactogram.models.texture_flow.surfaces import Surface, SurfaceSpectra
from tactogram.models.texture_flow.tonal_surfaces import StrokeTones, TonalSurface, split_signals
from tactogram.nn.bare_and_fixed import bare
from tactogram.nn.labels import NUMBERS, Labels
from tactogram.signal import Signal
from tactogram.signal.local_amplitudes import local_quantiles
from tactogram.signal.tones import no_tones

DESCRIPTIONS = ("material", "image", "vibration", "words")
"""Conditions that describe a surface, of which one is needed."""
OF_THE_VIBRATION = ("vibration_speed_mm_s", "vibration_force_n")
DescribedSurface = Callable[[Condition], tuple[TonalSurface, Condition | None]]
"""The surface at a speed and force, and those of the one stroke that it was measured from or predicted for."""


class KnownSurfaces:
    """Surfaces of the materials, and those of photographs, recordings and words."""

    def __init__(
        self, kind: SignalKind, spectra: SurfaceSpectra, labels: Labels, predictor: SurfacePredictor | None
    ) -> None:
        self.kind, self.spectra, self.labels = kind, spectra, labels
        self.surfaces: list[Surface] = []
        """Of each material, measured from all its recordings."""
        self.strokes: Strokes | None = None
        """Of each material, from which its surface is predicted at any speed and force, if one is."""
        self.tones: list[list[StrokeTones]] = []
        """Of some strokes of each material; not in `surfaces` or `strokes`, which are measured without them."""
        self.local: list[NDArray[np.float64]] = []
        """Of each material, the quantiles of `local_of`, if known."""
        self.rated = np.full((len(kind.materials), len(kind.words)), np.nan)
        """Mean scores of each material, 0 to 1, shape (material, word); NaN if unknown."""
        self.photographs = PhotoClassifier(kind.materials)
        self.predictor: Any = predictor

    def described(self, condition: Condition, *, draw: float) -> DescribedSurface:
        """Return the surface that a condition describes, at any speed and force.

        ``draw``, from 0 to below 1, chooses a stroke of each material, whose tones it has.
        """
        given = [name for name in DESCRIPTIONS if condition.get(name) is not None]
        if not given:
            first, *others = self.descriptions
            instead = f", or {' or '.join(others)} instead" if others else ""
            raise ParameterError(f"condition {first!r} is needed{instead}")
        if len(given) > 1:
            raise ParameterError(
                f"conditions {' and '.join(given)} describe the surface twice; give one of them"
            )
        [description] = given
        if description not in self.descriptions:
            raise ParameterError(self._not_learned(description))
        measured = self._measured_at(condition)
        if description == "vibration":
            vibration = condition["vibration"]
            self.kind.check(vibration)
            return self._of_vibration(vibration, measured)
        if description == "words":
            return self._from_words(condition, draw)
        weights = (
            self.photographs.probabilities(condition["image"])
            if description == "image"
            else material_weights(condition, self.kind.materials)
        )
        return partial(self._of_materials, weights, draw)

    @property
    def descriptions(self) -> tuple[str, ...]:
        """Those of `DESCRIPTIONS` that were learned."""
        known = {
            "material": bool(self.kind.materials),
            "image": self.photographs.fitted,
            "words": bool(self.kind.words)
            and (self.predictor is not None or bool(np.isfinite(self.rated).any())),
        }
        return tuple(name for name in DESCRIPTIONS if known.get(name, True))

    def _not_learned(self, description: str) -> str:
        """Return a refusal that says what to give instead of a description that was not learned."""
        instead = " or ".join(self.descriptions)
        if description == "image":
            instead = instead.replace("material", "material (by name, or a text that describes it)")
            instead += ", or train on recordings with photographs of two materials or more"
        return f"condition {description!r} was not learned by this run; give {instead}"

    def rate(self, members: Sequence[Sequence[Example]]) -> None:
        """Take over the scores of the examples of each material."""
        for row, examples in zip(self.rated, members, strict=True):
            if self.kind.words and (means := [e.rated.means for e in examples if e.rated is not None]):
                row[:] = np.mean(means, axis=0)

    def _of_materials(
        self, weights: NDArray[np.float64], draw: float, condition: Condition
    ) -> tuple[TonalSurface, Condition | None]:
        chosen = np.flatnonzero(weights).tolist()
        if self.strokes is None:
            surfaces = [self._with_tones(self.surfaces[number], number, draw, condition) for number in chosen]
            return TonalSurface.mixed(surfaces, weights[chosen]), None
        predictor = bare(self.predictor)
        wanted = predictor.conditions_of(condition)
        predicted = [
            predictor.from_strokes(*self.strokes.of_material(number), wanted, self._like(number))
            for number in chosen
        ]
        surfaces = [
            self._with_tones(surface, number, draw, condition)
            for surface, number in zip(predicted, chosen, strict=True)
        ]
        return TonalSurface.mixed(surfaces, weights[chosen]), _speed_and_force(condition)

    def _with_tones(self, surface: Surface, material: int, draw: float, condition: Condition) -> TonalSurface:
        """Return a material's surface with the tones of one of its strokes, if any, at the speed of a condition."""
        scale, patterns = self.spectra.variance, self.tones[material] if self.tones else []
        local = self.local[material] if self.local else None
        if not patterns:
            return TonalSurface(surface, no_tones(len(surface.mean)), scale, local)
        speed = self._speed(condition, self.predictor is not None)
        tones = patterns[int(draw * len(patterns))].at(speed, scale * float(surface.power), self.kind.rate)
        return TonalSurface(surface, tones, scale, local)

    def _speed(self, condition: Condition, median: bool) -> float | None:
        """Return the speed of a condition, limited as in the label; if it has none, the ``median`` or None."""
        known, speed = self.labels.ranges.get("speed_mm_s"), condition.get("speed_mm_s")
        if known is None or (speed is None and not median):
            return None
        return known.median if speed is None else min(max(float(speed), known.least), known.most)

    def _like(self, material: int) -> Surface:
        """Return a surface of the material's mean, 0 if it is not known."""
        return self.surfaces[material] if self.surfaces else self.spectra.blank(len(self.kind.axes))

    def _from_words(self, condition: Condition, draw: float) -> DescribedSurface:
        scores = unit_scores(condition["words"], self.kind, partial=True)
        if self.predictor is None:
            return partial(self._of_materials, word_weights(self.rated, scores), draw)
        like, words = self.spectra.blank(len(self.kind.axes)), torch.from_numpy(scores).float()
        tones = no_tones(len(self.kind.axes))
        local = np.mean(self.local, axis=0) if self.local else None

        def at(wanted: Condition) -> tuple[TonalSurface, Condition]:
            surface = self.predictor.from_words(words, self.predictor.conditions_of(wanted), like)
            return TonalSurface(surface, tones, self.spectra.variance, local), _speed_and_force(wanted)

        return at

    def _of_vibration(self, vibration: Signal, measured: Condition) -> DescribedSurface:
        patterns, noise = split_signals([vibration])
        own = self.measured("the vibration", noise)
        scale, speed = self.spectra.variance, measured.get("speed_mm_s")
        local = self.local_of(noise)
        tones = patterns[0] if patterns else no_tones(len(self.kind.axes))
        known = StrokeTones(tones, np.nan if speed is None else float(speed), scale * float(own.power))

        def at(wanted: Condition) -> tuple[TonalSurface, Condition]:
            surface, reached = self._at(own, measured, wanted)
            moved = known.at(self._speed(wanted, False), scale * float(surface.power), self.kind.rate)
            return TonalSurface(surface, moved, scale, local), reached

        return at

    def _measured_at(self, condition: Condition) -> Condition:
        """Return speed and force of a given vibration, without those unknown."""
        found = {
            name: condition[f"vibration_{name}"]
            for name in NUMBERS
            if condition.get(f"vibration_{name}") is not None
        }
        if found and condition.get("vibration") is None:
            raise ParameterError(f"vibration_{next(iter(found))} is of a vibration, and none is given")
        self.labels.check(found)
        return found

    def _at(self, surface: Surface, measured: Condition, wanted: Condition) -> tuple[Surface, Condition]:
        """Return a surface at the speed and force wanted, if these can be predicted, and the condition it is at."""
        if self.predictor is None:
            return surface, measured
        predictor = bare(self.predictor)
        at, to = predictor.conditions_of(measured), predictor.conditions_of(wanted)
        if to.isnan().all():
            return surface, measured
        known = {name: value for name, value in wanted.items() if value is not None}
        return predictor.predict(surface, at, to), {**measured, **known}

    def local_of(self, signals: Sequence[Signal]) -> NDArray[np.float64] | None:
        """Return the local amplitudes of signals without tones, None over displacement."""
        if self.kind.domain != "time":
            return None
        centred = [signal.samples - signal.samples.mean(1, keepdims=True) for signal in signals]
        return local_quantiles(centred, self.kind.rate)

    def measured(self, name: str, signals: Sequence[Signal]) -> Surface:
        """Return the surface of signals, refused in the ``name`` of what they are if all are too short."""
        surface = self.spectra.measure(signals)
        if surface is None:
            raise ParameterError(
                f"recordings must have at least {self.spectra.samples(2)} samples, got none of {name}; "
                f"shorten config.{self.spectra.window}"
            )
        return surface

    def state(self) -> dict[str, Any]:
        """Return the arrays."""
        return {
            "surfaces": [surface._asdict() for surface in self.surfaces],
            "strokes": None if self.strokes is None else self.strokes.state(),
            "tones": [[tones.state() for tones in patterns] for patterns in self.tones],
            "local": self.local,
            "rated": self.rated,
            "photographs": self.photographs.state(),
            "predictor": None if self.predictor is None else self.predictor.state_dict(),
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Continue from `state`."""
        self.surfaces = [Surface(**stored) for stored in state["surfaces"]]
        stored = state.get("strokes")
        self.strokes = Strokes.from_state(stored) if stored else None
        self.tones = [
            [StrokeTones.from_state(each) for each in patterns] for patterns in state.get("tones", [])
        ]
        self.local = [np.asarray(each, np.float64) for each in state.get("local", [])]
        self.rated = np.asarray(state.get("rated", self.rated), np.float64)
        self.photographs.load_state(state["photographs"])
        if self.predictor is not None:
            self.predictor.load_state_dict(state["predictor"])
            self.predictor.eval()


def _speed_and_force(condition: Condition) -> Condition:
    return {name: condition.get(name) for name in NUMBERS}
