"""Surfaces in closed form: spectrum, level and coherence, and a code of how their strength changes over time.

Per frequency bin, the Hermitian root of the cross-spectral matrix of a surface's axes turns these into uncorrelated
sources of unit power, and back. So the network is left with what happens over time. Phases are recovered from the
magnitudes, of each source by itself, once it has the spectrum of the axes' mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.phase import recover
from tactogram.features.stft import STFT
from tactogram.models.texture_flow.config import Config
from tactogram.signal import Signal
from tactogram.signal.signal import Domain
from tactogram.training.seeds import child_seed

LEAST_POWER = 1e-6
"""Least power of a source, as a share of that of the mean of its bin's axes and of the whole spectrum."""
LEAST_DEVIATION = 0.05
"""Least standard deviation of a log magnitude."""
BANDS = 8
"""Bands of a code."""
LEAKED = 0.4
"""Magnitude at 0 Hz, as a share of the next bin's, that leaks from that of recordings with nothing below it."""
LAGS = (1, 2, 4, 8, 16)
"""Lags of a code's autocorrelations, hops."""


class Surface(NamedTuple):
    """Measurements of one surface, or of a mix.

    Attributes
    ----------
    mean : float32 tensor, shape (axis,)
        Of the samples.
    log_root : complex64 tensor, shape (bin, axis, axis)
        Logarithm of the root of the cross-spectral matrix of each bin but that of 0 Hz.
    centre, deviation : float32 tensors, shape (axis, bin)
        Of the sources' log magnitudes.
    code : float32 tensor, shape (code,)
        See `SurfaceSpectra.code_of`.
    """

    mean: Tensor
    log_root: Tensor
    centre: Tensor
    deviation: Tensor
    code: Tensor

    @staticmethod
    def mixed(surfaces: Sequence[Surface], weights: NDArray[np.float64]) -> Surface:
        """Return a mix: means of logarithms, and the power of the whole as the mean in dB.

        ``weights``, shape (surface,), are scaled to sum to 1.
        """
        share = torch.from_numpy(weights / weights.sum()).float()
        mix = Surface(
            *(torch.tensordot(share.to(t[0].dtype), torch.stack(t), 1) for t in zip(*surfaces, strict=True))
        )
        log_power = share @ torch.stack([surface.power.log() for surface in surfaces])
        gain = (log_power - mix.power.log()) / 2
        return mix._replace(log_root=mix.log_root + gain * torch.eye(len(mix.mean)))

    @property
    def root(self) -> Tensor:
        """The root of the cross-spectral matrices, (bin, axis, axis)."""
        matrix: Tensor = torch.linalg.matrix_exp(self.log_root)
        return matrix

    @property
    def power(self) -> Tensor:
        """Power of all bins and axes, shape ()."""
        return self.root.abs().square().sum()


