"""Friction error: the paper's squared error per fabric, and distances blind to phase.

**The squared error is of little use.** Griffin-Lim recovers some phase, not the recording's: two ripples of one
spectrum and independent phases differ by the sum of their variances, twice that of a flat line at the right level.
Hence the figures of such a line (``mse_flat``) and distances independent of phase, with those between recorded windows
of the same fabric (``floor``) and of different fabrics (``ceiling``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Protocol

import numpy as np
import torch
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import log_spectral_distance
from tactogram.features.registered_pairs import FrictionBatch, Part, RegisteredPairs
from tactogram.features.spectrogram import AmplitudeSpectrogram
from tactogram.model import Example
from tactogram.signal import Signal
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.synthesis import Synthesizer
from tactogram.training.seeds import child_generator, child_rng

WINDOWS = 32
"""Most windows per fabric that are evaluated, evenly spread."""
PLAYED_S = 0.5
"""Duration of a window when played, s."""
BAND_HZ = (10.0, 100.0)
"""Compared: 5 to 50 cycles per window, down to 20 pixels of `paper` and 5 of `quick`. Finer ripple is a hundred times
weaker than the mean, below its leakage through a Hamming window, so that no spectrogram here contains it."""


class FrictionGenerator(Protocol):
    """Generator of friction spectrograms from pairs, as `FrictGANLearner` is one."""

    @property
    def spectrogram(self) -> AmplitudeSpectrogram:
        """Spectrogram of friction over displacement."""

    def pairs(self, examples: Sequence[Example], part: Part | None = "train") -> RegisteredPairs:
        """Return windows of photographs and friction."""

    def spectra(self, batch: FrictionBatch, *, seed: int = 0) -> tuple[Tensor, Tensor]:
        """Return generated and recorded spectrograms."""


@dataclass(frozen=True)
class FabricResult:
    """Result of one fabric, over windows of the evaluated part.

    Parameters
    ----------
    windows : int
    mse : float
        Mean squared error of generated against recorded friction, both after Griffin-Lim, as in the authors' code, and
        from the same initial phases, unlike there: 0 for the right spectrum.
    mse_recording : float
        The same against the recording itself.
    mse_flat : float
        That of a flat line at each window's recorded level, against the recording.
    level_error : float
        Mean absolute difference of the mean coefficients.
    ripple_ratio : float
        Standard deviation of generated windows, as a share of the recorded ones'.
    distance_db, inversion_db, floor_db, ceiling_db : float
        `log_spectral_distance` from recorded windows to generated ones; to Griffin-Lim's of their own magnitudes (not
        the network's part of the distance); to other recorded ones; to another fabric's.
    """

    windows: int
    mse: float
    mse_recording: float
    mse_flat: float
    level_error: float
    ripple_ratio: float
    distance_db: float
    inversion_db: float
    floor_db: float
    ceiling_db: float


def evaluate_fabrics(
    learner: FrictionGenerator, examples: Sequence[Example], *, part: Part | None = "test", seed: int = 0
) -> dict[str, FabricResult]:
    """Return figures per fabric (`Example.material`) of the windows of ``part``; None takes all.

    ``examples`` are unseen under the protocol ``examples``, else the training examples, of which other windows are
    used.
    """
    windows = fabric_windows(learner, examples, part)
    generated = {
        name: learner.spectrogram.decode(learner.spectra(batch, seed=seed)[0], seed=seed)
        for name, batch in windows.items()
    }
    recorded = {name: batch.friction for name, batch in windows.items()}
    return compare_fabrics(learner.spectrogram, recorded, generated, recovered=generated, seed=seed)


def fabric_windows(
    learner: FrictionGenerator, examples: Sequence[Example], part: Part | None, *, most: int = WINDOWS
) -> dict[str, FrictionBatch]:
    """Return ``most`` windows of ``part`` per fabric, evenly spread, or all if there are fewer."""
    pairs = learner.pairs(examples, part)
    fabrics: dict[str, list[int]] = {}
    for number, example in enumerate(examples):
        fabrics.setdefault(str(example.material), []).extend(pairs.of(number))
    if len(fabrics) < 2 or min(len(places) for places in fabrics.values()) < 4:
        raise ParameterError("an evaluation needs at least two fabrics of at least four windows each")
    return {
        name: pairs.batch([places[i] for i in np.unique(np.linspace(0, len(places) - 1, most).astype(int))])
        for name, places in fabrics.items()
    }


def compare_fabrics(
    spectrogram: AmplitudeSpectrogram,
    recorded: Mapping[str, Tensor],
    made: Mapping[str, Tensor],
    *,
    recovered: Mapping[str, Tensor] | None = None,
    seed: int = 0,
) -> dict[str, FabricResult]:
    """Return figures per fabric of windows ``made`` against ``recorded`` ones, both (window, axis, samples).

    ``recovered`` are the same after Griffin-Lim, for the paper's squared error; by default they pass through it here.
    """
    names = list(recorded)
    figures = {}
    for index, name in enumerate(names):
        real, ours = recorded[name], made[name]
        inverted = spectrogram.decode(spectrogram.encode(real), seed=seed)
        again = recovered[name] if recovered else spectrogram.decode(spectrogram.encode(ours), seed=seed)
        other = recorded[names[(index + 1) % len(names)]]
        figures[name] = FabricResult(
            windows=len(real),
            mse=_mean((again - inverted).square()),
            mse_recording=_mean((ours - real).square()),
            mse_flat=_mean((real - real.mean(-1, keepdim=True)).square()),
            level_error=_mean((ours.mean(-1) - real.mean(-1)).abs()),
            ripple_ratio=_mean(ours.std(-1)) / max(_mean(real.std(-1)), 1e-12),
            distance_db=_distance(real, ours),
            inversion_db=_distance(real, inverted),
            floor_db=_distance(*_apart(real)),
            ceiling_db=_distance(real, other),
        )
    return figures


def summary(figures: Mapping[str, FabricResult]) -> dict[str, float]:
    """Return the mean of every figure over fabrics, and ``mse_sum``, which the paper calls the average."""
    every = [asdict(each) for each in figures.values()]
    means = {name: float(np.mean([each[name] for each in every])) for name in every[0]}
    return means | {"mse_sum": float(sum(each["mse"] for each in every))}


def _apart(windows: Tensor) -> tuple[Tensor, Tensor]:
    """Return the windows of both ends, a third each, since neighbours overlap."""
    third = max(1, len(windows) // 3)
    return windows[:third], windows[-third:]


def _distance(one: Tensor, other: Tensor) -> float:
    return log_spectral_distance(_played(one), _played(other), band=BAND_HZ)


def _played(windows: Tensor) -> list[Signal]:
    """Return windows as signals over time that last `PLAYED_S`."""
    rate = windows.shape[-1] / PLAYED_S
    axes = tuple(str(axis) for axis in range(windows.shape[1]))
    return [Signal(window, rate, "1", axes) for window in windows.numpy()]


def _mean(values: Tensor) -> float:
    return float(values.to(torch.float64).mean())


def constant(trained: Tensor, count: int, seed: int) -> Tensor:
    """Return flat windows at the mean level: Coulomb's friction. All windows are (window, axis, samples)."""
    return trained.mean((0, 2), keepdim=True).expand(count, -1, trained.shape[-1])


def autoregressive(trained: Tensor, count: int, seed: int) -> Tensor:
    """Return windows of a process over displacement with the fabric's spectrum (Burg, order by AIC), never below 0."""
    axes = tuple(map(str, range(trained.shape[1])))
    # The fit is for signals over time; any rate will do.
    model = fit_autoregressive([Signal(window, 1000.0, "1", axes) for window in trained.numpy()])
    samples = trained.shape[-1]
    signals = [
        Synthesizer(model, seed=child_rng(seed, "autoregressive", number)).next(samples).samples
        for number in range(count)
    ]
    return torch.from_numpy(np.stack(signals)).clamp_min(0)


def replay(trained: Tensor, count: int, seed: int) -> Tensor:
    """Return recorded windows, drawn at random: as on a display that replays a recording from any place."""
    return trained[torch.randint(len(trained), (count,), generator=child_generator(seed, "replay"))]


MODELS: Mapping[str, Callable[[Tensor, int, int], Tensor]] = {
    "constant": constant,
    "autoregressive": autoregressive,
    "replay": replay,
}
