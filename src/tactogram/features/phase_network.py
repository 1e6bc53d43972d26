"""Phase recovery as networks, for runtimes without this package.

The loops of `tactogram.features.phase` and of `AmplitudeSpectrogram`, on real tensors and as one graph with a loop in
it. The starting phase is an input: phase gradient heap integration is a search through a priority queue, whose order
depends on the values, and has no graph; uniform noise is the other start.
"""

from __future__ import annotations

from collections.abc import Callable

import torch
import torch.nn.functional as F
from torch import Tensor, nn
from torch._higher_order_ops.scan import scan

from tactogram.features.amplitude_spectrogram import MOMENTUM, AmplitudeSpectrogram
from tactogram.features.phase import MOMENTUM as FAST_MOMENTUM
from tactogram.features.phase import RHO, recover, spectral_convergence
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.features.stft import STFT, overlap_add

Step = Callable[[Tensor], Tensor]


def convergence_db(magnitude: Tensor, transform: STFT, samples: Tensor) -> float:
    """Return the mean `spectral_convergence` of samples, (batch, time), to magnitudes, (batch, bin, frame)."""
    return float(spectral_convergence(samples, magnitude, transform).mean())


class _Recovery(nn.Module):
    """Transform and inverse of a fixed length. Spectrograms are (batch, frame, bin, 2), real and imaginary part."""

    window: Tensor
    cover: Tensor

    def __init__(self, transform: STFT, frames: int, *, pad: str) -> None:
        super().__init__()
        self.n_fft, self.hop, self.pad = transform.n_fft, transform.hop, pad
        self.reach, self.length = transform.n_fft // 2, transform.length(frames)
        like = torch.zeros(1)
        self.register_buffer("window", transform.weights(like).clone(), persistent=False)
        cover = transform.cover(like, frames)[self.reach : self.reach + self.length]
        self.register_buffer("cover", cover.clone(), persistent=False)

    def signal(self, s: Tensor) -> Tensor:
        """Return the nearest signal, (batch, time)."""
        pieces = torch.fft.irfft(torch.view_as_complex(s.contiguous()), self.n_fft) * self.window
        x = overlap_add(pieces, self.hop)[..., self.reach : self.reach + self.length]
        return x / self.cover

    def transformed(self, x: Tensor) -> Tensor:
        """Return the transform of signals, (batch, time)."""
        padded = F.pad(x, (self.reach, self.reach), mode=self.pad)
        pieces = padded.unfold(-1, self.n_fft, self.hop) * self.window
        return torch.view_as_real(torch.fft.rfft(pieces))


class PhaseRecovery(_Recovery):
    """`tactogram.features.recover` by its default method, from a phase that is given.

    ``frames`` are those of the magnitudes; ``iterations`` >= 2.
    """

    def __init__(self, transform: STFT, frames: int, iterations: int) -> None:
        super().__init__(transform, frames, pad="constant")
        self.fast = iterations // 2
        self.admm = iterations - self.fast

    def forward(self, magnitude: Tensor, phase: Tensor) -> Tensor:
        """Return samples, (batch, time), of magnitudes, and phases in rad, both (batch, bin, frame)."""
        target = magnitude.mT  # B, T, K
        scale = target.amax((1, 2), keepdim=True)
        target = target / torch.where(scale > 0, scale, 1.0)
        start = _polar(target, phase.mT)  # B, T, K, 2

        def admm(carried: Tensor) -> Tensor:
            v = carried[..., :2]
            z = (self._projected(v) + RHO * v) / (1 + RHO)
            v = v - z
            s = _with_magnitude(z - v, target)
            return torch.cat((v + s, s), -1)

        def fast(carried: Tensor) -> Tensor:
            s, last = carried[..., :2], carried[..., 2:]
            now = self._projected(s)
            return torch.cat((_with_magnitude(now + FAST_MOMENTUM * (now - last), target), now), -1)

        s = _repeated(admm, torch.cat((start, start), -1), self.admm)[..., 2:]
        last = self._projected(s)
        s = _repeated(fast, torch.cat((_with_magnitude(last, target), last), -1), self.fast - 1)[..., :2]
        return self.signal(s) * scale[..., 0]

    def _projected(self, s: Tensor) -> Tensor:
        return self.transformed(self.signal(s))


