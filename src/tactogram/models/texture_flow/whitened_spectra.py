"""Whitened spectra: signals as standardised log magnitudes of sources that are alike for every material.

Per material and frequency bin, the Hermitian root of the cross-spectral matrix of the axes turns them into uncorrelated
sources of unit power, and back. So spectrum, level and coherence are closed forms, and the network is left with what
happens over time. Phases are recovered from the magnitudes, of each source by itself, once it has the spectrum of the
axes' mean.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.phase import recover
from tactogram.features.stft import STFT
from tactogram.model import SignalKind
from tactogram.models.texture_flow.config import Config
from tactogram.signal import Signal
from tactogram.training.seeds import child_seed

LEAST_POWER = 1e-6
"""Least power of a source, as a share of that of the mean of its bin's axes and of the whole spectrum."""
LEAST_DEVIATION = 0.05
"""Least standard deviation of a log magnitude."""


class WhitenedSpectra:
    """Standardised log magnitudes of signals, and the way back.

    Attributes
    ----------
    mean : float32 tensor, shape (material, axis)
        Of the samples.
    log_root : complex64 tensor, shape (material, bin, axis, axis)
        Logarithm of the root of the cross-spectral matrix of each bin but that of 0 Hz.
    centre, deviation : float32 tensors, shape (material, axis, bin)
        Of the sources' log magnitudes.
    """

    def __init__(self, config: Config, kind: SignalKind) -> None:
        n_fft = 2 ** round(np.log2(config.window_s * kind.rate))
        if n_fft // 2 < config.multiple or n_fft // 2 % config.multiple:
            raise ParameterError(
                f"windows of {config.window_s:g} s have {n_fft // 2} bins at {kind.rate:g} Hz, which must be a "
                f"multiple of {config.multiple} for these widths; lengthen config.window_s or take fewer widths"
            )
        self.kind, self.softness, self.iterations = kind, config.softness, config.iterations
        self.transform = STFT(n_fft, n_fft // 4)
        self.bins = n_fft // 2
        count, axes = len(kind.materials), len(kind.axes)
        self.mean = torch.zeros(count, axes)
        self.log_root = torch.zeros(count, self.bins, axes, axes, dtype=torch.complex64)
        self.centre = torch.zeros(count, axes, self.bins)
        self.deviation = torch.ones(count, axes, self.bins)

    def samples(self, frames: int) -> int:
        """Return the samples that ``frames`` whole windows cover."""
        return (frames - 1) * self.transform.hop + self.transform.n_fft

    def fit(self, materials: Sequence[Sequence[Signal]]) -> None:
        """Measure the recordings of each material; a `ParameterError` if all of one are shorter than a window."""
        for place, recorded in enumerate(materials):
            signals = [signal for signal in recorded if len(signal) >= self.transform.n_fft]
            if not signals:
                raise ParameterError(
                    f"recordings must have at least {self.transform.n_fft} samples, got none of "
                    f"{self.kind.materials[place]}; shorten config.window_s"
                )
            joined = np.hstack([signal.samples for signal in signals]).astype(np.float64)
            self.mean[place] = torch.from_numpy(joined.mean(1))
            x = torch.cat([self._transformed(signal.samples, place) for signal in signals], -1)  # A, K, T
            x = x.permute(1, 0, 2).to(torch.complex128)
            matrix = x @ x.mH / x.shape[-1]
            power = matrix.diagonal(dim1=-2, dim2=-1).real.mean(-1)
            least = LEAST_POWER * (power + power.mean() + torch.finfo(torch.float32).tiny)
            matrix = matrix + torch.diag_embed(least[:, None].expand(-1, matrix.shape[-1]))
            self.log_root[place] = _function(matrix, lambda values: values.log() / 2).to(torch.complex64)
            magnitudes = self._log_magnitudes(x.permute(1, 0, 2).to(torch.complex64), place)
            self.centre[place] = magnitudes.mean(-1)
            self.deviation[place] = magnitudes.std(-1).clamp_min(LEAST_DEVIATION)

    def encode(self, samples: NDArray[np.float32], material: int) -> Tensor:
        """Return the spectrum of samples, (axis, time) -> (axis, bin, frame), of windows that are wholly within."""
        found = self._log_magnitudes(self._transformed(samples, material), material)
        return (found - self.centre[material][..., None]) / self.deviation[material][..., None]

    def decode(
        self, spectrum: Tensor, weights: NDArray[np.float64], length: int, *, seed: int
    ) -> NDArray[np.float32]:
        """Return ``length`` samples of a spectrum from the middle of its windows: (axis, bin, frame) -> (axis, time).

        ``weights``, shape (material,), are scaled to sum to 1; root and standardisation are mixed in the logarithm. The
        first and last window surround the signal.
        """
        share = torch.from_numpy(weights / weights.sum()).float()
        centre, deviation = (
            torch.tensordot(share, table, 1)[..., None] for table in (self.centre, self.deviation)
        )
        root = self._root(share)
        level = root.abs().square().sum((-1, -2)).div(len(self.kind.axes)).sqrt()  # K
        magnitude = (torch.exp(spectrum * deviation + centre) - self.softness).clamp_min(0) * level[:, None]
        magnitude = F.pad(magnitude, (0, 0, 1, 0))
        total = self.transform.length(spectrum.shape[-1])
        recovered = [
            recover(
                each, self.transform, total, iterations=self.iterations, seed=child_seed(seed, "phase", k)
            )
            for k, each in enumerate(magnitude)
        ]
        sources = self.transform.forward(torch.stack(recovered))[:, 1:]
        mixed = torch.einsum("kab,bkt->akt", root / level[:, None, None], sources)
        x = self.transform.inverse(F.pad(mixed, (0, 0, 1, 0)), total)
        mean = torch.tensordot(share, self.mean, 1)[:, None]
        begin = (total - length) // 2
        result: NDArray[np.float32] = (x + mean)[:, begin : begin + length].numpy()
        return result

    def frames(self, length: int, multiple: int) -> int:
        """Return the frames, a multiple, that `decode` needs for ``length`` samples, two hops around them included."""
        least = self.transform.frames(length + self.transform.n_fft)
        return -(-least // multiple) * multiple

    def state(self) -> dict[str, Any]:
        """Return the tables."""
        return {
            "mean": self.mean,
            "log_root": torch.view_as_real(self.log_root).clone(),
            "centre": self.centre,
            "deviation": self.deviation,
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore the tables of `state`."""
        self.mean, self.centre, self.deviation = (state[name] for name in ("mean", "centre", "deviation"))
        self.log_root = torch.view_as_complex(state["log_root"].contiguous())

    def _root(self, share: Tensor) -> Tensor:
        """Return the root of each bin's cross-spectral matrix, mixed so that the power of the whole is mixed in dB."""
        share = share.to(torch.complex64)
        root: Tensor = torch.linalg.matrix_exp(torch.tensordot(share, self.log_root, 1))
        powers = torch.linalg.matrix_exp(self.log_root).abs().square().sum((1, 2, 3))
        power = root.abs().square().sum()
        return root * torch.exp((share.real @ powers.log() - power.log()) / 2)

    def _transformed(self, samples: NDArray[np.float32], material: int) -> Tensor:
        """Return the transform of windows wholly within the samples: (axis, bin from 1, frame)."""
        x = torch.tensor(samples) - self.mean[material][:, None]
        pieces = x.unfold(-1, self.transform.n_fft, self.transform.hop) * self.transform.weights(x)
        found: Tensor = torch.fft.rfft(pieces)[..., 1:].mT
        return found

    def _log_magnitudes(self, x: Tensor, material: int) -> Tensor:
        """Return the sources' log magnitudes, (axis, bin, frame)."""
        whitening = torch.linalg.matrix_exp(-self.log_root[material])
        return torch.log(torch.einsum("kab,bkt->akt", whitening, x).abs() + self.softness)


def _function(matrix: Tensor, function: Any) -> Tensor:
    """Return a function of Hermitian positive matrices, by their eigenvalues."""
    values, vectors = torch.linalg.eigh(matrix)
    result: Tensor = (vectors * function(values).to(vectors)[..., None, :]) @ vectors.mH
    return result
