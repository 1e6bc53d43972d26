"""A whole segment <-> its one-sided amplitude spectrum, as a condition or a target of a network."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.levels import AmplitudeScale
from tactogram.signal import Signal

Phase = Literal["random", "minimum", "zero"]


@dataclass(frozen=True, kw_only=True)
class Spectrum(AmplitudeScale):
    """One convention of the spectrum of a segment, and its inverse.

    There is no window: a window that ends in zeros could not be undone. ``asdict(spectrum)`` beside the
    weights is enough to go back.

    Parameters
    ----------
    rate, unit, domain, scaling, floor_db, ceil_db, ref, low, high
        See `AmplitudeScale`. A sinusoid of amplitude 1 m/s^2 in the middle of a bin reads 1 m/s^2, and so does a
        constant.
    length : int, samples
        Of every segment; the bins are ``rate / length`` apart.
    first : int
        The lowest bin that is kept; 1 leaves out the mean.
    bins : int, optional
        How many bins are kept from there; by default all up to half the rate.
    phase : {"random", "minimum", "zero"}
        What `decode` takes where it is given no phase. ``"minimum"`` packs the energy to the front, as an
        impulse response does (the folded cepstrum: Oppenheim & Schafer, Discrete-Time Signal Processing).

    Raises
    ------
    ParameterError
        If a field is not what it should be.

    Notes
    -----
    What it promises, each a test:

    * exact: with every bin, linear scaling and the phase kept, ``decode(encode(x), angle(x)) == x`` to
      rounding, for every length;
    * stable: ``encode(decode(z)) == z`` to rounding, whatever the phase;
    * absolute: a signal times 0.01 comes back times 0.01;
    * known: what is lost is the phase and the bins that are not kept, and amplitudes outside the limits;
    * refused: another length, unit, domain or rate raises.

    The published convention of the sensory-word GAN (Sec. III-B) is ``length=rate, first=1, bins=1000``.
    """

    length: int
    first: int = 0
    bins: int | None = None
    phase: Phase = "random"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (isinstance(self.length, int) and self.length >= 1):
            raise ParameterError(f"length must be a whole number >= 1, got {self.length}")
        every = self.length // 2 + 1
        if not (isinstance(self.first, int) and 0 <= self.first < every):
            raise ParameterError(f"first must be a whole number in 0..{every - 1}, got {self.first}")
        bins = every - self.first if self.bins is None else self.bins
        if not (isinstance(bins, int) and 1 <= bins <= every - self.first):
            raise ParameterError(f"bins must be a whole number in 1..{every - self.first}, got {self.bins}")
        object.__setattr__(self, "bins", bins)
        if self.phase not in ("random", "minimum", "zero"):
            raise ParameterError(f"phase must be 'random', 'minimum' or 'zero', got {self.phase!r}")

    @property
    def frequencies(self) -> NDArray[np.float64]:
        """Centre of each kept bin, shape (bin,), Hz (or cycles per mm)."""
        return np.arange(self.first, self._stop, dtype=np.float64) * (self.rate / self.length)

    def encode(self, x: Tensor) -> Tensor:
        """Return the spectrum of a segment. Differentiable.

        Parameters
        ----------
        x : float32 or float64 tensor, shape (..., ``length``), ``unit``

        Returns
        -------
        tensor, shape (..., bin), in ``low..high``
        """
        return self.value(self._transform(x).abs() / self._gain(x))

    def angle(self, x: Tensor) -> Tensor:
        """Return the phase of a segment, (..., time) -> (..., bin), radians: what `decode` may be given."""
        return self._transform(x).angle()

    def decode(self, z: Tensor, phase: Tensor | None = None, *, seed: int = 0) -> Tensor:
        """Return a segment whose spectrum is ``z``.

        Parameters
        ----------
        z : float32 or float64 tensor, shape (..., bin), in ``low..high``
        phase : tensor, shape (..., bin), radians, optional
            Kept from `angle`; otherwise the field ``phase`` says what is taken. At 0 Hz and at half the rate
            a real signal has phase 0 or pi only: there the nearer is taken.
        seed : int
            Of a random phase; every item of a batch gets the same numbers, as it would alone.

        Returns
        -------
        tensor, shape (..., time), ``unit``

        Raises
        ------
        ParameterError
            If ``z`` is not finite or has another number of bins.
        """
        if z.dtype not in (torch.float32, torch.float64):
            raise ParameterError(f"z must be float32 or float64, got {z.dtype}")
        if z.ndim == 0 or z.shape[-1] != self.bins:
            raise ParameterError(f"z must be (..., {self.bins} bins), got {tuple(z.shape)}")
        if phase is not None and phase.shape != z.shape:
            raise ParameterError(
                f"phase must have the shape of z, {tuple(z.shape)}, got {tuple(phase.shape)}"
            )
        rest = self.length // 2 + 1 - self._stop
        magnitude = F.pad(self.amplitude(z) * self._gain(z), (self.first, rest))
        if phase is not None:
            angle = F.pad(phase.to(magnitude), (self.first, rest))
        elif self.phase == "minimum":
            angle = _minimum_phase(magnitude, self.length)
        else:
            share = torch.zeros(magnitude.shape[-1], dtype=torch.float64)
            if self.phase == "random":
                share = torch.rand(
                    len(share), generator=torch.Generator().manual_seed(seed), dtype=torch.float64
                )
            angle = (2 * math.pi * share).to(magnitude).expand_as(magnitude)
        angle = self._real_ends(angle)
        x: Tensor = torch.fft.irfft(torch.polar(magnitude, angle), self.length)
        return x

    def encode_signal(self, signal: Signal) -> Tensor:
        """Return the spectrum of a signal of ``length`` samples, float32, shape (axis, bin).

        Raises
        ------
        UnitError, ParameterError
            If unit, domain, rate or length are others than the fields say.
        """
        self.check_signal(signal)
        return self.encode(torch.tensor(signal.samples))

    def decode_signal(
        self, z: Tensor, phase: Tensor | None = None, *, axes: tuple[str, ...] = (), seed: int = 0
    ) -> Signal:
        """Return the signal of a spectrum of shape (bin,) or (axis, bin); see `decode`."""
        samples = self.decode(z.detach(), phase, seed=seed).cpu().numpy()
        return Signal(samples, self.rate, self.unit, axes, self.domain)

    @property
    def _stop(self) -> int:
        return self.first + (self.bins or 0)

    def _transform(self, x: Tensor) -> Tensor:
        if x.dtype not in (torch.float32, torch.float64):
            raise ParameterError(f"x must be float32 or float64, got {x.dtype}")
        if x.ndim == 0 or x.shape[-1] != self.length:
            raise ParameterError(f"x must be (..., {self.length} samples), got {tuple(x.shape)}")
        s: Tensor = torch.fft.rfft(x)[..., self.first : self._stop]
        return s

    def _gain(self, like: Tensor) -> Tensor:
        """Return what the transform makes of amplitude 1 in each kept bin, shape (bin,)."""
        gain = like.new_full((self.length // 2 + 1,), self.length / 2)
        gain[0] = self.length
        if self.length % 2 == 0:
            gain[-1] = self.length
        return gain[self.first : self._stop]

    def _real_ends(self, angle: Tensor) -> Tensor:
        """Return ``angle`` with 0 or pi where a real signal can have nothing else."""
        ends = torch.zeros(angle.shape[-1], dtype=torch.bool, device=angle.device)
        ends[0] = True
        ends[-1] |= self.length % 2 == 0
        return torch.where(ends, torch.where(angle.cos() < 0, math.pi, 0.0).to(angle), angle)


def _minimum_phase(magnitude: Tensor, length: int) -> Tensor:
    """Return the phase of the minimum-phase signal with ``magnitude``, shape (..., bin), radians."""
    least = 1e-5 * magnitude.amax(-1, keepdim=True)
    log = torch.maximum(magnitude, least).clamp_min(torch.finfo(magnitude.dtype).tiny).log()
    cepstrum = torch.fft.irfft(log, length)
    fold = cepstrum.new_zeros(length)
    fold[0] = 1
    fold[1 : (length + 1) // 2] = 2
    if length % 2 == 0:
        fold[length // 2] = 1
    phase: Tensor = torch.fft.rfft(cepstrum * fold).imag
    return phase