class PicturePhaseRecovery(nn.Module):
    """`SpectrogramPicture.signal` by its default method, from a phase that is given."""

    def __init__(self, picture: SpectrogramPicture) -> None:
        super().__init__()
        self.picture = picture
        transform = picture.spectrogram.transform
        self.recovery = PhaseRecovery(transform, picture.frames, picture.iterations)

    def forward(self, pictures: Tensor, phase: Tensor) -> Tensor:
        """Return samples, (batch, time), of pictures, (batch, 1, row, column), and phases, (batch, bin, frame)."""
        samples: Tensor = self.recovery(self.magnitudes(pictures), phase)
        return samples

    def magnitudes(self, pictures: Tensor) -> Tensor:
        """Return the magnitudes of pictures, (batch, bin, frame)."""
        amplitudes = self.picture.decode(pictures)
        return amplitudes * self.picture.spectrogram.gain(amplitudes)

    def convergence_db(self, pictures: Tensor, phase: Tensor, samples: Tensor) -> float:
        """Return the distance of recovered samples from the magnitudes of their pictures."""
        return convergence_db(self.magnitudes(pictures), self.picture.spectrogram.transform, samples)

    def reference(self, pictures: Tensor, phase: Tensor) -> Tensor:
        """Return what `tactogram.features.recover` returns."""
        picture, transform = self.picture, self.picture.spectrogram.transform
        magnitudes = self.magnitudes(pictures)
        return recover(magnitudes, transform, picture.length, start=phase, iterations=picture.iterations)


class AmplitudePhaseRecovery(_Recovery):
    """`AmplitudeSpectrogram.decode` from a phase that is given, with at least one iteration."""

    def __init__(self, spectrogram: AmplitudeSpectrogram) -> None:
        transform = STFT(spectrogram.n_fft, spectrogram.hop, spectrogram.window)
        super().__init__(transform, spectrogram.frames, pad="reflect")
        self.nonnegative, self.iterations = spectrogram.nonnegative, spectrogram.iterations

    def forward(self, magnitude: Tensor, phase: Tensor) -> Tensor:
        """Return samples, (batch, time), of magnitudes, and phases in rad, both (batch, bin, frame)."""
        target = magnitude.mT

        def step(carried: Tensor) -> Tensor:
            s, last = carried[..., :2], carried[..., 2:]
            now = self.transformed(self.signal(s))
            return torch.cat((self._fitted(now + MOMENTUM * (now - last), target), now), -1)

        s = self._start(target, phase.mT)
        last = self.transformed(self.signal(s))
        first = torch.cat((self._fitted(last, target), last), -1)
        return self.signal(_repeated(step, first, self.iterations - 1)[..., :2])

    def signal(self, s: Tensor) -> Tensor:
        """Return the nearest signal, (batch, time), and none below 0 if it has none."""
        x = super().signal(s)
        return x.clamp_min(0) if self.nonnegative else x

    def _start(self, target: Tensor, phase: Tensor) -> Tensor:
        if not self.nonnegative:
            return _polar(target, phase)
        level = target[..., 0] / self.window.sum()
        slow = F.interpolate(level[:, None], size=self.length + 1, mode="linear", align_corners=True)
        of_level = self.transformed(slow[:, 0, :-1])
        more = (target - of_level.square().sum(-1).sqrt()).clamp_min(0)
        return self._fitted(of_level + _polar(more, phase), target)

    def _fitted(self, s: Tensor, target: Tensor) -> Tensor:
        s = _with_magnitude(s, target)
        if not self.nonnegative:
            return s
        level = torch.stack((target[..., :1], torch.zeros_like(target[..., :1])), -1)
        return torch.cat((level, s[..., 1:, :]), -2)


def _repeated(step: Step, start: Tensor, times: int) -> Tensor:
    """Return ``start`` after ``times`` steps: a loop in the exported graph, not as many copies of its body."""
    if times == 0:
        return start

    def body(carried: Tensor, number: Tensor) -> tuple[Tensor, Tensor]:
        return step(carried), number.clone()

    return scan(body, start, torch.zeros(times))[0]  # type: ignore[no-any-return]


def _polar(magnitude: Tensor, phase: Tensor) -> Tensor:
    return torch.stack((magnitude * phase.cos(), magnitude * phase.sin()), -1)


def _with_magnitude(s: Tensor, target: Tensor) -> Tensor:
    tiny = torch.finfo(s.dtype).tiny
    gain: Tensor = target * s.square().sum(-1).clamp_min(tiny).rsqrt()
    return s * gain[..., None]
