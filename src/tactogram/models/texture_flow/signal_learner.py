"""Training on crops of whitened spectra of signals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.photo_descriptor import distinct_photographs
from tactogram.features.signal_crops import SignalCrops
from tactogram.model import WHOLE_BATCH, BatchShare, Condition, Example, ImageKind, Kind, Stage
from tactogram.models import shipped_run
from tactogram.models.texture_flow.config import Config
from tactogram.models.texture_flow.image_learner import ImageFlowLearner
from tactogram.models.texture_flow.modulation import modulated
from tactogram.models.texture_flow.signal_flow import SignalFlow, rms
from tactogram.models.texture_flow.surface_prediction import Reference, Strokes, SurfacePredictor
from tactogram.models.texture_flow.tonal_surfaces import split_strokes
from tactogram.nn.labels import NUMBERS
from tactogram.training.checkpoint import load_state
from tactogram.training.seeds import child_rng

MOST_PHOTOGRAPHS = 5
"""Photographs of a material that are learned from."""
UNKNOWN = 0.3
"""Share of the crops whose speed and force are not told in training, where surfaces are predicted."""
UNSEEN_CROPS = 64
"""Crops of unseen recordings that the loss is measured on."""


class SignalFlowLearner(SignalFlow):
    """Training of a `SignalFlow`."""

    saved = ("materials", "seconds", "rms", "codes", "conditions=labels")

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        self.kind.require_materials("texture_flow")
        self.kind.check_all_present(examples)
        return Stage("fit", 1), *self.flow.stages

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if stage.name == "fit":
            yield examples
            return
        examples = modulated(self._without_tones(examples), self.config.modulated, seed=self.seed)
        measured = self._measured(examples)
        crops, size = self._crops(examples), self.config.batch_size
        for step in range(start, stage.steps):
            yield step, *self._batch(crops, measured, step, size, seed=seed, share=self.share)

    def _crops(self, examples: Sequence[Example]) -> SignalCrops:
        length = self.spectra.samples(self.config.frames)
        return SignalCrops(examples, length, overlap=self.spectra.transform.n_fft)

    def _without_tones(self, examples: Sequence[Example]) -> Sequence[Example]:
        """Return recordings without their tones; as they are, where surfaces are predicted, lines included."""
        if self.known.predictor is not None:
            return examples
        without_tones = list(examples)
        names = [str(example.material) for example in examples]
        for material in dict.fromkeys(names):
            places = [number for number, name in enumerate(names) if name == material]
            for index, rest in zip(places, split_strokes([without_tones[p] for p in places])[1], strict=True):
                without_tones[index] = rest
        return without_tones

    def _measured(self, examples: Sequence[Example]) -> dict[str, list[Reference]]:
        """Return the surface of each recording that is long enough, by material."""
        groups: dict[str, list[Reference]] = {str(example.material): [] for example in examples}
        unknown = torch.full((len(self.kind.words),), torch.nan)
        for example in examples:
            surface = self.spectra.measure([example.signal])
            if surface is not None:
                rated = example.rated if self.kind.words else None
                words = unknown if rated is None else torch.from_numpy(rated.means).float()
                groups[str(example.material)].append(Reference(example.id, surface, example.condition, words))
        return groups

    def _batch(
        self,
        crops: SignalCrops,
        measured: Mapping[str, Sequence[Reference]],
        number: int,
        count: int,
        *,
        seed: int,
        share: BatchShare = WHOLE_BATCH,
    ) -> tuple[Tensor, Tensor]:
        """Return a share of a batch: spectra of crops, (crop, axis, bin, frame), and their labels, (crop, label).

        The surface of a crop is that of its material, or of another recording of it alone; of its own recording where
        surfaces are predicted at its speed and force: as these are taken for true in use, they are in training.
        """
        rng = child_rng(seed, "references", number, *share.purpose)
        numbers = share.places(np.arange(number * count, (number + 1) * count), count)
        known = dict(zip(self.materials, self.known.surfaces, strict=True))
        spectra, labels = [], []
        for example, crop in crops.at(numbers.tolist(), partial(child_rng, seed)):
            material = str(example.material)
            reference: Condition | None = None
            condition = example.condition
            others = [candidate for candidate in measured[material] if candidate.id != example.id]
            own = [candidate for candidate in measured[material] if candidate.id == example.id]
            if self.known.predictor is not None and own:
                surface = own[0].surface
                condition = reference = {} if rng.random() < UNKNOWN else condition
            elif others and (material not in known or rng.random() < self.config.references):
                other = others[rng.integers(len(others))]
                surface, reference = other.surface, other.condition
            else:
                surface = known[material]
            spectra.append(self.spectra.encode(crop, surface))
            labels.append(self._label(surface, condition, reference))
        return torch.stack(spectra), torch.stack(labels)

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == "fit":
            return self._fit(batch)
        number, spectra, label = batch
        return {"loss": self.flow.step(stage, number, spectra, self._with_some_dropped(label))}

    def _with_some_dropped(self, label: Tensor) -> Tensor:
        """Return labels, (batch, label), of which some lack the surface, others speed and force."""
        size = 2 * len(self.labels.names)
        kept = (torch.rand(len(label), 2) >= self.config.dropped).float()
        return label * kept.repeat_interleave(torch.tensor([label.shape[1] - size, size]), dim=1)

    def _fit(self, examples: Sequence[Example]) -> dict[str, float]:
        if self.config.start:
            self._start_from(shipped_run(self.config.start) or Path(self.config.start))
        self.labels.fit(examples)
        self.spectra.lowest = self.spectra.lowest_of([example.signal for example in examples])
        members = self.kind.by_material(examples)
        split = {name: split_strokes(members[name]) for name in self.materials}
        self.known.tones = [split[name][0] for name in self.materials]
        self.known.surfaces = [
            self.known.measured(name, [example.signal for example in split[name][1]])
            for name in self.materials
        ]
        local = [self.known.local_of([e.signal for e in split[name][1]]) for name in self.materials]
        self.known.local = [each for each in local if each is not None]
        noise = [example for _, rest in split.values() for example in rest]
        trained_on = noise if self.known.predictor is None else examples
        self.known.rate([members[name] for name in self.materials])
        measured = self._measured(modulated(trained_on, self.config.modulated, seed=self.seed)).values()
        codes = torch.stack([reference.surface.code for references in measured for reference in references])
        self.codes = torch.stack((codes.mean(0), codes.std(0, correction=0)))
        if (predictor := self.known.predictor) is not None:
            self._fit_predictor(predictor, Strokes.of([*measured], predictor))
            self.known.strokes = self.strokes_of(noise, self.materials)
        most = MOST_PHOTOGRAPHS if self.config.photographs else 0
        shown = [distinct_photographs(members[name], most) for name in self.materials]
        self.known.described_by.fit(self.known.surfaces, shown)
        self.seconds = float(np.median([len(example.signal) / example.signal.rate for example in examples]))
        self.rms = float(np.median([rms(example.signal) for example in examples]))
        return {"seconds": self.seconds}

    def _start_from(self, run: Path) -> None:
        """Take over the average weights of another run, those before it was straightened."""
        state = load_state(run / "model.safetensors")[0]
        weights = state.get("teacher") or state.get("average", {}).get("weights", {})
        try:
            self.flow.start_from(weights)
        except RuntimeError as error:
            raise ParameterError(
                f"config.start must be a run of texture_flow of {len(self.kind.axes)} axes, {self.spectra.bins} bins "
                f"and widths {self.config.widths}; {run} is not"
            ) from error

    def _fit_predictor(self, predictor: SurfacePredictor, strokes: Strokes) -> None:
        if strokes.at[:, [name in NUMBERS for name in predictor.conditions]].isnan().any(0).all():
            raise ParameterError(
                "config.prediction needs the speed_mm_s or force_n of every recording; set it to false"
            )
        if not (strokes.counts > 1).any():
            raise ParameterError("config.prediction needs several recordings of a material; set it to false")
        predictor.fit(strokes)

    def strokes_of(self, examples: Sequence[Example], materials: Sequence[str]) -> Strokes:
        measured, predictor = self._measured(examples), self.known.predictor
        if predictor is None:
            raise ParameterError("strokes of materials need a run with config.prediction")
        return Strokes.of([measured[name] for name in materials], predictor)

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return the loss on unseen crops; well above that of the training crops if these were memorised."""
        examples = self._without_tones(examples)
        measured = self._measured(examples)
        examples = [e for e in examples if e.material in self.materials or len(measured[str(e.material)]) > 1]
        if not examples:
            return {}
        count = max(len(examples), UNSEEN_CROPS)
        spectra, label = self._batch(self._crops(examples), measured, 0, count, seed=0)
        return {"loss_unseen": self.flow.loss(spectra, label)}

    def state(self) -> dict[str, Any]:
        return {**super().state(), **self.known.state(), "lowest": self.spectra.lowest}

    def load_state(self, state: Mapping[str, Any]) -> None:
        super().load_state(state)
        self.spectra.lowest = float(state["lowest"])
        self.known.load_state(state)


def build(
    config: Config, kind: Kind, *, seed: int, device: str | torch.device = "cpu"
) -> SignalFlowLearner | ImageFlowLearner:
    """Return an untrained model for signals or images of ``kind``."""
    if isinstance(kind, ImageKind):
        return ImageFlowLearner(config, kind, seed=seed, device=device)
    return SignalFlowLearner(config, kind, seed=seed, device=device)
