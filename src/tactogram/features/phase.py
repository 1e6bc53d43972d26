"""Phase recovery: a signal from the magnitude of its short-time Fourier transform.

benchmarks/bench_phase.py is the reason for the defaults of `recover`. The phase that `gradient_phase` begins with is
that of Průša, Balazs & Søndergaard, "A noniterative method for reconstruction of phase from STFT magnitude",
IEEE/ACM Trans. Audio, Speech, Lang. Process. 25(5), 2017.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache, partial
from heapq import heappop, heappush
from typing import Any, Literal, get_args

import numpy as np
import torch
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.signal import get_window
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.stft import STFT, Projection, Window, check_precision

Start = Literal["gradient", "random"]
STARTS: tuple[Start, ...] = get_args(Start)
RHO = 0.2
"""Inconsistency that `admm` tolerates: 0 never settles, 1 is Griffin-Lim."""
MOMENTUM = 0.99
"""Of `fast_griffin_lim`."""
Iteration = Literal["admm+fast_griffin_lim", "admm", "fast_griffin_lim", "griffin_lim"]


def recover(
    magnitude: Tensor,
    transform: STFT,
    length: int,
    *,
    start: Start = "gradient",
    iteration: Iteration = "admm+fast_griffin_lim",
    iterations: int = 32,
    seed: int = 0,
) -> Tensor:
    """Return a signal whose transform has about ``magnitude``.

    Each item is scaled by itself, so that a magnitude times a gain gives the signal times the gain.

    ``magnitude``, float32 or float64, shape (..., bin, frame), is of ``transform``, finite and >= 0; the signal has
    shape (..., length). No gradient flows back. Every item of a batch gets the same random numbers, as it would alone.

    ``start`` is the first phase: phase gradient heap integration (`gradient_phase`) or uniform noise. ``iteration``
    is ``griffin_lim``, alternating projections (Griffin & Lim 1984); ``fast_griffin_lim``, the same with momentum
    0.99 (Perraudin, Balazs & Søndergaard, "A fast Griffin-Lim algorithm", WASPAA 2013); ``admm``, the alternating
    direction method of multipliers (Masuyama, Yatabe & Oikawa 2019); or half the steps of that, which leaves wrong
    solutions, then half with momentum, which settles. A step is one inverse and one forward transform; 0
    ``iterations`` return the start.
    """
    check_precision("magnitude", magnitude)
    transform.check(magnitude, length)
    if start not in STARTS:
        raise ParameterError.must("start", "be 'gradient' or 'random'", start)
    if iteration not in ITERATIONS:
        raise ParameterError.one_of("iteration", ITERATIONS, iteration)
    if iterations < 0:
        raise ParameterError.must("iterations", "be >= 0", iterations)
    with torch.no_grad():
        target = magnitude.detach().reshape(-1, *magnitude.shape[-2:]).mT.contiguous()  # batch, frame, bin
        if not bool((torch.isfinite(target) & (target >= 0)).all()):
            raise ParameterError.must("magnitude", "be finite and >= 0, got a value that is not")
        scale = target.amax((1, 2), keepdim=True)
        target = target / torch.where(scale > 0, scale, 1)
        if start == "gradient":
            phase = gradient_phase(target, transform, seed=seed)
        else:
            random = torch.Generator().manual_seed(seed)
            phase = 2 * math.pi * torch.rand(target.shape[1:], generator=random, dtype=torch.float64)
        phase = torch.remainder(phase, 2 * math.pi).to(target)
        s = torch.polar(target, phase.expand_as(target))
        project = Projection(transform, s, length)
        x = project.signal(ITERATIONS[iteration](s, target, project, iterations)) * scale[..., 0]
        return x.reshape(*magnitude.shape[:-2], length)


def spectral_convergence(x: Tensor, magnitude: Tensor, transform: STFT) -> Tensor:
    """Return the distance of the magnitude of ``x`` from ``magnitude``: lower is better.

    ``20 log10( || |STFT(x)| - A || / ||A|| )`` over all bins and frames, with the STFT of the magnitude ``A``
    (Sturmel & Daudet 2011). It measures the recovered signal, not an intermediate spectrogram.

    From shapes (..., time) and (..., bin, frame) to (...), dB.
    """
    error = (transform.forward(x).abs() - magnitude).square().sum((-2, -1))
    return 10 * torch.log10(error / magnitude.square().sum((-2, -1)))


def _admm(s: Tensor, target: Tensor, project: Projection, iterations: int, *, rho: float = RHO) -> Tensor:
    """Improve ``s`` by the alternating direction method of multipliers.

    Masuyama, Yatabe & Oikawa, "Griffin-Lim like phase recovery via ADMM", IEEE Signal Process. Lett. 26(1), 2019. Its
    three updates share only ``v``, the magnitude-constrained copy plus the multiplier. ``rho`` is the tolerated
    inconsistency.
    """
    v = s.clone()
    for _ in range(iterations):
        z = project(v).add_(v, alpha=rho).div_(1 + rho)
        v.sub_(z)  # the multiplier
        s = _with_magnitude(z.sub_(v), target)
        v.add_(s)
    return s


def _fast_griffin_lim(
    s: Tensor, target: Tensor, project: Projection, iterations: int, *, momentum: float = MOMENTUM
) -> Tensor:
    last: Tensor | None = None
    for _ in range(iterations):
        consistent = project(s)
        ahead = consistent.clone() if last is None else consistent.lerp(last, -momentum)
        last = consistent
        s = _with_magnitude(ahead, target)
    return s


def _admm_then_fast(s: Tensor, target: Tensor, project: Projection, iterations: int) -> Tensor:
    s = _admm(s, target, project, iterations - iterations // 2)
    return _fast_griffin_lim(s, target, project, iterations // 2)


ITERATIONS: dict[str, Callable[[Tensor, Tensor, Projection, int], Tensor]] = {
    "admm+fast_griffin_lim": _admm_then_fast,
    "admm": _admm,
    "fast_griffin_lim": _fast_griffin_lim,
    "griffin_lim": partial(_fast_griffin_lim, momentum=0.0),
}


def _with_magnitude(s: Tensor, target: Tensor) -> Tensor:
    """Give ``s`` the magnitude ``target``, in place, without the expensive angle and exponential."""
    parts = torch.view_as_real(s)
    gain = parts[..., 0].square().addcmul_(parts[..., 1], parts[..., 1])
    gain.clamp_min_(torch.finfo(gain.dtype).tiny).rsqrt_().mul_(target)
    return s.mul_(gain)


def gradient_phase(magnitude: Tensor, transform: STFT, *, seed: int = 0, tolerance: float = 1e-6) -> Tensor:
    """Return the phase of ``magnitude`` as if its window were a Gaussian (the paper's algorithm 1).

    Two details are ours. A real signal's magnitude is even about 0 Hz and half the rate, so the frequency derivative
    uses that mirror image: without it the phase at 0 Hz drifts, and signals with most of their energy there are
    recovered worse (by 6 to 25 dB on rectified sensor recordings). And next to bins below ``tolerance`` the difference
    is one-sided, so that ignored bins do not distort the phase of their neighbours.

    ``magnitude`` is of ``transform``, >= 0, shape (batch, frame, bin): bins run fastest, unlike in `STFT`. Magnitudes
    up to ``tolerance``, as a share of an item's greatest, get a random phase, the same for every item. Returns radians,
    float64, of the same shape, on the processor.
    """
    n_fft, hop = transform.n_fft, transform.hop
    gamma = window_gamma(transform.window, n_fft)
    size = magnitude.detach().cpu().double()
    sure = size > tolerance * size.amax((1, 2), keepdim=True)
    log = torch.where(sure, size, 1).log()
    last = 1 if n_fft % 2 == 0 else 0
    mirrored = torch.cat([log[..., 1:2], log, log[..., -1 - last : log.shape[-1] - last]], -1)
    mirrored_sure = torch.cat([sure[..., 1:2], sure, sure[..., -1 - last : log.shape[-1] - last]], -1)
    over_bins = _difference(mirrored, mirrored_sure, -1)
    over_frames = torch.nn.functional.pad(log, (0, 0, 1, 1))
    over_frames = _difference(over_frames, torch.nn.functional.pad(sure, (0, 0, 1, 1)), 1)
    # Steps of the phase from frame to frame and from bin to bin: its partial derivatives follow from those of
    # the log magnitude (Sec. III). The second has its last term because the transform counts time from a frame's
    # first sample, not from its centre.
    bins = torch.arange(log.shape[-1], dtype=torch.float64)
    along_time = over_bins * (hop * n_fft / gamma) + 2 * math.pi * hop / n_fft * bins
    along_bins = over_frames * (-gamma / (hop * n_fft)) - 2 * math.pi * (n_fft // 2) / n_fft
    random = torch.Generator().manual_seed(seed)
    start = 2 * math.pi * torch.rand(log.shape[1:], generator=random, dtype=torch.float64)
    phase = start.expand(log.shape).clone()
    for k in range(len(phase)):
        order = np.argsort(-size[k].float().numpy().ravel()).astype(np.int64)
        _integrate(
            size[k].numpy(), along_time[k].numpy(), along_bins[k].numpy(),
            (~sure[k]).numpy(), order, phase[k].numpy(),
        )  # fmt: skip
    return phase


@lru_cache(maxsize=64)
def window_gamma(window: Window, n_fft: int) -> float:
    """Return gamma, in samples squared, of the Gaussian exp(-pi l^2 / gamma) nearest to ``window``.

    Nearest in the least-squares sense. Within 2 % of the constants of the authors' toolbox for Hann
    (0.25645 n_fft^2), Hamming (0.29794) and Blackman (0.17954).
    """
    values = get_window(window, n_fft)
    time = np.arange(n_fft) - n_fft / 2

    def distance(share: float) -> float:
        gaussian = np.exp(-np.pi * time**2 / (share * n_fft**2))
        return float(np.sum((values / values.max() - gaussian) ** 2))

    return float(minimize_scalar(distance, bounds=(1e-3, 4), method="bounded").x) * n_fft**2


def _difference(log: Tensor, sure: Tensor, dim: int) -> Tensor:
    """Return the mean difference to the sure neighbours; two shorter along ``dim``."""
    n = log.shape[dim]
    before, here, after = (log.narrow(dim, k, n - 2) for k in range(3))
    has_before, _, has_after = (sure.narrow(dim, k, n - 2).double() for k in range(3))
    steps = (here - before) * has_before + (after - here) * has_after
    return steps / (has_before + has_after).clamp_min(1)


@njit(cache=True, nogil=True)
def _integrate(
    size: NDArray[np.float64],
    along_time: NDArray[np.float64],
    along_bins: NDArray[np.float64],
    done: NDArray[np.bool_],
    order: NDArray[np.int64],
    phase: NDArray[Any],
) -> None:
    """Fill ``phase`` (frame, bin) in place, from the greatest magnitude outwards, where not ``done``.

    A heap holds the border of the integrated area, the greatest magnitude first; each island that it does not reach
    starts at phase 0.
    """
    frames, bins = size.shape
    for first in order:
        if done.flat[first]:
            continue
        done.flat[first] = True
        phase.flat[first] = 0.0
        heap = [(-size.flat[first], first)]
        while heap:
            _, here = heappop(heap)
            t, m = here // bins, here % bins
            for u, k in ((t + 1, m), (t - 1, m), (t, m + 1), (t, m - 1)):
                if u < 0 or u >= frames or k < 0 or k >= bins or done[u, k]:
                    continue
                if u != t:
                    step = 0.5 * (u - t) * (along_time[t, m] + along_time[u, k])
                else:
                    step = 0.5 * (k - m) * (along_bins[t, m] + along_bins[u, k])
                phase[u, k] = phase[t, m] + step
                done[u, k] = True
                heappush(heap, (-size[u, k], u * bins + k))
