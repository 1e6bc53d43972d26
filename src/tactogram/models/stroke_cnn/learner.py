"""Training of the classifier on random windows; probabilities pooled over a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.model import WHOLE_BATCH, BatchShare, Example, ExportedNetwork, Stage
from tactogram.models.stroke_cnn.config import MOST_PASSES, SETTLED, Config
from tactogram.models.stroke_cnn.networks import Standardised, StrokeCNN
from tactogram.nn.initial_weights import bare, for_export
from tactogram.signal import Signal
from tactogram.training.seeds import child_rng, torch_seeded
from tactogram.training.window_classifier import WindowClassifier

AT_ONCE = 256
"""Windows per forward pass when a recording is classified; bounds the memory."""


class StrokeCNNLearner(WindowClassifier):
    """The classifier of Saga et al., Sec. II."""

    config: Config
    divides_batches = True
    saved = ("network", "mean", "scale")

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.network: Any = self._untrained().to(self.device)
        self.validation: Sequence[Example] = ()
        self.short_accuracy: float | None = None
        self.schedule: Any = None
        self.backward: Callable[[Tensor], None] = Tensor.backward
        self.mean = torch.zeros(len(self.kind.axes), 1)
        self.scale = torch.ones(len(self.kind.axes), 1)

    def _untrained(self) -> StrokeCNN:
        with torch_seeded(self.seed, "weights"):
            return StrokeCNN(self.config, axes=len(self.kind.axes), classes=len(self.materials))

    @cached_property
    def optimiser(self) -> Any:
        """Adam. Made for training only: a process's first optimiser imports torch's compiler."""
        return torch.optim.Adam(self.network.parameters(), lr=self.config.learning_rate, fused=True)

    def _make_schedule(self, steps: int) -> None:
        """Let the learning rate follow its schedule over ``steps`` updates."""
        if self.config.schedule == "one-cycle":
            rate = self.config.learning_rate
            self.schedule = torch.optim.lr_scheduler.OneCycleLR(self.optimiser, rate, steps)

    def setup(self, fabric: Any) -> None:
        self.network, self.optimiser = fabric.setup(self.network, self.optimiser)
        self.backward = fabric.backward
        self.device = fabric.device
        super().setup(fabric)

    def set_validation(self, examples: Sequence[Example]) -> str:
        self.validation = examples
        return ""

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        # Refuses recordings that are too short.
        windows = Windows(examples, self.materials, self.config.window)
        short = [Stage("short", self.config.short_steps)] if self._tries_short(windows) else []
        return Stage("standardise", 1), *short, Stage("classify", self.config.steps, skippable=bool(short))

    def _tries_short(self, windows: Windows) -> bool:
        few = self.config.passes(windows.samples) > MOST_PASSES
        return few and len(self.validation) > 0 and 0 < self.config.short_steps < self.config.steps

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if stage.name == "standardise":
            yield examples
            return
        windows = Windows(examples, self.materials, self.config.window)
        if start == 0:
            if stage.name == "classify" and self._tries_short(windows):
                self.short_accuracy = self._window_accuracy(self.validation)
                if self.short_accuracy >= SETTLED:
                    return
                self._forget()
            self._make_schedule(stage.steps)
        for step in range(start, stage.steps):
            yield windows.draw(self.config.batch_size, child_rng(seed, step), self.share)

    def _window_accuracy(self, examples: Sequence[Example]) -> float:
        """Return the share of the windows of ``examples`` that are classified correctly."""
        hits = [
            self.window_probabilities(example.signal).argmax(1) == self.materials.index(str(example.material))
            for example in examples
        ]
        return float(np.concatenate(hits).mean())

    def _forget(self) -> None:
        """Return to the weights from before the training."""
        bare(self.network).load_state_dict(self._untrained().state_dict())
        self.optimiser.state.clear()

    def outcome(self) -> dict[str, Any]:
        if self.short_accuracy is None:
            return {}
        kept = self.short_accuracy >= SETTLED
        return {"short_training": {"validation_window_accuracy": self.short_accuracy, "kept": kept}}

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == "standardise":
            return self._standardise(batch)
        x, material = batch
        logits = self.network(self._input(torch.from_numpy(x)))  # B, A, T -> B, C
        loss = F.cross_entropy(logits, torch.as_tensor(material, device=self.device))
        self.optimiser.zero_grad()
        self.backward(loss)
        self.optimiser.step()
        if self.schedule is not None:
            self.schedule.step()
        return {"loss": loss.item()}

    def _standardise(self, examples: Sequence[Example]) -> dict[str, float]:
        """Measure mean and scale of each axis over the training part; the mean includes gravity."""
        count, total, square = 0, 0.0, 0.0
        for example in examples:
            x = np.asarray(example.signal.samples, dtype=np.float64)
            count, total, square = count + x.shape[1], total + x.sum(1), square + (x**2).sum(1)
        mean = total / count
        deviation = np.sqrt(np.maximum(square / count - mean**2, 0))
        if not np.all(deviation > 0):
            raise ParameterError("the training signals are constant on an axis; omit it (prepare.axes)")
        self.mean = torch.tensor(mean, dtype=torch.float32)[:, None]
        self.scale = torch.tensor(deviation, dtype=torch.float32)[:, None]
        return {f"scale_{axis}": float(d) for axis, d in zip(self.kind.axes, deviation, strict=True)}

    def _input(self, x: Tensor) -> Tensor:
        """Return the network's input: (window, axis, time), standardised."""
        return ((x - self.mean) / self.scale).to(self.device)

    def optimiser_state(self) -> dict[str, Any]:
        schedule = self.schedule.state_dict() if self.schedule is not None else None
        return {"adam": self.optimiser.state_dict(), "schedule": schedule}

    def load_optimisers(self, states: Mapping[str, Any]) -> None:
        if states["schedule"] is not None:
            self._make_schedule(states["schedule"]["total_steps"])  # it sets the optimiser's learning rate
            self.schedule.load_state_dict(states["schedule"])
        self.optimiser.load_state_dict(states["adam"])

    def exported_networks(self) -> dict[str, ExportedNetwork]:
        network = Standardised(for_export(self.network), self.mean, self.scale)
        window, hop = self.config.window, self.config.hop_samples
        return self.exported_classifier(
            network, lambda x: x * self.scale + self.mean, window, hop, embedding="last hidden layer"
        )

    def window_probabilities(self, signal: Signal) -> NDArray[np.float64]:
        logits = self._per_window(bare(self.network), signal)
        probabilities: NDArray[np.float64] = logits.double().softmax(1).numpy()
        return probabilities

    def embed(self, signal: Signal) -> NDArray[np.float32]:
        """Return the last hidden layer averaged over the windows of ``signal``, float32, shape (feature,)."""
        embedded: NDArray[np.float32] = self.window_embeddings(signal).mean(axis=0)
        return embedded

    def window_embeddings(self, signal: Signal) -> NDArray[np.float32]:
        """Return the last hidden layer for each window, float32, shape (window, feature)."""
        embedded: NDArray[np.float32] = self._per_window(bare(self.network).embed, signal).numpy()
        return embedded

    @torch.inference_mode()
    def _per_window(self, network: Callable[[Tensor], Tensor], signal: Signal) -> Tensor:
        """Return ``network`` of the regular windows of ``signal``: (window, …), on the CPU."""
        windows = self.regular_windows(signal, self.config.window, self.config.hop_samples, at_once=AT_ONCE)
        self.network.eval()
        parts = [network(self._input(x)).float() for x in windows]
        self.network.train()
        return torch.cat(parts).cpu()