class SurfaceSpectra:
    """Surfaces from signals; signals to standardised log magnitudes of their surface's sources, and back."""

    def __init__(self, config: Config, rate: float, domain: Domain = "time") -> None:
        self.window, units = (
            ("window_s", ("s", "Hz")) if domain == "time" else ("window_samples", ("samples", "per mm"))
        )
        window = getattr(config, self.window)
        n_fft = 2 ** round(np.log2(window * rate if domain == "time" else window))
        if n_fft // 2 < config.multiple or n_fft // 2 % config.multiple:
            raise ParameterError(
                f"windows of {window:g} {units[0]} have {n_fft // 2} bins at {rate:g} {units[1]}, which must be a "
                f"multiple of {config.multiple} for these widths; lengthen config.{self.window}, take fewer widths, or "
                "ar_texture, which takes any rate"
            )
        self.softness, self.iterations = config.softness, config.iterations
        self.transform = STFT(n_fft, n_fft // 4)
        self.bins = n_fft // 2
        edges = np.unique(np.geomspace(1, self.bins + 1, BANDS + 1).round().astype(int)) - 1
        self.bands = [slice(int(a), int(b)) for a, b in pairwise(edges)]
        self.lowest = 0.0
        """Magnitude of the bin of 0 Hz, which no surface has, as a share of the next: of recordings as in training."""

    def code_size(self, axes: int) -> int:
        """Return the numbers of a code."""
        return (3 * axes + 2 + len(LAGS)) * len(self.bands)

    def vector_size(self, axes: int) -> int:
        """Return the numbers of a surface but its mean, complex ones as two."""
        size: int = 2 * self.bins * axes * (axes + 1) + self.code_size(axes)
        return size

    @property
    def variance(self) -> float:
        """Mean square of a signal per power of its surface."""
        size = self.transform.n_fft
        return float(2 / (size * self.transform.weights(torch.ones(1)).square().sum()))

    def blank(self, axes: int) -> Surface:
        """Return a surface of zeros."""
        table, root = torch.zeros(axes, self.bins), torch.zeros(self.bins, axes, axes, dtype=torch.complex64)
        return Surface(torch.zeros(axes), root, table, table, torch.zeros(self.code_size(axes)))

    def samples(self, frames: int) -> int:
        """Return the samples that ``frames`` whole windows cover."""
        return (frames - 1) * self.transform.hop + self.transform.n_fft

    def frames(self, length: int, multiple: int) -> int:
        """Return the frames, a multiple, that `decode` needs for ``length`` samples, two hops around them included."""
        least = self.transform.frames(length + self.transform.n_fft)
        return -(-least // multiple) * multiple

    def lowest_of(self, signals: Sequence[Signal]) -> float:
        """Return `lowest` of signals: the median, or 0 if it is below `LEAKED`. Without it 20 Hz are 5 dB too weak."""
        power = [
            self._transformed(signal.samples, torch.from_numpy(signal.samples.mean(1)), first=0)[:, :2]
            .abs().square().sum((0, 2))
            for signal in signals
            if len(signal) >= self.transform.n_fft
        ]  # fmt: skip
        ratio = float(np.median([(zero / one).sqrt() for zero, one in power if one > 0] or [0.0]))
        return ratio if ratio >= LEAKED else 0.0

    def measure(self, recorded: Sequence[Signal]) -> Surface | None:
        """Return the surface of signals, or None if they hold fewer than two windows."""
        signals = [signal for signal in recorded if len(signal) >= self.transform.n_fft]
        if len(signals) < 2 and all(len(signal) < self.samples(2) for signal in signals):
            return None
        mean = torch.from_numpy(np.hstack([signal.samples for signal in signals]).astype(np.float64).mean(1))
        mean = mean.float()
        pieces = [self._transformed(signal.samples, mean) for signal in signals]  # A, K, T
        x = torch.cat(pieces, -1).permute(1, 0, 2).to(torch.complex128)
        matrix = x @ x.mH / x.shape[-1]
        power = matrix.diagonal(dim1=-2, dim2=-1).real.mean(-1)
        least = LEAST_POWER * (power + power.mean() + torch.finfo(torch.float32).tiny)
        matrix = matrix + torch.diag_embed(least[:, None].expand(-1, matrix.shape[-1]))
        values, vectors = torch.linalg.eigh(matrix)
        log_root = (vectors * (values.log() / 2).to(vectors)[..., None, :]) @ vectors.mH
        log_root = log_root.to(torch.complex64)
        logs = [self._log_magnitudes(piece, log_root) for piece in pieces]
        joined = torch.cat(logs, -1)
        centre, deviation = joined.mean(-1), joined.std(-1).clamp_min(LEAST_DEVIATION)
        standard = [(each - centre[..., None]) / deviation[..., None] for each in logs]
        code = self.code_of(matrix, centre, deviation, standard)
        return Surface(mean, log_root, centre, deviation, code)

    def code_of(self, matrix: Tensor, centre: Tensor, deviation: Tensor, logs: Sequence[Tensor]) -> Tensor:
        """Return how a surface sounds and changes, float32.

        Per axis and band the level and the mean centre and deviation of its log magnitudes; of the mean of the
        standardised log magnitudes of a band, averaged over axes, the deviation, the skewness, and the
        autocorrelations at `LAGS`.
        """
        power = matrix.diagonal(dim1=-2, dim2=-1).real.mT  # A, K
        bands = [torch.cat([each[:, band].mean(1, keepdim=True) for band in self.bands], 1) for each in logs]
        joined = torch.cat(bands, -1)  # A, B, T
        spread = joined.std(-1).clamp_min(LEAST_DEVIATION)
        unit = [each / spread[..., None] for each in bands]
        skewness = torch.cat(unit, -1).pow(3).mean(-1)
        correlation = [
            torch.cat([each[..., lag:] * each[..., : max(0, each.shape[-1] - lag)] for each in unit], -1)
            for lag in LAGS
        ]
        over_time = [
            spread,
            skewness,
            *(c.mean(-1) if c.shape[-1] else torch.zeros_like(spread) for c in correlation),
        ]
        by_bin = [power.clamp_min(torch.finfo(torch.float32).tiny).log() / 2, centre, deviation]
        by_axis = [
            torch.stack([table[:, band].mean(1) for band in self.bands], 1).ravel() for table in by_bin
        ]
        return torch.cat([*by_axis, *(table.mean(0) for table in over_time)]).float()

    def encode(self, samples: NDArray[np.float32], surface: Surface) -> Tensor:
        """Return the spectrum of samples, (axis, time) -> (axis, bin, frame), of windows that are wholly within."""
        magnitudes = self._log_magnitudes(self._transformed(samples, surface.mean), surface.log_root)
        return (magnitudes - surface.centre[..., None]) / surface.deviation[..., None]

    def over_frames(self, values: Tensor, frames: int, length: int) -> Tensor:
        """Return values, (value, …), at the frames that `decode` puts around ``length`` samples: (frame, …).

        They are those at evenly spaced times from the first sample to the last; a single one stays (1, …).
        """
        if len(values) == 1:
            return values
        samples = torch.arange(frames) * self.transform.hop - self._margin(frames, length)
        position = (samples / length).clamp(0, 1) * (len(values) - 1)
        lower = position.floor().clamp_max(len(values) - 2).long()
        share = (position - lower).view(-1, *[1] * (values.ndim - 1)).to(values.dtype)
        return values[lower] * (1 - share) + values[lower + 1] * share

    def decode(
        self, spectrum: Tensor, surfaces: Sequence[Surface], length: int, *, seed: int
    ) -> NDArray[np.float32]:
        """Return ``length`` samples of a spectrum from the middle of its windows: (axis, bin, frame) -> (axis, time).

        The first and last window surround the signal. Several surfaces are those at evenly spaced times from the first
        sample to the last.
        """
        mean, frames = surfaces[0].mean[:, None], spectrum.shape[-1]
        root, centre, deviation = (
            self.over_frames(torch.stack(tables), frames, length).movedim(0, -1)
            for tables in zip(*((s.root, s.centre, s.deviation) for s in surfaces), strict=True)
        )  # K, A, A, 1 or T; A, K, 1 or T
        level = root.abs().square().sum((1, 2)).div(len(mean)).sqrt()  # K, 1 or T
        magnitude = (torch.exp(spectrum * deviation + centre) - self.softness).clamp_min(0) * level
        magnitude = torch.cat((self.lowest * magnitude[:, :1], magnitude), 1)
        total = self.transform.length(frames)
        recovered = [
            recover(
                each, self.transform, total, iterations=self.iterations, seed=child_seed(seed, "phase", k)
            )
            for k, each in enumerate(magnitude)
        ]
        sources = self.transform.forward(torch.stack(recovered))
        colouring = root / level[:, None, None]
        colouring = torch.cat((colouring[:1].real * (self.lowest > 0), colouring))
        x = self.transform.inverse(torch.einsum("kabt,bkt->akt", colouring, sources), total)
        begin = self._margin(frames, length)
        result: NDArray[np.float32] = (x + mean)[:, begin : begin + length].numpy()
        return result

    def _margin(self, frames: int, length: int) -> int:
        """Return the samples before the first of ``length``."""
        return (self.transform.length(frames) - length) // 2

    def _transformed(self, samples: NDArray[np.float32], mean: Tensor, *, first: int = 1) -> Tensor:
        """Return the transform of windows wholly within the samples: (axis, bin from ``first``, frame)."""
        x = torch.tensor(samples) - mean[:, None]
        pieces = x.unfold(-1, self.transform.n_fft, self.transform.hop) * self.transform.weights(x)
        spectrum: Tensor = torch.fft.rfft(pieces)[..., first:].mT
        return spectrum

    def _log_magnitudes(self, x: Tensor, log_root: Tensor) -> Tensor:
        """Return the sources' log magnitudes, (axis, bin, frame)."""
        whitening = torch.linalg.matrix_exp(-log_root)
        return torch.log(torch.einsum("kab,bkt->akt", whitening, x).abs() + self.softness)
