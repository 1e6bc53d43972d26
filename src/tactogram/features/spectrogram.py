"""A signal <-> the bounded log-magnitude picture that a network sees."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.levels import AmplitudeScale
from tactogram.features.phase import Iteration, Start, recover
from tactogram.features.stft import STFT, Window
from tactogram.signal import Signal


@dataclass(frozen=True, kw_only=True)
class Spectrogram(AmplitudeScale):
    """One spectrogram convention, written once, and its inverse.

    Every number that is needed to go back is a field, plain enough for JSON: ``asdict(spectrogram)`` beside
    the weights, and ``Spectrogram(**that)`` turns a generated picture into a signal years later.

    Parameters
    ----------
    rate, unit, domain, scaling, floor_db, ceil_db, ref, low, high
        See `AmplitudeScale`. Amplitudes are those of a sinusoid: one of 1 m/s^2 in the middle of a bin reads 1 m/s^2.
    n_fft, hop : int, samples
        Length of the window, and the step between windows.
    window : str or (str, float)
        Name for `scipy.signal.get_window`.
    bins : int, optional
        How many frequency bins are kept, from 0 Hz up; all ``n_fft // 2 + 1`` by default.
    start, iteration, iterations
        How `decode` finds the phase; see `recover`.

    Raises
    ------
    ParameterError
        If a field is not what it should be, or the window leaves samples that could not be had back.

    Notes
    -----
    What it promises, each a test in ``tests/features``:

    * exact: ``istft(stft(x), length) == x`` to rounding, for every length >= 1;
    * stable: ``encode(decode(z))`` is close to ``z``, for every ``z`` that came from a signal;
    * absolute: a signal times 0.01 comes back times 0.01, as long as it stays between floor and ceiling;
    * known: what is lost is phase, bins from ``bins`` up, and amplitudes outside the two limits;
    * refused: what cannot be inverted raises.

    Published conventions, as fields: ``window="hamming"`` with ``n_fft=256, hop=128`` (generation of unrecorded
    tactile information, Sec. III-B) or ``n_fft=512, hop=128`` (visual-tactile cGAN, Sec. 4.1; FrictGAN, Sec. 4,
    with ``domain="displacement", unit="1", scaling="linear"``); and ``n_fft=2048, hop=204, bins=48``.
    """

    n_fft: int = 256
    hop: int = 64
    window: Window = "hann"
    bins: int | None = None
    start: Start = "gradient"
    iteration: Iteration = "admm+fast_griffin_lim"
    iterations: int = 64

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "window", self.transform.window)
        every = self.transform.bins
        bins = every if self.bins is None else self.bins
        if not (isinstance(bins, int) and 1 <= bins <= every):
            raise ParameterError(f"bins must be a whole number in 1..{every}, got {self.bins}")
        object.__setattr__(self, "bins", bins)
        if self.start not in ("gradient", "random"):
            raise ParameterError(f"start must be 'gradient' or 'random', got {self.start!r}")
        if self.iteration not in ("admm+fast_griffin_lim", "admm", "fast_griffin_lim", "griffin_lim"):
            raise ParameterError(
                f"iteration is not one of tactogram.features.recover, got {self.iteration!r}"
            )
        if self.iterations < 0:
            raise ParameterError(f"iterations must be >= 0, got {self.iterations}")

    @cached_property
    def transform(self) -> STFT:
        """The short-time Fourier transform underneath."""
        return STFT(self.n_fft, self.hop, self.window)

    @property
    def frequencies(self) -> NDArray[np.float64]:
        """Centre of each kept bin, shape (bin,), Hz (or cycles per mm)."""
        return np.arange(self.bins or 0, dtype=np.float64) * (self.rate / self.n_fft)

    def frames(self, length: int) -> int:
        """Return the number of frames of ``length`` samples: ``1 + ceil(length / hop)``."""
        return self.transform.frames(length)

    def length(self, frames: int) -> int:
        """Return the greatest number of samples that has ``frames`` frames."""
        return self.transform.length(frames)

    def stft(self, x: Tensor) -> Tensor:
        """Return the complex transform, (..., time) -> (..., n_fft // 2 + 1, frame); see `STFT.forward`."""
        return self.transform.forward(x)

    def istft(self, s: Tensor, length: int) -> Tensor:
        """Return the signal, complex (..., n_fft // 2 + 1, frame) -> (..., time); see `STFT.inverse`."""
        return self.transform.inverse(s, length)

    def encode(self, x: Tensor) -> Tensor:
        """Return the picture of ``x``. Differentiable.

        Parameters
        ----------
        x : float32 or float64 tensor, shape (..., time), ``unit``

        Returns
        -------
        tensor, shape (..., bin, frame), in ``low..high``
        """
        return self.value(self.amplitudes(self.stft(x)))

    def amplitudes(self, s: Tensor) -> Tensor:
        """Return the amplitudes (of a sinusoid, ``unit``) in a result of `stft`. Differentiable.

        Complex (..., n_fft // 2 + 1, frame) -> (..., bin, frame): the bins that are kept.
        """
        return s[..., : self.bins, :].abs() / self._gain(s)[: self.bins]

    def magnitude(self, z: Tensor) -> Tensor:
        """Return the magnitude of `stft` that a picture stands for.

        Parameters
        ----------
        z : float32 or float64 tensor, shape (..., bin, frame), in ``low..high``

        Returns
        -------
        tensor, shape (..., n_fft // 2 + 1, frame)
            Bins that are not kept, and with ``"db"`` values at the floor, are 0.

        Raises
        ------
        ParameterError
            For another shape or dtype, or values that are not finite.
        """
        if z.dtype not in (torch.float32, torch.float64):
            raise ParameterError(f"z must be float32 or float64, got {z.dtype}")
        if z.ndim < 2 or z.shape[-2] != self.bins or z.shape[-1] == 0:
            raise ParameterError(f"z must be (..., {self.bins} bins, frame), got {tuple(z.shape)}")
        kept = self.amplitude(z) * self._gain(z)[: self.bins]
        return F.pad(kept, (0, 0, 0, self.transform.bins - z.shape[-2]))

    def decode(self, z: Tensor, length: int | None = None, *, seed: int = 0) -> Tensor:
        """Return a signal whose picture is as near to ``z`` as phase recovery brings it.

        Parameters
        ----------
        z : float32 or float64 tensor, shape (..., bin, frame), in ``low..high``
            No gradient flows back.
        length : int, samples, optional
            Of the signal; by default the greatest that has the frames of ``z``.
        seed : int
            The same seed gives the same signal, in a batch as alone.

        Returns
        -------
        tensor, shape (..., time), ``unit``

        Raises
        ------
        ParameterError
            If ``z`` is not finite or not a picture of ``length`` samples.
        """
        return self._recovered(self.magnitude(z.detach()), length, seed)

    def recover(self, amplitudes: Tensor, length: int | None = None, *, seed: int = 0) -> Tensor:
        """Return samples of the `amplitudes`, shape (..., n_fft // 2 + 1, frame), >= 0, ``unit``; else as `decode`."""
        return self._recovered(amplitudes.detach() * self._gain(amplitudes), length, seed)

    def _recovered(self, magnitude: Tensor, length: int | None, seed: int) -> Tensor:
        return recover(
            magnitude,
            self.transform,
            self.length(magnitude.shape[-1]) if length is None else length,
            start=self.start,
            iteration=self.iteration,
            iterations=self.iterations,
            seed=seed,
        )

    def encode_signal(self, signal: Signal) -> Tensor:
        """Return the picture of a signal, float32, shape (axis, bin, frame).

        Raises
        ------
        UnitError, ParameterError
            If unit, domain or rate are others than the fields say.
        """
        self.check_signal(signal)
        return self.encode(torch.tensor(signal.samples))

    def decode_signal(
        self, z: Tensor, length: int | None = None, *, axes: tuple[str, ...] = (), seed: int = 0
    ) -> Signal:
        """Return the signal of a picture of shape (bin, frame) or (axis, bin, frame); see `decode`."""
        samples = self.decode(z, length, seed=seed).cpu().numpy()
        return Signal(samples, self.rate, self.unit, axes, self.domain)

    def _gain(self, like: Tensor) -> Tensor:
        """Return what `stft` makes of a sinusoid of amplitude 1 in the middle of each bin, shape (bin, 1)."""
        total = self.transform.weights(like).sum()
        gain = (total / 2).repeat(self.transform.bins, 1)
        gain[0] = total
        if self.n_fft % 2 == 0:
            gain[-1] = total
        return gain
