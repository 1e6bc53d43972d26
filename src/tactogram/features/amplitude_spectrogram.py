"""Spectrogram of linear magnitudes including the mean, and its inverse.

FrictGAN generates such a spectrogram, 257 x 11, of a friction coefficient over displacement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import torch
import torch.nn.functional as F
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.stft import STFT, Window, check_precision, overlap_add

MOMENTUM = 0.99
"""Momentum of the fast Griffin-Lim algorithm (Perraudin et al. 2013); default of `librosa.griffinlim`."""
NOTHING = 1e-30
"""Magnitude below which a phase means nothing; large magnitudes over it are finite."""


@dataclass(frozen=True, kw_only=True)
class AmplitudeSpectrogram:
    """Signal <-> magnitudes of its transform, each of a fixed size.

    Encoding is ``abs(librosa.stft(x, n_fft, hop, window=window, pad_mode="reflect"))``: frames centred on every
    ``hop``-th sample, the signal mirrored at its ends. That preserves the level of a friction coefficient up to the
    ends; zeros would put a step of its whole mean into the first and last frames.

    **The mean** is in bin 0: the window times its mean. A magnitude loses its sign, but a friction coefficient is never
    negative, so that (``nonnegative``) the phase of bin 0 is 0 in every frame. Decoding starts from that level and
    keeps it in every step; no decoded value is below 0.

    Defaults are FrictGAN's: Sec. 4 for ``n_fft``, ``hop`` and ``window``, Sec. 3.1 for ``frames``; ``iterations`` of
    `decode` are those of the authors' code (librosa's default).
    """

    n_fft: int = 512
    hop: int = 128
    frames: int = 11
    window: Window = "hamming"
    nonnegative: bool = True
    iterations: int = 32

    def __post_init__(self) -> None:
        transform = STFT(self.n_fft, self.hop, self.window)  # refuses windows without an inverse
        object.__setattr__(self, "window", transform.window)
        if not (isinstance(self.frames, int) and (self.frames - 1) * self.hop > self.n_fft // 2):
            raise ParameterError(
                f"frames must be more than {self.n_fft // 2 // self.hop + 1}, so that a signal of "
                f"(frames - 1) * {self.hop} samples can be mirrored by {self.n_fft // 2}; got {self.frames}"
            )
        if self.n_fft % 2:
            raise ParameterError(f"n_fft must be even, got {self.n_fft}")
        if self.iterations < 0:
            raise ParameterError(f"iterations must be >= 0, got {self.iterations}")

    @property
    def bins(self) -> int:
        """Number of frequencies, 0 and half the rate included."""
        return self.n_fft // 2 + 1

    @property
    def length(self) -> int:
        """Number of samples of a signal: ``(frames - 1) * hop``, 1280 as published."""
        return (self.frames - 1) * self.hop

    @cached_property
    def _transform(self) -> STFT:
        return STFT(self.n_fft, self.hop, self.window)

    def encode(self, x: Tensor) -> Tensor:
        """Return the magnitudes, ``(..., length) -> (..., n_fft // 2 + 1, frames)``. Differentiable.

        Sums over the window, not scaled: a constant c is c times the sum of the window (276.5 as published) in bin 0.
        """
        check_precision("x", x)
        if x.ndim == 0 or x.shape[-1] != self.length:
            raise ParameterError(f"x must be (..., {self.length} samples), got {tuple(x.shape)}")
        return self._forward(x.reshape(-1, self.length)).abs().mT.reshape(*x.shape[:-1], self.bins, -1)

    def decode(self, magnitude: Tensor, *, seed: int = 0) -> Tensor:
        """Return a signal of about these magnitudes, by the fast Griffin-Lim algorithm from a random phase.

        ``(..., n_fft // 2 + 1, frames) -> (..., length)``; magnitudes are finite and >= 0. No gradient flows back. The
        same seed gives the same signal, in a batch as alone.
        """
        check_precision("magnitude", magnitude)
        if magnitude.shape[-2:] != (self.bins, self.frames):
            raise ParameterError(
                f"magnitude must be (..., {self.bins} bins, {self.frames} frames), got {tuple(magnitude.shape)}"
            )
        with torch.no_grad():
            target = magnitude.detach().reshape(-1, self.bins, self.frames).mT  # batch, frame, bin
            if not bool((torch.isfinite(target) & (target >= 0)).all()):
                raise ParameterError("magnitude must be finite and >= 0, got a value that is not")
            x = self._recovered(target, seed)
            return x.reshape(*magnitude.shape[:-2], self.length)

    def _recovered(self, target: Tensor, seed: int) -> Tensor:
        s = self._start(target, seed)
        last: Tensor | None = None
        for _ in range(self.iterations):
            consistent = self._forward(self._signal(s))
            ahead = consistent if last is None else consistent.lerp(last, -MOMENTUM)
            last = consistent
            s = self._with_magnitude(ahead, target)
        return self._signal(s)

    def _start(self, target: Tensor, seed: int) -> Tensor:
        """Return the transform of the level, filled up to ``target`` with phases of a seed."""
        random = torch.Generator().manual_seed(seed)
        phase = 2 * math.pi * torch.rand(target.shape[1:], generator=random, dtype=torch.float64)
        turn = torch.polar(torch.ones_like(phase), phase).to(target.device, target.dtype.to_complex())
        if not self.nonnegative:
            return target * turn
        level = target[..., 0] / self._transform.weights(target).sum()
        slow = F.interpolate(
            level[:, None], size=self.length + 1, mode="linear", align_corners=True
        )  # frame t is at t * hop
        of_level = self._forward(slow[:, 0, :-1])
        return self._with_magnitude(of_level + (target - of_level.abs()).clamp_min(0) * turn, target)

    def _with_magnitude(self, s: Tensor, target: Tensor) -> Tensor:
        s = s * (target / s.abs().clamp_min(NOTHING))
        if self.nonnegative:
            s[..., 0] = target[..., 0]
        return s

    def _forward(self, x: Tensor) -> Tensor:
        """Return the transform of mirrored signals, (batch, time) -> (batch, frame, bin)."""
        half = self.n_fft // 2
        pieces = F.pad(x, (half, half), mode="reflect").unfold(-1, self.n_fft, self.hop)
        s: Tensor = torch.fft.rfft(pieces * self._transform.weights(x))
        return s

    def _signal(self, s: Tensor) -> Tensor:
        """Return the signal nearest to a transform, (batch, frame, bin) -> (batch, time)."""
        half = self.n_fft // 2
        pieces = torch.fft.irfft(s, self.n_fft) * self._transform.weights(s)
        x = overlap_add(pieces, self.hop) / self._transform.cover(s, self.frames)
        x = x[..., half : half + self.length]
        return x.clamp_min(0) if self.nonnegative else x
