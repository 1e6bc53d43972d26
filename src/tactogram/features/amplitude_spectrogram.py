"""The magnitudes of a short-time Fourier transform as they are, linear and with their mean, and the way back.

What FrictGAN learns and gives: a spectrogram of 257 x 11 of a friction coefficient over displacement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import torch
import torch.nn.functional as F
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.stft import STFT, Window, overlap_add

MOMENTUM = 0.99
"""Of the fast Griffin-Lim algorithm (Perraudin et al. 2013), as `librosa.griffinlim` has it by default."""


@dataclass(frozen=True, kw_only=True)
class AmplitudeSpectrogram:
    """Signal <-> magnitudes of its transform, each of a fixed size.

    Forward it is ``abs(librosa.stft(x, n_fft, hop, window=window, pad_mode="reflect"))``: frames centred on every
    ``hop``-th sample, the signal mirrored at its ends. That keeps the level of a friction coefficient up to the ends,
    where zeros would put a step of its whole mean into the first and the last frames.

    **The mean** is carried by bin 0: the window times its mean. A magnitude loses the sign of it, but a friction
    coefficient is never negative, and so (``nonnegative``) the phase of bin 0 is known to be 0, in every frame. The
    way back starts from that level and keeps it in every step; it gives no value below 0.

    Parameters
    ----------
    n_fft, hop : int, samples
        FrictGAN, Sec. 4: 512 and 128.
    frames : int
        FrictGAN, Sec. 3.1: 11.
    window : str or (str, float)
        FrictGAN, Sec. 4: Hamming.
    nonnegative : bool
        Whether signals are known to be >= 0, as friction coefficients are.
    iterations : int
        Of `decode`; 32 is what the authors' code takes (librosa's default).

    Raises
    ------
    ParameterError
        If the signal is too short to be mirrored, or the window cannot be inverted.
    """

    n_fft: int = 512
    hop: int = 128
    frames: int = 11
    window: Window = "hamming"
    nonnegative: bool = True
    iterations: int = 32

    def __post_init__(self) -> None:
        transform = STFT(self.n_fft, self.hop, self.window)  # refuses what cannot be inverted
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

        Raises
        ------
        ParameterError
            If ``x`` is of another length, or not float32 or float64.
        """
        if x.dtype not in (torch.float32, torch.float64):
            raise ParameterError(f"x must be float32 or float64, got {x.dtype}")
        if x.ndim == 0 or x.shape[-1] != self.length:
            raise ParameterError(f"x must be (..., {self.length} samples), got {tuple(x.shape)}")
        return self._forward(x.reshape(-1, self.length)).abs().mT.reshape(*x.shape[:-1], self.bins, -1)

    def decode(self, magnitude: Tensor, *, seed: int = 0) -> Tensor:
        """Return a signal of about these magnitudes, by the fast Griffin-Lim algorithm from a random phase.

        Parameters
        ----------
        magnitude : float32 or float64 tensor, shape (..., n_fft // 2 + 1, frames), >= 0
            No gradient flows back.
        seed : int
            The same seed gives the same signal, in a batch as alone.

        Returns
        -------
        tensor, shape (..., length)
            >= 0 with ``nonnegative``.

        Raises
        ------
        ParameterError
            If ``magnitude`` is of another shape, negative or not finite.
        """
        if magnitude.dtype not in (torch.float32, torch.float64):
            raise ParameterError(f"magnitude must be float32 or float64, got {magnitude.dtype}")
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

    def level(self, magnitude: Tensor) -> Tensor:
        """Return the mean under each frame's window that bin 0 says, ``(..., bin, frame) -> (..., frame)``."""
        return magnitude[..., 0, :] / self._transform.weights(magnitude).sum()

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
        """Return the level's own transform, filled up to ``target`` with random phases."""
        random = torch.Generator().manual_seed(seed)
        phase = 2 * math.pi * torch.rand(target.shape[1:], generator=random, dtype=torch.float64)
        turn = torch.polar(torch.ones_like(phase), phase).to(target.device, _complex(target))
        if not self.nonnegative:
            return target * turn
        level = target[..., 0] / self._transform.weights(target).sum()
        slow = F.interpolate(
            level[:, None], size=self.length + 1, mode="linear", align_corners=True
        )  # frame t is at t * hop
        of_level = self._forward(slow[:, 0, :-1])
        return self._with_magnitude(of_level + (target - of_level.abs()).clamp_min(0) * turn, target)

    def _with_magnitude(self, s: Tensor, target: Tensor) -> Tensor:
        s = s * (target / s.abs().clamp_min(torch.finfo(target.dtype).tiny))
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


def _complex(like: Tensor) -> torch.dtype:
    return torch.complex64 if like.dtype == torch.float32 else torch.complex128
