"""Surfaces that a run knows, by material or mix, photograph, recording or words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.model import Condition, Example, SignalKind, contactor_number, material_weights, unit_scores
from tactogram.models.texture_flow.described_surfaces import DescribedSurfaces, Prediction, word_weights
from tactogram.models.texture_flow.surface_prediction import Strokes, SurfacePredictor
from tactogram.models.texture_flow.surfaces import LEAST_DEVIATION, Surface, SurfaceSpectra
from tactogram.models.texture_flow.tonal_surfaces import StrokeTones, TonalSurface, split_signals
from tactogram.nn.labels import NUMBERS, Labels
from tactogram.signal import Signal
from tactogram.signal.local_amplitudes import local_quantiles
from tactogram.signal.tones import no_tones

DESCRIPTIONS = ("material", "image", "text", "vibration", "words")
"""Conditions that describe a surface, of which one is needed; photograph, text and words may go together."""
TONAL = 0.5
"""Weight from which a predicted surface has the tones of a material; it has none that it shares with others."""
OF_THE_VIBRATION = ("vibration_speed_mm_s", "vibration_force_n", "vibration_contactor")
CONDITIONS_OF_A_STROKE = (*NUMBERS, "contactor")


class SurfaceSource(Protocol):
    """Source of a surface: a material or mix, words, or a recording."""

    def at(self, condition: Condition) -> tuple[TonalSurface, Condition | None]:
        """Return the surface at a speed and force, and those that the result is for.

        These are None if it is the mean of strokes at any speed and force, not of one or predicted for one.
        """


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
        self.described_by = DescribedSurfaces(kind.materials)
        self.predictor = predictor

    def described(self, condition: Condition, *, draw: float) -> SurfaceSource:
        """Return what a condition describes, whose surface is known at any speed and force.

        ``draw``, from 0 to below 1, chooses a stroke of each material, whose tones it has.
        """
        names = [name for name in DESCRIPTIONS if condition.get(name) is not None]
        if (prediction := self.prediction(condition)) is not None:
            return MaterialMix(self, prediction[0], draw, predicted=True)
        if not names:
            first, *others = self._named
            instead = f", or {' or '.join(others)} instead" if others else ""
            raise ParameterError(f"condition {first!r} is needed{instead}")
        if unknown := [name for name in names if name not in self.descriptions]:
            raise ParameterError(self._not_learned(unknown[0]))
        if len(names) > 1:
            raise ParameterError(
                f"conditions {' and '.join(names)} describe the surface twice; give one of them"
            )
        [description] = names
        stroke = self._stroke_of_vibration(condition)
        if description == "vibration":
            self.kind.check(condition["vibration"])
            return RecordedSurface.of(self, condition["vibration"], stroke)
        if description == "words":
            scores = unit_scores(condition["words"], self.kind, partial=True)
            if self.predictor is not None:
                return RatedSurface(self, self.predictor, torch.from_numpy(scores).float())
            return MaterialMix(self, word_weights(self.rated, scores), draw)
        return MaterialMix(self, material_weights(condition, self.kind.materials), draw)

    def prediction(self, condition: Condition) -> Prediction | None:
        """Return the prediction from a photograph or a text or both, and words with them; None of anything else."""
        names = {name for name in DESCRIPTIONS if condition.get(name) is not None}
        if not (names & {"image", "text"} and names <= {"image", "text", "words"} & {*self.descriptions}):
            return None
        scores = unit_scores(condition.get("words") or {}, self.kind, partial=True)
        return self.described_by.predict(condition.get("image"), condition.get("text"), self.rated, scores)

    @property
    def scores(self) -> NDArray[np.float64]:
        """Scores, 0 to 1, shape (row, word), between whose extremes words were learned."""
        return (
            self.rated
            if self.predictor is None
            else self.predictor.told_range[:, len(self.predictor.conditions) :].numpy()
        )

    @property
    def descriptions(self) -> tuple[str, ...]:
        """Those of `DESCRIPTIONS` that were learned."""
        known = {
            "material": bool(self.kind.materials),
            "image": len(self.described_by.shown) > 0,
            "text": self.described_by.spectra.size > 0,
            "words": bool(self.kind.words)
            and (self.predictor is not None or bool(np.isfinite(self.rated).any())),
        }
        return tuple(name for name in DESCRIPTIONS if known.get(name, True))

    @property
    def _named(self) -> list[str]:
        """Names of `descriptions` for messages; a text counts as a material."""
        return [name for name in self.descriptions if name != "text"]

    def _not_learned(self, description: str) -> str:
        """Return a refusal that says what to give instead of a description that was not learned."""
        instead = " or ".join(self._named)
        if description == "image":
            instead = instead.replace("material", "material (by name, or a text that describes it)")
            instead += ", or train on recordings with photographs of two materials or more"
        return f"condition {description!r} was not learned by this run; give {instead}"

    def check_contactors(self, condition: Condition) -> None:
        """Refuse a contactor that is no finger or stylus, or was not learned."""
        for name in ("contactor", "vibration_contactor"):
            contactor = condition.get(name)
            if contactor is None:
                continue
            if math.isnan(contactor_number(str(contactor))):
                raise ParameterError(f"{name} must be finger or stylus, got {contactor!r}")
            if self.predictor is None or not self.predictor.knows("contactor"):
                raise ParameterError(
                    f"{name} makes no difference to this run, whose recordings have one or none; omit it"
                )

    def rate(self, members: Sequence[Sequence[Example]]) -> None:
        """Take over the scores of the examples of each material."""
        for row, examples in zip(self.rated, members, strict=True):
            if self.kind.words and (means := [e.rated.means for e in examples if e.rated is not None]):
                row[:] = np.mean(means, axis=0)

    def with_tones(self, surface: Surface, material: int, draw: float, condition: Condition) -> TonalSurface:
        """Return a material's surface with the tones of one of its strokes, if any, at the speed of a condition."""
        scale, patterns = self.spectra.variance, self.tones[material] if self.tones else []
        local = self.local[material] if self.local else None
        if not patterns:
            return TonalSurface(surface, no_tones(len(surface.mean)), scale, local)
        # A predicted surface is one at the usual speed where none is wanted; a measured one keeps the tones' own.
        speed = self.speed_of(condition, or_median=self.predictor is not None)
        tones = patterns[int(draw * len(patterns))].at(speed, scale * float(surface.power), self.kind.rate)
        return TonalSurface(surface, tones, scale, local)

    def speed_of(self, condition: Condition, *, or_median: bool) -> float | None:
        """Return the speed of a condition, limited as in the label; without one, the median of training or None."""
        learned, speed = self.labels.ranges.get("speed_mm_s"), condition.get("speed_mm_s")
        if learned is None or (speed is None and not or_median):
            return None
        return learned.median if speed is None else min(max(float(speed), learned.least), learned.most)

    def _stroke_of_vibration(self, condition: Condition) -> Condition:
        """Return speed, force and contactor of a given vibration, without those unknown."""
        stroke = {
            name: condition[f"vibration_{name}"]
            for name in CONDITIONS_OF_A_STROKE
            if condition.get(f"vibration_{name}") is not None
        }
        if stroke and condition.get("vibration") is None:
            raise ParameterError(f"vibration_{next(iter(stroke))} is of a vibration, and none is given")
        self.labels.check(stroke)
        return stroke

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
            raise ParameterError.must(
                "recordings",
                f"have at least {self.spectra.samples(2)} samples, got none of {name}; "
                f"shorten config.{self.spectra.window}",
            )
        return surface

    def state(self) -> dict[str, Any]:
        """Return the arrays."""
        return {
            "surfaces": [surface._asdict() for surface in self.surfaces],
            "strokes": None if self.strokes is None else self.strokes._asdict(),
            "tones": [[tones.state() for tones in patterns] for patterns in self.tones],
            "local": self.local,
            "rated": self.rated,
            "described": self.described_by.state(),
            "predictor": None if self.predictor is None else self.predictor.state_dict(),
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Continue from `state`."""
        self.surfaces = [Surface(**stored) for stored in state["surfaces"]]
        stored = state.get("strokes")
        self.strokes = Strokes(**stored) if stored else None
        self.tones = [
            [StrokeTones.from_state(each) for each in patterns] for patterns in state.get("tones", [])
        ]
        self.local = [np.asarray(each, np.float64) for each in state.get("local", [])]
        self.rated = np.asarray(state.get("rated", self.rated), np.float64)
        if stored := state.get("described"):
            self.described_by.load_state(stored)
        if self.predictor is not None:
            self.predictor.load_state_dict(state["predictor"])


@dataclass(frozen=True, eq=False)
class MaterialMix:
    """A material, a mix of several, or the mix that a photograph, a text or words were predicted to be."""

    known: KnownSurfaces
    weights: NDArray[np.float64]
    """Shape (material,); those of a prediction may be negative."""
    draw: float
    """0 to below 1: chooses the stroke of each material whose tones the surface has."""
    predicted: bool = False

    def at(self, condition: Condition) -> tuple[TonalSurface, Condition | None]:
        known, chosen = self.known, np.flatnonzero(self.weights).tolist()
        predictor, strokes = known.predictor, known.strokes
        if strokes is None or predictor is None:
            surfaces, reached = [known.surfaces[number] for number in chosen], None
        else:
            target, reached = predictor.conditions_of(condition), _stroke_conditions(condition)
            surfaces = [
                predictor.from_strokes(
                    *strokes.of_material(number),
                    target,
                    known.surfaces[number] if known.surfaces else known.spectra.blank(len(known.kind.axes)),
                )
                for number in chosen
            ]
        tonal = [
            known.with_tones(surface, number, self.draw, condition)
            if not self.predicted or self.weights[number] >= TONAL
            else TonalSurface(surface, no_tones(len(surface.mean)), known.spectra.variance)
            for surface, number in zip(surfaces, chosen, strict=True)
        ]
        mix = TonalSurface.mixed(tonal, self.weights[chosen])
        # Negative weights can take a deviation below 0.
        deviation = mix.surface.deviation.clamp_min(LEAST_DEVIATION)
        return mix._replace(surface=mix.surface._replace(deviation=deviation)), reached


@dataclass(frozen=True, eq=False)
class RatedSurface:
    """The mean surface given scores of words. Tones are no part of what words predict."""

    known: KnownSurfaces
    predictor: SurfacePredictor
    scores: Tensor
    """0 to 1, shape (word,); NaN if not given."""

    def at(self, condition: Condition) -> tuple[TonalSurface, Condition]:
        known, axes = self.known, len(self.known.kind.axes)
        target = self.predictor.conditions_of(condition)
        surface = self.predictor.from_words(self.scores, target, known.spectra.blank(axes))
        local = np.mean(known.local, axis=0) if known.local else None
        tonal = TonalSurface(surface, no_tones(axes), known.spectra.variance, local)
        return tonal, _stroke_conditions(condition)


@dataclass(frozen=True, eq=False)
class RecordedSurface:
    """The surface of one recording: noise and tones, which are measured apart and move with the speed in other ways."""

    known: KnownSurfaces
    noise: Surface
    tones: StrokeTones
    local: NDArray[np.float64] | None
    stroke: Condition
    """Speed, force and contactor of the recording, as far as known."""

    @classmethod
    def of(cls, known: KnownSurfaces, vibration: Signal, stroke: Condition) -> RecordedSurface:
        patterns, noise = split_signals([vibration])
        surface = known.measured("the vibration", noise)
        tones = patterns[0] if patterns else no_tones(len(known.kind.axes))
        speed = stroke.get("speed_mm_s")
        level = known.spectra.variance * float(surface.power)
        own_tones = StrokeTones(tones, np.nan if speed is None else float(speed), level)
        return cls(known, surface, own_tones, known.local_of(noise), stroke)

    def at(self, condition: Condition) -> tuple[TonalSurface, Condition]:
        known, scale = self.known, self.known.spectra.variance
        surface, reached = self._noise_at(condition)
        speed = known.speed_of(condition, or_median=False)
        tones = self.tones.at(speed, scale * float(surface.power), known.kind.rate)
        return TonalSurface(surface, tones, scale, self.local), reached

    def _noise_at(self, condition: Condition) -> tuple[Surface, Condition]:
        """Return the noise at a speed and force, if it can be predicted, and the conditions that it is at."""
        predictor = self.known.predictor
        if predictor is None:
            return self.noise, self.stroke
        measured, target = predictor.conditions_of(self.stroke), predictor.conditions_of(condition)
        if target.isnan().all():
            return self.noise, self.stroke
        stated = {name: value for name, value in condition.items() if value is not None}
        surface = predictor.predict(self.noise, measured, target, self.known.spectra.bands)
        return surface, {**self.stroke, **stated}


def _stroke_conditions(condition: Condition) -> Condition:
    return {name: condition.get(name) for name in CONDITIONS_OF_A_STROKE}
