"""Spectrograms: a signal <-> the picture that a network sees, of bounded log magnitudes or of amplitudes.

FrictGAN generates the latter, 257 x 11, of a friction coefficient over displacement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import torch
import torch.nn.functional as F
from torch import Tensor

from tactogram.errors import ParameterError, UnitError
from tactogram.features.phase import ITERATIONS, STARTS, Iteration, Start, recover
from tactogram.features.stft import STFT, Window, check_precision, overlap_add
from tactogram.signal import UNITS, Signal
from tactogram.signal.signal import Domain

MOMENTUM = 0.99
"""Momentum of the fast Griffin-Lim algorithm (Perraudin et al. 2013); default of `librosa.griffinlim`."""
NOTHING = 1e-30
"""Magnitude below which a phase means nothing; large magnitudes over it are finite."""


@dataclass(frozen=True, kw_only=True)
class Spectrogram:
    """One spectrogram convention and its inverse.

    ``asdict(spectrogram)`` is plain JSON; saved with the weights, ``Spectrogram(**fields)`` inverts generated pictures
    later. Nothing is measured from the data, so that levels are absolute.
    Tensors are float32 or float64.

    Raises `ParameterError` if a field is invalid, or samples that the window hardly covers could not be recovered.

    Parameters
    ----------
    rate : float
        Samples per second (Hz), or per millimetre when ``domain`` is ``"displacement"``.
    unit : str
        Unit of a sample, one of `tactogram.signal.UNITS`.
    domain : {"time", "displacement"}
    floor_db, ceil_db : float, dB re 1 ``unit``
        Values are proportional to decibels. Amplitudes at or below the floor become -1 and are inverted to 0.
        Amplitudes above the ceiling become 1 and are inverted to the ceiling. A sinusoid of 1 m/s^2 in the middle of a
        bin has an amplitude of 1 m/s^2.
    n_fft, hop : int, samples
        Length of the window, and the step between windows.
    window : str or (str, float)
        Name for `scipy.signal.get_window`.
    start, iteration, iterations
        Phase recovery of `decode`; see `tactogram.features.recover`.

    Notes
    -----
    Guarantees, each a test in ``tests/features``:

    * exact: ``istft(stft(x), length) == x`` to rounding, for every length >= 1;
    * stable: ``encode(decode(z))`` is close to ``z``, for every ``z`` of a signal;
    * absolute: a signal times 0.01 is inverted to the signal times 0.01, between floor and ceiling;
    * lost are only phase and amplitudes beyond the two limits.
    """

    rate: float
    unit: str = "m/s^2"
    domain: Domain = "time"
    floor_db: float = -80.0
    ceil_db: float = 0.0
    n_fft: int = 256
    hop: int = 64
    window: Window = "hann"
    start: Start = "gradient"
    iteration: Iteration = "admm+fast_griffin_lim"
    iterations: int = 64

    def __post_init__(self) -> None:
        if not (math.isfinite(self.rate) and self.rate > 0):
            raise ParameterError.must("rate", "be > 0 and finite", self.rate)
        if not -math.inf < self.floor_db < self.ceil_db < math.inf:
            raise ParameterError.must(
                "floor_db", f"be < ceil_db, both finite, got {self.floor_db} and {self.ceil_db}"
            )
        if self.unit not in UNITS:
            raise ParameterError.one_of("unit", UNITS, self.unit)
        if self.domain not in ("time", "displacement"):
            raise ParameterError.must("domain", "be 'time' or 'displacement'", self.domain)
        object.__setattr__(self, "window", self.transform.window)
        if self.start not in STARTS:
            raise ParameterError.must("start", "be 'gradient' or 'random'", self.start)
        if self.iteration not in ITERATIONS:
            raise ParameterError.one_of("iteration", ITERATIONS, self.iteration)
        if self.iterations < 0:
            raise ParameterError.must("iterations", "be >= 0", self.iterations)

    @cached_property
    def transform(self) -> STFT:
        """The short-time Fourier transform underneath."""
        return STFT(self.n_fft, self.hop, self.window)

    def frames(self, length: int) -> int:
        """Return the number of frames of ``length`` samples: ``1 + ceil(length / hop)``."""
        return self.transform.frames(length)

    def length(self, frames: int) -> int:
        """Return the greatest number of samples with ``frames`` frames."""
        return self.transform.length(frames)

    def stft(self, x: Tensor) -> Tensor:
        """Return the complex transform, (..., time) -> (..., n_fft // 2 + 1, frame); see `STFT.forward`."""
        return self.transform.forward(x)

    def istft(self, s: Tensor, length: int) -> Tensor:
        """Return the signal, complex (..., n_fft // 2 + 1, frame) -> (..., time); see `STFT.inverse`."""
        return self.transform.inverse(s, length)

    def value(self, amplitude: Tensor) -> Tensor:
        """Return amplitudes (>= 0, in ``unit``) as values in -1..1; any shape. Differentiable."""
        db = 20 * torch.log10(amplitude.clamp_min(10 ** (self.floor_db / 20)))
        share = (db - self.floor_db) / (self.ceil_db - self.floor_db)
        return 2 * share.clamp(0, 1) - 1

    def amplitude(self, value: Tensor) -> Tensor:
        """Return values, of any shape, limited to -1..1, as amplitudes in ``unit``.

        A value that is not finite raises `ParameterError`.
        """
        if not torch.compiler.is_compiling() and not bool(torch.isfinite(value).all()):
            raise ParameterError.must("values", "be finite, got NaN or infinity")
        share = ((value + 1) / 2).clamp(0, 1)
        db = self.floor_db + (self.ceil_db - self.floor_db) * share
        return torch.where(share > 0, 10 ** (db / 20), torch.zeros_like(db))

    def encode(self, x: Tensor) -> Tensor:
        """Return the picture of ``x``, (..., time) -> (..., bin, frame) in -1..1. Differentiable."""
        return self.value(self.amplitudes(self.stft(x)))

    def amplitudes(self, s: Tensor) -> Tensor:
        """Return the amplitudes (of a sinusoid, ``unit``) in a result of `stft`; same shape. Differentiable."""
        return s.abs() / self.gain(s)

    def magnitude(self, z: Tensor) -> Tensor:
        """Return the magnitude of `stft` of a picture, (..., bin, frame); 0 at the floor.

        Raises `ParameterError` for another shape or dtype, or values that are not finite.
        """
        check_precision("z", z)
        bins = self.transform.bins
        if z.ndim < 2 or z.shape[-2] != bins or z.shape[-1] == 0:
            raise ParameterError.must("z", f"be (..., {bins} bins, frame)", tuple(z.shape))
        return self.amplitude(z) * self.gain(z)

    def decode(self, z: Tensor, length: int | None = None, *, seed: int = 0) -> Tensor:
        """Return a signal whose picture is close to ``z``, by phase recovery: (..., bin, frame) -> (..., time).

        No gradient flows back. ``length``, samples, is by default the greatest with the frames of ``z``. The same seed
        gives the same signal, in a batch as alone.

        Raises `ParameterError` if ``z`` is not finite or not a picture of ``length`` samples.
        """
        return self._recovered(self.magnitude(z.detach()), length, seed)

    def recover(self, amplitudes: Tensor, length: int | None = None, *, seed: int = 0) -> Tensor:
        """Return samples of the `amplitudes`, shape (..., n_fft // 2 + 1, frame), >= 0, ``unit``; else as `decode`."""
        return self._recovered(amplitudes.detach() * self.gain(amplitudes), length, seed)

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

    def check_signal(self, signal: Signal) -> None:
        """Refuse a signal of another unit or domain (`UnitError`) or rate (`ParameterError`)."""
        if signal.unit != self.unit:
            raise UnitError(f"signal must be in {self.unit}, got {signal.unit}")
        if signal.domain != self.domain:
            raise UnitError(f"signal must be over {self.domain}, got one over {signal.domain}")
        if signal.rate != self.rate:
            raise ParameterError.must(
                "signal", f"have rate {self.rate:g}", signal.rate, remedy="resample it first"
            )

    def encode_signal(self, signal: Signal) -> Tensor:
        """Return the picture of a signal, float32, shape (axis, bin, frame); errors as `check_signal`."""
        self.check_signal(signal)
        return self.encode(torch.tensor(signal.samples))

    def decode_signal(
        self, z: Tensor, length: int | None = None, *, axes: tuple[str, ...] = (), seed: int = 0
    ) -> Signal:
        """Return the signal of a picture of shape (bin, frame) or (axis, bin, frame); see `decode`."""
        samples = self.decode(z, length, seed=seed).cpu().numpy()
        return Signal(samples, self.rate, self.unit, axes, self.domain)

    def gain(self, like: Tensor) -> Tensor:
        """Return the magnitude of `stft` of a sinusoid of amplitude 1 in the middle of each bin, shape (bin, 1)."""
        total = self.transform.weights(like).sum()
        gain = (total / 2).repeat(self.transform.bins, 1)
        gain[0] = total
        if self.n_fft % 2 == 0:
            gain[-1] = total
        return gain


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
            raise ParameterError.must(
                "frames",
                f"be more than {self.n_fft // 2 // self.hop + 1}, so that (frames - 1) * {self.hop} samples "
                f"can be mirrored by {self.n_fft // 2}; got {self.frames}",
            )
        if self.n_fft % 2:
            raise ParameterError.must("n_fft", "be even", self.n_fft)
        if self.iterations < 0:
            raise ParameterError.must("iterations", "be >= 0", self.iterations)

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
        Raises `ParameterError` if the length or precision is another.
        """
        check_precision("x", x)
        if x.ndim == 0 or x.shape[-1] != self.length:
            raise ParameterError.must("x", f"be (..., {self.length} samples)", tuple(x.shape))
        return self._forward(x.reshape(-1, self.length)).abs().mT.reshape(*x.shape[:-1], self.bins, -1)

    def decode(self, magnitude: Tensor, *, seed: int = 0) -> Tensor:
        """Return a signal of about these magnitudes, by the fast Griffin-Lim algorithm from a random phase.

        ``(..., n_fft // 2 + 1, frames) -> (..., length)``; magnitudes are finite and >= 0. No gradient flows back. The
        same seed gives the same signal, in a batch as alone. Raises `ParameterError` if they are not of this shape,
        finite and >= 0.
        """
        check_precision("magnitude", magnitude)
        if magnitude.shape[-2:] != (self.bins, self.frames):
            raise ParameterError.must(
                "magnitude", f"be (..., {self.bins} bins, {self.frames} frames)", tuple(magnitude.shape)
            )
        with torch.no_grad():
            target = magnitude.detach().reshape(-1, self.bins, self.frames).mT  # batch, frame, bin
            if not bool((torch.isfinite(target) & (target >= 0)).all()):
                raise ParameterError.must("magnitude", "be finite and >= 0, got a value that is not")
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
