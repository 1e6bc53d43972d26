"""Fit of the discriminant in closed form, and of the temperature of its probabilities."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from pydantic import Field
from scipy.linalg import solve_triangular
from scipy.optimize import minimize_scalar
from scipy.special import logsumexp, softmax
from sklearn.covariance import ledoit_wolf
from torch import Tensor, nn

from tactogram.errors import ParameterError
from tactogram.model import Example, ExportedNetwork, ModelConfig, Stage
from tactogram.models.stroke_statistics.features import FRAMES_LEAST, LENGTHS, Statistics
from tactogram.nn.initial_weights import for_export
from tactogram.signal import Signal
from tactogram.statistics import pooled
from tactogram.training.seeds import child_rng
from tactogram.training.window_classifier import WindowClassifier, windows_at

AT_ONCE = 512
"""Windows whose features are computed at a time; bounds the memory."""
FOLDS = 3
"""Parts of the training recordings, each classified by what the others teach, that set the temperature."""
TEMPERATURES = (np.log(1 / 64), np.log(64.0))
"""Natural logarithms of the lowest and the highest temperature."""
LEAST_DEVIATION = 1e-6
"""A feature that varies less is constant."""


class Config(ModelConfig):
    """Windows of the classifier."""

    window_s: float = Field(default=1.0, gt=0, le=60)
    """Seconds of a window; shorter where a training recording is."""
    hop: float = Field(default=0.5, gt=0, le=1)
    """Step from a window to the next, as a share of the window."""
    windows: int = Field(default=6000, ge=2)
    """Most windows that are learned from, drawn evenly from all."""
    recording_weight: float = Field(default=5.0, ge=0)
    """Weight of the covariance of the recordings' means beside that of windows. A recording is named by the mean of its
    windows, which averages out what differs from window to window, and not what differs from recording to recording.
    Only recordings of one material by one contactor at one speed are compared."""

    def input_samples(self, rate: float) -> int:
        """Return the samples of a window."""
        return max(FRAMES_LEAST * LENGTHS[0], round(self.window_s * rate))


class Classifier(nn.Module):
    """Probabilities and embeddings of windows in the signals' unit.

    The embedding is a window's place among the known materials: its features after the within-class covariance is made
    white, along the directions in which the means of the materials differ.
    """

    scale: Tensor
    mean: Tensor
    deviation: Tensor
    directions: Tensor
    places: Tensor
    temperature: Tensor

    def __init__(self, axes: int, samples: int, materials: int) -> None:
        super().__init__()
        self.statistics = Statistics(axes, samples)
        count = self.statistics.count
        self.register_buffer("scale", torch.ones(axes, 1))
        self.register_buffer("mean", torch.zeros(count))
        self.register_buffer("deviation", torch.ones(count))
        self.register_buffer("directions", torch.zeros(count, min(materials - 1, count)))
        self.register_buffer("places", torch.zeros(materials, min(materials - 1, count)))
        self.register_buffer("temperature", torch.ones(()))

    def features(self, x: Tensor) -> Tensor:
        """Return the statistics of windows, (window, axis, time), before they are standardised: (window, feature)."""
        features: Tensor = self.statistics(x / self.scale)
        return features

    def standardised(self, features: Tensor) -> Tensor:
        """Return features with mean 0 and standard deviation 1 over the training windows."""
        return (features - self.mean) / self.deviation

    def forward(self, x: Tensor) -> tuple[Tensor, Tensor]:
        """Return probabilities, (window, material), and embeddings, (window, feature), of (window, axis, time)."""
        embedded = self.standardised(self.features(x)) @ self.directions
        return (self.logits(embedded) / self.temperature).softmax(1), embedded

    def logits(self, embedded: Tensor) -> Tensor:
        """Return each material's log-likelihood up to a constant: (window, feature) -> (window, material)."""
        logits: Tensor = embedded @ self.places.T - self.places.square().sum(1) / 2
        return logits


