"""Short-time Fourier transform and its least-squares inverse, exact for every length."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np
import torch
import torch.nn.functional as F
from scipy.signal import get_window
from torch import Tensor

from tactogram.errors import ParameterError

Window: TypeAlias = str | tuple[str, float]

LEAST_COVER = 1e-4
"""Smallest summed squared window, relative to the window's squared peak, that counts as invertible.

Below it, rounding is amplified more than 100 times, and float32 is not inverted to 1e-5."""


@dataclass(frozen=True)
class STFT:
    """A short-time Fourier transform: frame ``t`` is centred on sample ``t * hop``, zeros all around.

    On a whole number of hops it is `librosa.stft` with ``center=True, pad_mode="constant"``. Any other length is padded
    with zeros to whole hops: otherwise only the edge of one window covers the last samples, and the inverse loses
    them. Odd ``n_fft`` have the same frames (centre ``n_fft // 2``).

    ``window`` is a name for `scipy.signal.get_window` (periodic), with its parameter if it has one; ``n_fft`` is its
    length. Windows that cover samples too little for an exact inverse are refused.
    """

    n_fft: int
    hop: int
    window: Window = "hann"

    def __post_init__(self) -> None:
        if not (isinstance(self.n_fft, int) and self.n_fft >= 2):
            raise ParameterError.must("n_fft", "be a whole number >= 2", self.n_fft)
        if not (isinstance(self.hop, int) and 1 <= self.hop <= self.n_fft):
            raise ParameterError.must("hop", f"be a whole number in 1..{self.n_fft}", self.hop)
        if not isinstance(self.window, str):
            object.__setattr__(self, "window", tuple(self.window))  # JSON turns tuples into lists
        # A signal of one hop has two frames, and no sample of a longer signal is covered less.
        centre = self.n_fft // 2
        least = _cover(self.window, self.n_fft, self.hop, 2, torch.float64, "cpu")[centre : centre + self.hop]
        peak = _window(self.window, self.n_fft, torch.float64, "cpu").abs().max()
        if float(least.min()) < LEAST_COVER * float(peak) ** 2:
            raise ParameterError(
                f"window {self.window} of {self.n_fft} with hop {self.hop} cannot be inverted: "
                "some samples are hardly covered; take a smaller hop"
            )

    @property
    def bins(self) -> int:
        """Number of frequency bins, 0 Hz and (for even ``n_fft``) half the rate included."""
        return self.n_fft // 2 + 1

    def frames(self, length: int) -> int:
        """Return the number of frames of ``length`` samples."""
        return 1 + -(-length // self.hop)

    def length(self, frames: int) -> int:
        """Return the greatest number of samples with ``frames`` frames."""
        return (frames - 1) * self.hop

    def weights(self, like: Tensor) -> Tensor:
        """Return the window, shape (n_fft,), in the precision and on the device of ``like``."""
        return _window(self.window, self.n_fft, like.real.dtype, str(like.device))

    def forward(self, x: Tensor) -> Tensor:
        """Return the transform of float32 or float64 samples, (..., time) -> (..., n_fft // 2 + 1, frame).

        Differentiable. Another dtype, or no sample, is a ParameterError.
        """
        check_precision("x", x)
        if x.ndim == 0 or x.shape[-1] == 0:
            raise ParameterError.must("x", f"have at least one sample, got shape {tuple(x.shape)}")
        length = x.shape[-1]
        left = self.n_fft // 2
        right = self.length(self.frames(length)) + self.n_fft - left - length
        pieces = F.pad(x, (left, right)).unfold(-1, self.n_fft, self.hop)  # ..., frame, n_fft
        s: Tensor = torch.fft.rfft(pieces * self.weights(x))  # ..., frame, bin
        return s.mT

    def inverse(self, s: Tensor, length: int) -> Tensor:
        """Return the signal, (..., time), whose transform is nearest to ``s`` (Griffin & Lim 1984, eq. 6).

        ``s`` is complex, shape (..., n_fft // 2 + 1, frame), with the frames of ``length`` samples. Differentiable.
        """
        self.check(s, length)
        pieces = torch.fft.irfft(s.mT, self.n_fft) * self.weights(s)  # ..., frame, n_fft
        left = self.n_fft // 2
        x = overlap_add(pieces, self.hop)[..., left : left + length]
        return x / self.cover(s, s.shape[-1])[left : left + length]

    def cover(self, like: Tensor, frames: int) -> Tensor:
        """Return the summed squared windows of ``frames`` frames, shape ((frames - 1) * hop + n_fft,)."""
        return _cover(self.window, self.n_fft, self.hop, frames, like.real.dtype, str(like.device))

    def check(self, s: Tensor, length: int) -> None:
        """Refuse a spectrogram, (..., n_fft // 2 + 1, frame), that is not one of ``length`` samples."""
        if length < 1:
            raise ParameterError.must("length", "be >= 1 sample", length)
        if s.ndim < 2 or s.shape[-2] != self.bins:
            raise ParameterError.must("spectrogram", f"be (..., {self.bins} bins, frame)", tuple(s.shape))
        if s.shape[-1] != self.frames(length):
            raise ParameterError(f"{length} samples are {self.frames(length)} frames, got {s.shape[-1]}")


class Projection:
    """``s -> STFT(inverse STFT(s))``, repeated without allocation: the step of every phase recovery.

    ``like``, complex, shape (batch, frame, bin), has the shape, precision and device of the inputs. Bins run fastest,
    unlike in `STFT`. The signal is 0 beyond ``length`` samples.
    """

    def __init__(self, transform: STFT, like: Tensor, length: int) -> None:
        batch, frames, _ = like.shape
        n_fft, hop, left = transform.n_fft, transform.hop, transform.n_fft // 2
        overlaps = -(-n_fft // hop)
        self._n_fft = n_fft
        self._window = transform.weights(like)
        # Frames are rows of whole hops, so that overlap-add is one addition of blocks per overlap.
        rows = like.real.new_zeros(batch, frames, overlaps * hop)
        x = like.real.new_zeros(batch, (frames - 1 + overlaps) * hop)
        self._rows = rows[..., :n_fft]
        self._blocks = rows.view(batch, frames, overlaps, hop).unbind(2)
        self._x = x
        spread = x.view(batch, -1, hop)
        self._targets = [spread[:, k : k + frames] for k in range(overlaps)]
        self._pieces = x.unfold(-1, n_fft, hop)[:, :frames]
        self._windowed = torch.empty_like(self._rows, memory_format=torch.contiguous_format)
        self._gain = torch.zeros_like(x[0])
        inside = slice(left, left + length)
        self._gain[inside] = 1 / transform.cover(like, frames)[inside]
        self._inside = inside

    def signal(self, s: Tensor) -> Tensor:
        """Return the inverse of ``s``, shape (batch, time): a view that the next call overwrites."""
        torch.mul(torch.fft.irfft(s, self._n_fft), self._window, out=self._rows)
        self._x.zero_()
        for target, block in zip(self._targets, self._blocks, strict=True):
            target.add_(block)
        self._x.mul_(self._gain)
        return self._x[:, self._inside]

    def __call__(self, s: Tensor) -> Tensor:
        """Return the transform of a signal that is nearest to ``s``; same shape."""
        self.signal(s)
        torch.mul(self._pieces, self._window, out=self._windowed)
        projected: Tensor = torch.fft.rfft(self._windowed)
        return projected


def overlap_add(pieces: Tensor, hop: int) -> Tensor:
    """Return the sum of ``pieces``, each ``hop`` samples after the last: (..., frame, n) -> (..., time)."""
    *batch, frames, n = pieces.shape
    overlaps = -(-n // hop)
    blocks = F.pad(pieces, (0, overlaps * hop - n)).reshape(*batch, frames, overlaps, hop)
    total = pieces.new_zeros(*batch, frames - 1 + overlaps, hop)
    for k in range(overlaps):
        total[..., k : k + frames, :] += blocks[..., k, :]
    return total.flatten(-2)[..., : (frames - 1) * hop + n]


def check_precision(name: str, x: Tensor) -> None:
    """Refuse a tensor that is neither float32 nor float64."""
    if x.dtype not in (torch.float32, torch.float64):
        raise ParameterError(f"{name} must be float32 or float64, got {x.dtype}")


@lru_cache(maxsize=64)
def _window(window: Window, n_fft: int, dtype: torch.dtype, device: str) -> Tensor:
    try:
        values = get_window(window, n_fft)
    except (ValueError, TypeError) as error:
        raise ParameterError.must("window", "be one that scipy knows", window) from error
    return torch.from_numpy(np.ascontiguousarray(values)).to(device=device, dtype=dtype)


@lru_cache(maxsize=64)
def _cover(window: Window, n_fft: int, hop: int, frames: int, dtype: torch.dtype, device: str) -> Tensor:
    squared = _window(window, n_fft, torch.float64, "cpu").square().expand(frames, n_fft)
    return overlap_add(squared, hop).to(device=device, dtype=dtype)
