"""Training on crops of whitened spectra; textures of any length and of mixed materials."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import cached_property, partial
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.features.signal_crops import SignalCrops
from tactogram.model import (
    Condition,
    Example,
    SignalKind,
    Stage,
    check_condition,
    check_state,
    material_weights,
)
from tactogram.models.texture_flow.config import Config
from tactogram.models.texture_flow.flow import flow_loss, solve
from tactogram.models.texture_flow.networks import VelocityUNet
from tactogram.models.texture_flow.whitened_spectra import WhitenedSpectra
from tactogram.nn import MovingAverage
from tactogram.nn.bare_and_fixed import bare
from tactogram.nn.labels import NUMBERS, Labels
from tactogram.signal import Signal
from tactogram.training.seeds import child_generator, child_rng, torch_seeded

NOISE_FRAMES = 64
"""Frames of noise that are drawn at once, so that longer signals begin with the same noise."""
UNSEEN_CROPS = 64
"""Crops of unseen recordings that the loss is measured on."""
LARGEST_GRADIENT = 1.0
"""Norm that gradients are limited to."""


class TextureFlowLearner:
    """Whitened spectra, the network that generates them, and the average of its weights."""

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        kind.require_materials("texture_flow")
        self.config, self.kind, self.materials = config, kind, kind.materials
        self.device = torch.device(device)
        self.spectra = WhitenedSpectra(config, kind)
        self.labels = Labels(config.conditions)
        size = len(kind.materials) + 2 * len(config.conditions)
        with torch_seeded(seed, "weights"):
            network = VelocityUNet(config, axes=len(kind.axes), labels=size)
        self.network: Any = network.to(self.device)
        self.average = MovingAverage(network, config.moving_average)
        self.seconds = 0.0
        self.backward: Callable[[Tensor], None] = Tensor.backward
        self.autocast: Callable[[], AbstractContextManager[Any]] = nullcontext

    @cached_property
    def optimiser(self) -> Any:
        """AdamW. Made for training only: a process's first optimiser imports torch's compiler."""
        return torch.optim.AdamW(self.network.parameters(), lr=self.config.learning_rate, betas=(0.9, 0.99))

    def setup(self, fabric: Any) -> None:
        self.network, self.optimiser = fabric.setup(self.network, self.optimiser)
        self.backward, self.autocast = fabric.backward, fabric.autocast
        self.device = fabric.device
        self.average.network.to(self.device)

    # -- training ----------------------------------------------------------------------------------------

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        self.kind.check_all_present(examples)
        return Stage("fit", 1), Stage("train", self.config.steps)

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if stage.name == "fit":
            yield examples
            return
        step = start
        while True:
            yield step, *self._batch(examples, step, self.config.batch_size, seed=seed)
            step += 1

    def _batch(
        self, examples: Sequence[Example], number: int, count: int, *, seed: int
    ) -> tuple[Tensor, Tensor]:
        """Return the spectra of crops, (crop, axis, bin, frame), and their labels, (crop, label)."""
        length = self.spectra.samples(self.config.frames)
        crops = SignalCrops(examples, length, overlap=self.spectra.transform.n_fft)
        spectra, labels = [], []
        for example, crop in crops.draw(number * count, count, partial(child_rng, seed)):
            place = self.materials.index(str(example.material))
            spectra.append(self.spectra.encode(crop, place))
            labels.append(self._label(np.eye(len(self.materials))[place], example.condition))
        return torch.stack(spectra), torch.stack(labels)

    def _label(self, weights: NDArray[np.float64], condition: Condition) -> Tensor:
        """Return weights that sum to 1, then speed and force, each with a 1 if it is known; float32, shape (label,)."""
        numbers = self.labels.numbers(condition)
        known = [
            float(name in self.labels.ranges and condition.get(name) is not None)
            for name in self.labels.names
        ]
        return torch.tensor([*(weights / weights.sum()), *numbers, *known], dtype=torch.float32)

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == "fit":
            return self._fit(batch)
        number, spectra, label = batch
        label = self._with_some_dropped(label).to(self.device)
        rate = min(1, (number + 1) / self.config.warm_up) * (1 + math.cos(math.pi * number / stage.steps)) / 2
        for group in self.optimiser.param_groups:
            group["lr"] = rate * self.config.learning_rate
        loss = flow_loss(lambda x, time: self.network(x, time, label).float(), spectra.to(self.device))
        self.optimiser.zero_grad()
        self.backward(loss)
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), LARGEST_GRADIENT)
        self.optimiser.step()
        self.average.update(bare(self.network))
        return {"loss": loss.item()}

    def _with_some_dropped(self, label: Tensor) -> Tensor:
        """Return labels, (batch, label), of which some lack the material, others speed and force."""
        count, numbers = len(self.materials), label.shape[1] - len(self.materials)
        kept = (torch.rand(len(label), 2) >= self.config.dropped).float()
        return label * torch.cat((kept[:, :1].expand(-1, count), kept[:, 1:].expand(-1, numbers)), 1)

    def _fit(self, examples: Sequence[Example]) -> dict[str, float]:
        self.labels.fit(examples)
        members = self.kind.by_material(examples)
        self.spectra.fit([[example.signal for example in members[name]] for name in self.materials])
        self.seconds = float(np.median([example.signal.seconds for example in examples]))
        return {"seconds": self.seconds}

    @torch.no_grad()
    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return the loss on unseen crops; well above that of the training crops if these were memorised."""
        if not examples:
            return {}
        spectra, label = self._batch(examples, 0, max(len(examples), UNSEEN_CROPS), seed=0)
        label = label.to(self.device)
        with torch_seeded(0, "validate"):
            loss = flow_loss(lambda x, t: self.average.network(x, t, label), spectra.to(self.device))
        return {"loss_unseen": loss.item()}

    def state(self) -> dict[str, Any]:
        return {
            "materials": list(self.materials),
            "seconds": self.seconds,
            "spectra": self.spectra.state(),
            "conditions": self.labels.state(),
            "average": self.average.state(),
            "network": self.network.state_dict(),
            "optimisers": [self.optimiser.state_dict()],
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        check_state(state["materials"], self.materials)
        self.seconds = float(state["seconds"])
        self.spectra.load_state(state["spectra"])
        self.labels.load_state(state["conditions"])
        self.average.load_state(state["average"])
        self.network.load_state_dict(state["network"])
        if saved := state.get("optimisers"):
            self.optimiser.load_state_dict(saved[0])

    # -- use ---------------------------------------------------------------------------------------------

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return a signal, by default as long as the median of the training recordings.

        Between materials, weights of which are scaled to sum to 1, cross-spectra and log magnitudes are mixed, and the
        network is given the mean of their embeddings. Beyond the recorded range, speed and force count as the nearest
        recorded ones.
        """
        check_condition(condition, needs=("material",), takes=NUMBERS)
        self.labels.check(condition)
        weights = material_weights(condition, self.materials)
        length = max(1, round((self.seconds if seconds is None else seconds) * self.kind.rate))
        spectrum = self._spectrum(self._label(weights, condition), length, seed=seed)
        samples = self.spectra.decode(spectrum.cpu(), weights, length, seed=seed)
        return self.kind.signal(samples)

    @torch.inference_mode()
    def _spectrum(self, label: Tensor, length: int, *, seed: int) -> Tensor:
        """Return a spectrum, (axis, bin, frame), of at least ``length`` samples."""
        frames = self.spectra.frames(length, self.config.multiple)
        shape = len(self.kind.axes), self.spectra.bins, NOISE_FRAMES
        noise = torch.cat(
            [
                torch.randn(shape, generator=child_generator(seed, "noise", number))
                for number in range(-(-frames // NOISE_FRAMES))
            ],
            -1,
        )[None, ..., :frames]
        given, strength = label[None].to(self.device), self.config.guidance

        def velocity(x: Tensor, time: Tensor) -> Tensor:
            found: Tensor = self.average.network(x, time, given)
            if strength == 1:
                return found
            free: Tensor = self.average.network(x, time, torch.zeros_like(given))
            return free + strength * (found - free)

        return solve(velocity, noise.to(self.device), self.config.solver_steps)[0]


def build(
    config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
) -> TextureFlowLearner:
    """Return an untrained model for signals of ``kind``."""
    return TextureFlowLearner(config, kind, seed=seed, device=device)