class StrokeStatisticsLearner(WindowClassifier):
    """Linear discriminant analysis of `Statistics`, its covariance shrunk by Ledoit and Wolf (2004)."""

    config: Config
    saved = ("samples", "network", "left_out")

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._open(self.config.input_samples(self.kind.rate))

    def _open(self, samples: int) -> None:
        self.samples = samples
        self.hop = max(1, round(samples * self.config.hop))
        self.network = Classifier(len(self.kind.axes), samples, len(self.materials)).to(self.device)

    def load_state(self, state: Any) -> None:
        """Continue from ``state``, whose windows may be shorter than the configuration's."""
        self._open(int(state["samples"]))
        super().load_state(state)

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        examples: Sequence[Example] = batch
        shortest = min(examples, key=lambda example: len(example.signal))
        least = FRAMES_LEAST * LENGTHS[0]
        if len(shortest.signal) < least:
            raise ParameterError(
                f"recording {shortest.id} has {len(shortest.signal)} samples, a window needs {least}; "
                "use recordings of that length"
            )
        self._open(min(self.samples, len(shortest.signal)))
        self._measure_scale(examples)
        features, recording = self._training_features(examples)
        material = np.array([self.materials.index(str(example.material)) for example in examples])
        take = _takes(examples)
        temperature, self.left_out = self._calibrated(features, material, take, recording)
        self._fit(features, material, take, recording)
        self.network.temperature.fill_(temperature)
        return {"windows": float(len(features)), "temperature": temperature}

    def _measure_scale(self, examples: Iterable[Example]) -> None:
        """Measure the standard deviation of each axis within the recordings."""
        variance = np.mean(
            [np.var(example.signal.samples, axis=1, dtype=np.float64) for example in examples], axis=0
        )
        if not np.all(variance > 0):
            raise ParameterError("the training signals are constant on an axis; omit it (prepare.axes)")
        self.network.scale.copy_(torch.from_numpy(np.sqrt(variance))[:, None])

    def _training_features(
        self, examples: Sequence[Example]
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Return the features of at most ``config.windows`` windows, and of which example each is."""
        starts = [np.arange(0, len(example.signal) - self.samples + 1, self.hop) for example in examples]
        recording = np.repeat(np.arange(len(examples)), [len(each) for each in starts])
        start = np.concatenate(starts)
        if len(start) > self.config.windows:
            chosen = child_rng(self.seed, "windows").choice(len(start), self.config.windows, replace=False)
            recording, start = recording[np.sort(chosen)], start[np.sort(chosen)]
        features = [
            self._features(example.signal, start[recording == number])
            for number, example in enumerate(examples)
            if np.any(recording == number)
        ]
        return np.concatenate(features), recording

    def _fit(
        self,
        features: NDArray[np.float64],
        material: NDArray[np.int64],
        take: NDArray[np.int64],
        recording: NDArray[np.int64],
    ) -> None:
        """Fit the discriminant to features, (window, feature); materials and `_takes` are those of recordings."""
        network = self.network
        mean, deviation = features.mean(0), np.maximum(features.std(0), LEAST_DEVIATION)
        x = (features - mean) / deviation
        of = material[recording]
        means = np.stack([x[of == each].mean(0) for each in range(len(self.materials))])
        x -= means[of]
        covariance, _ = ledoit_wolf(x, assume_centered=True)
        covariance += LEAST_DEVIATION * np.eye(len(covariance))
        every = np.unique(recording)
        takes, of = np.unique(take[every], return_inverse=True)
        if (freedom := len(every) - len(takes)) > 0:
            averages = np.stack([x[recording == each].mean(0) for each in every])
            averages -= np.stack([averages[of == each].mean(0) for each in range(len(takes))])[of]
            covariance += self.config.recording_weight / freedom * averages.T @ averages
        # In the coordinates z = inv(L) x the covariance is white, and the nearest mean is the likeliest material.
        root = np.linalg.cholesky(covariance)
        white = solve_triangular(root, means.T, lower=True).T
        _, _, axes = np.linalg.svd(white - white.mean(0), full_matrices=False)
        axes = axes[: network.directions.shape[1]]
        parts = (mean, deviation, solve_triangular(root, axes.T, lower=True, trans="T"), white @ axes.T)
        for name, values in zip(("mean", "deviation", "directions", "places"), parts, strict=True):
            getattr(network, name).copy_(torch.from_numpy(values))

    def _calibrated(
        self,
        features: NDArray[np.float64],
        material: NDArray[np.int64],
        take: NDArray[np.int64],
        recording: NDArray[np.int64],
    ) -> tuple[float, NDArray[np.float64]]:
        """Return the temperature at which recordings that were left out of a fit have the likeliest probabilities.

        Windows that overlap, and whose features are no normal variables, are too sure of themselves. 1 if no material
        has recordings in two parts. Also returned are these probabilities of the right materials (`left_out`).
        """
        part = np.zeros(len(material), int)
        for each in range(len(self.materials)):
            places = np.flatnonzero(material == each)
            part[places] = child_rng(self.seed, f"fold {each}").permutation(len(places)) % FOLDS
        logits, true = [], []
        for fold in range(FOLDS):
            known = (part != fold)[recording]
            if len(np.unique(material[recording[known]])) < len(self.materials):
                continue
            self._fit(features[known], material, take, recording[known])
            for left in np.unique(recording[~known]):
                logits.append(self._logits(features[recording == left]))
                true.append(material[left])
        if not logits:
            return 1.0, np.zeros(0)
        mean = np.stack([each.mean(0) for each in logits])

        def cost(log: float) -> float:
            scaled = mean / np.exp(log)
            return float(np.mean(logsumexp(scaled, axis=1) - scaled[np.arange(len(true)), true]))

        temperature = float(np.exp(minimize_scalar(cost, bounds=TEMPERATURES, method="bounded").x))
        left_out = [pooled(softmax(w / temperature, axis=1))[m] for w, m in zip(logits, true, strict=True)]
        return temperature, np.array(left_out)

    @torch.inference_mode()
    def _logits(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the logits of features before the temperature: (window, feature) -> (window, material)."""
        network = self.network
        embedded = (
            network.standardised(torch.from_numpy(features).float().to(self.device)) @ network.directions
        )
        logits: NDArray[np.float64] = network.logits(embedded).double().cpu().numpy()
        return logits

    def window_probabilities(self, signal: Signal) -> NDArray[np.float64]:
        return self._per_window(signal)[0].double().numpy()

    def embed(self, signal: Signal) -> NDArray[np.float32]:
        """Return the mean place of the windows of ``signal`` among the known materials, float32, shape (feature,)."""
        embedded: NDArray[np.float32] = self._per_window(signal)[1].mean(0).numpy()
        return embedded

    @torch.inference_mode()
    def _features(self, signal: Signal, starts: NDArray[np.int64]) -> NDArray[np.float64]:
        windows = windows_at(signal, self.samples, starts, at_once=AT_ONCE)
        parts = [self.network.features(x.to(self.device)) for x in windows]
        features: NDArray[np.float64] = torch.cat(parts).double().cpu().numpy()
        return features

    @torch.inference_mode()
    def _per_window(self, signal: Signal) -> tuple[Tensor, Tensor]:
        """Return probabilities and embeddings of the regular windows of ``signal``, on the CPU."""
        windows = self.regular_windows(signal, self.samples, self.hop, at_once=AT_ONCE)
        parts = [self.network(x.to(self.device)) for x in windows]
        probabilities, embeddings = (torch.cat(each).cpu() for each in zip(*parts, strict=True))
        return probabilities, embeddings

    def exported_networks(self) -> dict[str, ExportedNetwork]:
        network = for_export(self.network)
        return self.exported_classifier(
            network,
            lambda x: x * network.scale,
            self.samples,
            self.hop,
            embedding="place among the known materials",
        )


def _takes(examples: Sequence[Example]) -> NDArray[np.int64]:
    """Return a number for each example, the same for those of one material, contactor and speed."""
    keys = [(e.material, e.condition.get("contactor"), e.condition.get("speed_mm_s")) for e in examples]
    numbers: dict[Any, int] = {}
    return np.array([numbers.setdefault(key, len(numbers)) for key in keys])


build = StrokeStatisticsLearner
