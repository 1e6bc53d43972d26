"""Inversion loss: the shares of the network and of the inversion in the error of inverted pictures.

Neshov et al. 2026 do not evaluate it ("beyond the scope", Sec. 2) and call it a limitation (Sec. 5).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import signal_measures
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.signal import Signal


@dataclass(frozen=True)
class InversionLoss:
    """Distances from real signals by one measure, in its unit; lower is better."""

    floor: float | None
    """Distance of other real signals of the same material, the lower limit; None if there are none."""
    inversion: float
    """Distance of the same signals converted to pictures and back: the loss by phase, range and resizing."""
    total: float
    """Distance of the signals of generated pictures."""

    @property
    def network(self) -> float:
        """The network's part, ``total - inversion``; below 0 if it compensates for errors of the inversion."""
        return self.total - self.inversion

    @property
    def share_of_inversion(self) -> float | None:
        """``inversion / total``, at most 1; None without a loss."""
        return min(1.0, self.inversion / self.total) if self.total > 0 else None


def invert(pictures: Tensor, picture: SpectrogramPicture, *, seed: int, axis: str = "z") -> list[Signal]:
    """Return the signal of each picture, shape (picture, 1, rows, columns), in [-1, 1]; ``seed`` is the phase's."""
    samples = picture.signal(pictures, seed=seed).cpu().numpy()
    return [Signal(waveform, picture.rate, picture.unit, (axis,), picture.domain) for waveform in samples]


def inversion_loss(
    real: Sequence[Signal],
    made: Tensor,
    picture: SpectrogramPicture,
    *,
    others: Sequence[Signal] = (),
    seed: int,
) -> dict[str, InversionLoss]:
    """Return the loss of one material by each measure of `signal_measures`, none of which depends on phase.

    Measures undefined for one axis, or for signals as short as a picture, are left out; ``seed`` is that of the
    phase. Raises `ParameterError` if a signal has several axes, is shorter than a picture, or differs from it in kind.

    Parameters
    ----------
    real, others : sequence of Signal
        Of the material; ``others`` are for the floor. Only the first ``picture.length`` samples count.
    made : float tensor, shape (picture, 1, rows, columns), in [-1, 1]
        Generated for the material.
    """
    real = [_cut(signal, picture) for signal in real]
    others = [_cut(signal, picture) for signal in others]
    if not real or not len(made):
        raise ParameterError(
            f"at least one signal and one picture are needed, got {len(real)} and {len(made)}"
        )
    axis = real[0].axes[0]
    encoded = picture.encode(torch.from_numpy(np.stack([signal.samples[0] for signal in real])))
    back = invert(encoded, picture, seed=seed, axis=axis)
    generated = invert(made, picture, seed=seed, axis=axis)
    losses = {}
    for name, measure in signal_measures().items():
        try:
            inversion, total = measure.function(real, back), measure.function(real, generated)
        except ParameterError:  # a picture may be too short for a measure
            continue
        if inversion is not None and total is not None:
            losses[name] = InversionLoss(measure.function(real, others) if others else None, inversion, total)
    return losses


def mean_loss(losses: Sequence[Mapping[str, InversionLoss]]) -> dict[str, InversionLoss]:
    """Return the mean over materials of each measure that all have; the floor is None if a material has none."""
    if not losses:
        raise ParameterError("at least one material is needed, got none")
    means = {}
    for name in losses[0]:
        if all(name in by_measure for by_measure in losses):
            each = [by_measure[name] for by_measure in losses]
            floors = [loss.floor for loss in each if loss.floor is not None]
            means[name] = InversionLoss(
                float(np.mean(floors)) if len(floors) == len(each) else None,
                float(np.mean([loss.inversion for loss in each])),
                float(np.mean([loss.total for loss in each])),
            )
    return means


def _cut(signal: Signal, picture: SpectrogramPicture) -> Signal:
    picture.spectrogram.check_signal(signal)
    if len(signal.axes) != 1:
        raise ParameterError(f"a picture is of one axis, got {','.join(signal.axes)}")
    if len(signal) < picture.length:
        raise ParameterError.must("signals", f"have {picture.length} samples", len(signal))
    return signal.cut(0, picture.length)
