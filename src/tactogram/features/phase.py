"""Phase recovery: a signal from the magnitude of its short-time Fourier transform.

benchmarks/bench_phase.py is the reason for the defaults of `recover`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, get_args

import torch
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.phase_gradient import gradient_phase
from tactogram.features.stft import STFT, Projection, check_precision

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
        raise ParameterError(f"start must be 'gradient' or 'random', got {start!r}")
    if iteration not in ITERATIONS:
        raise ParameterError(f"iteration must be one of {', '.join(ITERATIONS)}, got {iteration!r}")
    if iterations < 0:
        raise ParameterError(f"iterations must be >= 0, got {iterations}")
    with torch.no_grad():
        target = magnitude.detach().reshape(-1, *magnitude.shape[-2:]).mT.contiguous()  # batch, frame, bin
        if not bool((torch.isfinite(target) & (target >= 0)).all()):
            raise ParameterError("magnitude must be finite and >= 0, got a value that is not")
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


def _griffin_lim(s: Tensor, target: Tensor, project: Projection, iterations: int) -> Tensor:
    for _ in range(iterations):
        s = _with_magnitude(project(s), target)
    return s


def _admm_then_fast(s: Tensor, target: Tensor, project: Projection, iterations: int) -> Tensor:
    s = _admm(s, target, project, iterations - iterations // 2)
    return _fast_griffin_lim(s, target, project, iterations // 2)


ITERATIONS: dict[str, Callable[[Tensor, Tensor, Projection, int], Tensor]] = {
    "admm+fast_griffin_lim": _admm_then_fast,
    "admm": _admm,
    "fast_griffin_lim": _fast_griffin_lim,
    "griffin_lim": _griffin_lim,
}


def _with_magnitude(s: Tensor, target: Tensor) -> Tensor:
    """Give ``s`` the magnitude ``target``, in place, without the expensive angle and exponential."""
    parts = torch.view_as_real(s)
    gain = parts[..., 0].square().addcmul_(parts[..., 1], parts[..., 1])
    gain.clamp_min_(torch.finfo(gain.dtype).tiny).rsqrt_().mul_(target)
    return s.mul_(gain)
