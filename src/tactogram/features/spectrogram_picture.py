"""Spectrogram picture: a recording <-> the square picture of an image network."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import torch
import torch.nn.functional as F
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.phase import Iteration, Start
from tactogram.features.spectrogram import Spectrogram
from tactogram.features.stft import Window, check_precision
from tactogram.signal import Signal
from tactogram.signal.signal import Domain


@dataclass(frozen=True, kw_only=True)
class SpectrogramPicture:
    """A log-magnitude spectrogram as a picture of one channel in [-1, 1], and its inverse.

    The convention of Neshov et al. 2026 (Sec. 4.1, "Vibrotactile Data"): short-time Fourier transform with a
    Hamming window of 512 and a hop of 128, 257 x 376 magnitudes of a recording of 4.8 s at 10 kHz; 256
    consecutive frames of it; resized to 256 x 256; logarithm; [-1, 1]. ``picture.crop(samples, first)`` is that.
    Tensors are float32 or float64.

    Raises `ParameterError` if a field is invalid.

    Parameters
    ----------
    rate : float
        Samples per second (Hz), or per millimetre when ``domain`` is ``"displacement"``.
    floor_db, ceiling_db : float, dB re 1 ``unit``
        Amplitudes (of a sinusoid) that are -1 and 1. Fixed, never measured from a picture, or levels would be lost; the
        paper states none.
    unit : str
        Unit of a sample, one of `tactogram.signal.UNITS`.
    domain : {"time", "displacement"}
    n_fft, hop : int, samples
    window : str or (str, float)
        Name for `scipy.signal.get_window`.
    frames : int
        Frames of a picture: 256 at 10 kHz are 3.28 s.
    rows, columns : int
        Size of the picture; row 0 is 0 Hz. Amplitudes are resized bilinearly, before the logarithm.
    start, iteration, iterations
        Phase recovery of `signal`; see `tactogram.features.recover`. The paper names Griffin-Lim.

    Notes
    -----
    Losses, each a test in ``tests/features/test_spectrogram_picture.py``:

    * phase, which `signal` recovers;
    * amplitudes at or below the floor, which become 0, and above the ceiling, which become the ceiling;
    * of 257 bins in 256 rows, one pattern per column: alternate bins up and down around the middle row. The inverse
      takes the smoothest column that fits, and is otherwise exact. With fewer rows, detail finer than a row is lost.

    Levels are absolute: samples times 0.01 are inverted to samples times 0.01 if they stay above the floor.
    """

    rate: float
    floor_db: float
    ceiling_db: float
    unit: str = "m/s^2"
    domain: Domain = "time"
    n_fft: int = 512
    hop: int = 128
    window: Window = "hamming"
    frames: int = 256
    rows: int = 256
    columns: int = 256
    start: Start = "gradient"
    iteration: Iteration = "admm+fast_griffin_lim"
    iterations: int = 64

    def __post_init__(self) -> None:
        object.__setattr__(self, "window", self.spectrogram.transform.window)
        for name in ("frames", "rows", "columns"):
            value = getattr(self, name)
            if not (isinstance(value, int) and value >= 2):
                raise ParameterError(f"{name} must be a whole number >= 2, got {value}")

    @cached_property
    def spectrogram(self) -> Spectrogram:
        """The spectrogram underneath: transform, levels and phase recovery."""
        return Spectrogram(
            rate=self.rate,
            unit=self.unit,
            domain=self.domain,
            floor_db=self.floor_db,
            ceil_db=self.ceiling_db,
            n_fft=self.n_fft,
            hop=self.hop,
            window=self.window,
            start=self.start,
            iteration=self.iteration,
            iterations=self.iterations,
        )

    @property
    def bins(self) -> int:
        """Number of frequency bins: ``n_fft // 2 + 1``."""
        return self.n_fft // 2 + 1

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of a picture: (1, rows, columns)."""
        return (1, self.rows, self.columns)

    @property
    def length(self) -> int:
        """Samples of `signal`: from the middle of the first frame to that of the last."""
        return (self.frames - 1) * self.hop

    def places(self, length: int) -> int:
        """Return the number of crops in ``length`` samples: `crop` takes ``first`` below it.

        Raises `ParameterError` if the recording is shorter than a picture.
        """
        frames = self.spectrogram.frames(length)
        if frames < self.frames:
            per = "s" if self.domain == "time" else "mm"
            raise ParameterError(
                f"a picture of {self.frames} frames is {self.length / self.rate:.3g} {per} long, the recording "
                f"{length / self.rate:.3g} {per} ({frames} frames): take fewer frames or a smaller hop"
            )
        return frames - self.frames + 1

    def encode(self, samples: Tensor) -> Tensor:
        """Return the picture of samples with ``frames`` frames, e.g. `length`: (..., time) -> (..., 1, rows, columns).

        In [-1, 1]. Differentiable.

        Raises `ParameterError` for another number of frames.
        """
        got = self.spectrogram.frames(samples.shape[-1])
        if got != self.frames:
            raise ParameterError(
                f"{self.length} samples are a picture of {self.frames} frames, got {samples.shape[-1]} samples "
                f"({got} frames); crop() cuts a longer recording"
            )
        return self.crop(samples, 0)

    def crop(self, samples: Tensor, first: int) -> Tensor:
        """Return the picture of frames ``first`` to ``first + frames`` of a recording's spectrogram.

        From shape (..., time) to (..., 1, rows, columns), in [-1, 1]; ``first`` is 0 to `places` - 1. Only the samples
        of those frames are used, with the neighbours that their windows reach.

        Raises `ParameterError` if the recording lacks these frames.
        """
        if not 0 <= first < self.places(samples.shape[-1]):
            raise ParameterError(
                f"first frame must be in 0..{self.places(samples.shape[-1]) - 1}, got {first}"
            )
        start, stop = self.span(first)
        first -= start // self.hop
        s = self.spectrogram.stft(samples[..., start:stop])[..., first : first + self.frames]
        return self.picture(self.spectrogram.amplitudes(s))

    def span(self, first: int) -> tuple[int, int]:
        """Return the first and last (exclusive) sample that `crop` uses; the first begins a frame."""
        margin = -(-self.n_fft // (2 * self.hop))  # frames whose windows still reach into the crop
        return max(0, first - margin) * self.hop, (first + self.frames - 1 + margin) * self.hop

    def picture(self, amplitudes: Tensor) -> Tensor:
        """Return amplitudes, >= 0, ``unit``, as a picture. Differentiable.

        From shape (..., n_fft // 2 + 1, frames) to (..., 1, rows, columns), in [-1, 1].

        Raises `ParameterError` for another shape.
        """
        if amplitudes.shape[-2:] != (self.bins, self.frames):
            raise ParameterError.must(
                "amplitudes", f"be (..., {self.bins} bins, {self.frames} frames)", tuple(amplitudes.shape)
            )
        resized = _matrix(self.bins, self.rows).to(amplitudes) @ amplitudes  # ..., row, frame
        if self.columns != self.frames:
            resized = resized @ _matrix(self.frames, self.columns).to(amplitudes).mT
        return self.spectrogram.value(resized).unsqueeze(-3)

    def decode(self, pictures: Tensor) -> Tensor:
        """Return the amplitudes of pictures, >= 0, ``unit``, as of a sinusoid in `Spectrogram`.

        From shape (..., 1, rows, columns), in [-1, 1], to (..., n_fft // 2 + 1, frames).

        Raises `ParameterError` for another dtype or shape, or values that are not finite.
        """
        check_precision("pictures", pictures)
        if pictures.shape[-3:] != self.shape:
            raise ParameterError.must("pictures", f"be (..., {self.shape})", tuple(pictures.shape))
        # The inverse amplifies rounding where rows share bins, hence double precision.
        resized = self.spectrogram.amplitude(pictures.squeeze(-3).double())
        spread = _inverse(self.bins, self.rows).to(resized) @ resized
        if self.columns != self.frames:
            spread = spread @ _inverse(self.frames, self.columns).to(resized).mT
        return spread.clamp_min(0).to(pictures.dtype)

    def signal(self, pictures: Tensor, *, seed: int) -> Tensor:
        """Return samples whose pictures are close to ``pictures``. No gradient flows back.

        From shape (..., 1, rows, columns), in [-1, 1], to (..., `length`), ``unit``. The same seed gives the same
        samples, in a batch as alone.
        """
        return self.spectrogram.recover(self.decode(pictures.detach()), self.length, seed=seed)

    def noise(self, pictures: Tensor, *, smooth: int, seed: int) -> Tensor:
        """Return Gaussian noise with the levels of ``pictures`` at each frequency and moment.

        For pictures whose grain no signal has: they are smoothed, and noise, which has the grain of a real texture,
        gets the remaining levels. A picture smoothed over all its columns gives steady noise of its mean logarithmic
        spectrum. Constant parts stay constant, with the sign +. Periodic parts and lasting tones are lost.

        ``smooth`` is the odd number of columns of the Hann window that smooths levels, in dB; 1 does not smooth.
        Shapes and ``seed`` as in `signal`.

        Raises `ParameterError` if ``smooth`` is even or below 1, or for pictures of another shape.
        """
        if smooth < 1 or smooth % 2 == 0:
            raise ParameterError.must("smooth", "be an odd number of columns", smooth)
        amplitudes = self.decode(_smoothed(pictures.detach().double(), smooth))
        floor = self.spectrogram.amplitude(torch.tensor(-1.0, dtype=torch.float64)).clamp_min(1e-30)
        white = torch.randn(
            self.length, dtype=torch.float64, generator=torch.Generator().manual_seed(seed)
        ).to(amplitudes)
        s = self.spectrogram.stft(white)
        grain = torch.log(self.spectrogram.amplitudes(s)[1:-1])
        # A mean of few logarithms retains some grain, and grain adds power: subtract what it adds to noise.
        left = _smoothed(grain, smooth) - grain.mean()
        grain_level = grain.mean() + torch.log(torch.exp(2 * left).mean()) / 2
        # Constant parts, as gravity, are no noise: subtract them from all bins they leak into, and add them again.
        lowest, next_one = (amplitudes[..., row, :].mean(-1, keepdim=True) for row in (0, 1))
        constant = torch.where(lowest > next_one, lowest, 0.0)  # ..., 1; else leakage from above
        leak = self.spectrogram.amplitudes(self.spectrogram.stft(torch.ones_like(white)))[:, self.frames // 2]
        leaked = 1.5 * constant[..., None] * leak[:, None]  # ..., bin, 1; includes the blur of resizing
        varying = (amplitudes.square() - leaked.square()).clamp_min(floor.item() ** 2).sqrt()
        gain = torch.exp(torch.log(varying) - grain_level)
        return (self.spectrogram.istft(s * gain, self.length) + constant).to(pictures.dtype)


def reconstructed(signal: Signal, *, start: Start, iteration: Iteration, seed: int) -> Signal:
    """Return a signal after its conversion to a spectrogram picture and back, each axis by itself.

    What an image network that made no error would return. Window and hop last as long as the published ones, 51.2 and
    12.8 ms; 80 dB below the largest amplitude, rounded up to 5 dB, are kept (assumed, as in the models). ``start``,
    ``iteration`` and ``seed`` are those of the phase recovery.
    """
    samples = torch.tensor(signal.samples)
    hop = max(2, round(0.0128 * signal.rate))
    frames = max(2, -(-len(signal) // hop) + 1)
    picture = SpectrogramPicture(
        rate=signal.rate,
        unit=signal.unit,
        domain=signal.domain,
        floor_db=-80.0,
        ceiling_db=0.0,
        n_fft=4 * hop,
        hop=hop,
        frames=frames,
        rows=2 * hop,
        columns=frames,
        start=start,
        iteration=iteration,
    )
    samples = F.pad(samples, (0, picture.length - len(signal)))
    largest = picture.spectrogram.amplitudes(picture.spectrogram.stft(samples)).max().item()
    if largest == 0:
        return signal
    ceiling = 5.0 * math.ceil(20 * math.log10(largest) / 5)
    picture = replace(picture, ceiling_db=ceiling, floor_db=ceiling - 80.0)
    back = picture.signal(picture.encode(samples), seed=seed)[..., : len(signal)]
    return signal.with_samples(back.numpy())


def _smoothed(pictures: Tensor, columns: int) -> Tensor:
    """Return pictures averaged along time by a Hann window, its weights summing to 1 at the edges, too."""
    if columns == 1:
        return pictures
    window = torch.hann_window(columns + 2, periodic=False, dtype=pictures.dtype, device=pictures.device)[
        1:-1
    ]
    rows = pictures.reshape(-1, 1, pictures.shape[-1])
    around = F.conv1d(rows, window[None, None], padding=columns // 2)
    share = F.conv1d(torch.ones_like(rows[:1]), window[None, None], padding=columns // 2)
    return (around / share).reshape(pictures.shape)


@lru_cache(maxsize=64)
def _matrix(size: int, new_size: int) -> Tensor:
    """Return the matrix that resizes a column, float64, shape (new_size, size), >= 0; its rows sum to 1."""
    eye = torch.eye(size, dtype=torch.float64)
    if size == new_size:
        return eye
    resized = F.interpolate(eye[None, None], (new_size, size), mode="bilinear", antialias=True)
    return resized[0, 0]


@lru_cache(maxsize=64)
def _inverse(size: int, new_size: int) -> Tensor:
    """Return an inverse of `_matrix`, float64, shape (size, new_size).

    Of all columns that resize to a given one the smoothest, of least summed squared difference between neighbours. With
    more rows than bins at most one column fits, found by least squares.
    """
    matrix = _matrix(size, new_size)
    inverse: Tensor
    if new_size >= size:
        inverse = torch.linalg.pinv(matrix)
    else:
        difference = torch.diff(torch.eye(size, dtype=torch.float64), dim=0)
        rough = difference.mT @ difference + 1e-7 * torch.eye(
            size, dtype=torch.float64
        )  # or a constant is free
        spread = torch.linalg.solve(rough, matrix.mT)  # size, new_size
        inverse = torch.linalg.solve((matrix @ spread).mT, spread.mT).mT
    return inverse