class Windows:
    """Windows cut at random from the training part: every possible window is equally likely."""

    def __init__(self, examples: Sequence[Example], materials: Sequence[str], length: int) -> None:
        self.length = length
        self.signals = [example.signal.samples for example in examples]
        self.classes = np.array([materials.index(str(example.material)) for example in examples])
        self.samples = sum(signal.shape[1] for signal in self.signals)
        places = np.array([signal.shape[1] - length + 1 for signal in self.signals])
        short = np.flatnonzero(places < 1)
        if short.size:
            raise ParameterError(
                f"recording {examples[short[0]].id} has {self.signals[short[0]].shape[1]} samples, "
                f"a window needs {length}; use recordings of that length or a shorter config.window"
            )
        self.bounds = np.cumsum(places)

    def draw(
        self, count: int, rng: np.random.Generator, share: BatchShare = WHOLE_BATCH
    ) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
        """Return the share of ``count`` windows, float32 (window, axis, time), and their classes, int64 (window,)."""
        positions = share.places(rng.integers(self.bounds[-1], size=count), count)
        which = np.searchsorted(self.bounds, positions, side="right")
        last = self.bounds[which] - positions  # 1 is the recording's last window
        x = np.stack(
            [
                self.signals[i][:, self.signals[i].shape[1] - self.length + 1 - back :][:, : self.length]
                for i, back in zip(which, last, strict=True)
            ]
        )
        return x, self.classes[which].astype(np.int64)


build = StrokeCNNLearner
