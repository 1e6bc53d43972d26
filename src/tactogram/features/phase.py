"""A signal from the magnitude of its short-time Fourier transform.

Every function takes a magnitude and gives the signal; the same seed gives the same signal. `recover` puts
a start and an iteration together; benchmarks/bench_phase.py is where its defaults were chosen.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import torch
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.phase_gradient import gradient_phase
from tactogram.features.stft import STFT, Projection

Start = Literal["gradient", "random"]
Iteration = Literal["admm+fast_griffin_lim", "admm", "fast_griffin_lim", "griffin_lim"]


def griffin_lim(
    magnitude: Tensor,
    transform: STFT,
    length: int,
    *,
    iterations: int = 32,
    start: Start = "random",
    seed: int = 0,
) -> Tensor:
    """Return a signal by alternating projections (Griffin & Lim 1984); shapes and errors as of `recover`."""
    return recover(
        magnitude, transform, length, start=start, iteration="griffin_lim", iterations=iterations, seed=seed
    )


def fast_griffin_lim(
    magnitude: Tensor,
    transform: STFT,
    length: int,
    *,
    iterations: int = 32,
    start: Start = "random",
    seed: int = 0,
) -> Tensor:
    """Return a signal by alternating projections with momentum 0.99 (Perraudin et al. 2013); else as `griffin_lim`."""
    return recover(
        magnitude,
        transform,
        length,
        start=start,
        iteration="fast_griffin_lim",
        iterations=iterations,
        seed=seed,
    )


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
    """Return a signal whose transform has ``magnitude``, as nearly as ``iterations`` steps come to it.

    Each item is computed at its own scale, so a magnitude times a gain gives the signal times the gain.

    Parameters
    ----------
    magnitude : float32 or float64 tensor, shape (..., bin, frame)
        Of ``transform``, finite and >= 0. No gradient flows back.
    transform : STFT
    length : int, samples
        Of the signal.
    start : {"gradient", "random"}
        First phase: phase gradient heap integration (`gradient_phase`), or uniform noise.
    iteration : {"admm+fast_griffin_lim", "admm", "fast_griffin_lim", "griffin_lim"}
        What improves it: alternating projections (Griffin & Lim 1984); the same with momentum 0.99
        (Perraudin, Balazs & Søndergaard, "A fast Griffin-Lim algorithm", WASPAA 2013); the alternating
        direction method of multipliers (Masuyama, Yatabe & Oikawa 2019); or half the steps of that, which
        leaves wrong solutions, and then half with momentum, which settles.
    iterations : int
        Number of steps, each one inverse and one forward transform; 0 leaves the start.
    seed : int
        Of all that is random; every item of a batch gets the same numbers, as it would alone.

    Returns
    -------
    tensor, shape (..., time), of the precision and on the device of ``magnitude``

    Raises
    ------
    ParameterError
        If ``magnitude`` is not one of ``length`` samples, negative or not finite.
    """
    if magnitude.dtype not in (torch.float32, torch.float64):
        raise ParameterError(f"magnitude must be float32 or float64, got {magnitude.dtype}")
    transform.check(magnitude, length)
    if start not in ("gradient", "random"):
        raise ParameterError(f"start must be 'gradient' or 'random', got {start!r}")
    if iteration not in _ITERATIONS:
        raise ParameterError(f"iteration must be one of {', '.join(_ITERATIONS)}, got {iteration!r}")
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
        x = project.signal(_ITERATIONS[iteration](s, target, project, iterations)) * scale[..., 0]
        return x.reshape(*magnitude.shape[:-2], length)


def spectral_convergence(x: Tensor, magnitude: Tensor, transform: STFT) -> Tensor:
    """Return how far the magnitude of ``x`` is from the one asked for: lower is better.

    ``20 log10( || |STFT(x)| - A || / ||A|| )`` over all bins and frames, with the STFT that ``A`` is of
    (Sturmel & Daudet 2011). It judges the signal that came out, not a spectrogram on the way to it.

    Parameters
    ----------
    x : tensor, shape (..., time)
    magnitude : tensor, shape (..., bin, frame)
    transform : STFT

    Returns
    -------
    tensor, shape (...), dB
    """
    error = (transform.forward(x).abs() - magnitude).square().sum((-2, -1))
    return 10 * torch.log10(error / magnitude.square().sum((-2, -1)))


def _admm(s: Tensor, target: Tensor, project: Projection, iterations: int, *, rho: float = 0.2) -> Tensor:
    """Improve ``s`` by the alternating direction method of multipliers.

    Masuyama, Yatabe & Oikawa, "Griffin-Lim like phase recovery via ADMM", IEEE Signal Process. Lett. 26(1),
    2019. Its three updates need only ``v``, the magnitude-constrained copy plus the multiplier, from one step
    to the next. ``rho`` is how much inconsistency is put up with: 0 never settles, 1 is Griffin-Lim.
    """
    v = s.clone()
    for _ in range(iterations):
        z = project(v).add_(v, alpha=rho).div_(1 + rho)
        v.sub_(z)  # the multiplier
        s = _with_magnitude(z.sub_(v), target)
        v.add_(s)
    return s


def _fast_griffin_lim(
    s: Tensor, target: Tensor, project: Projection, iterations: int, *, momentum: float = 0.99
) -> Tensor:
    """Improve ``s`` by alternating projections with momentum (Perraudin et al. 2013)."""
    last: Tensor | None = None
    for _ in range(iterations):
        consistent = project(s)
        ahead = consistent.clone() if last is None else consistent.lerp(last, -momentum)
        last = consistent
        s = _with_magnitude(ahead, target)
    return s


def _griffin_lim(s: Tensor, target: Tensor, project: Projection, iterations: int) -> Tensor:
    """Improve ``s`` by alternating projections (Griffin & Lim 1984)."""
    for _ in range(iterations):
        s = _with_magnitude(project(s), target)
    return s


def _admm_then_fast(s: Tensor, target: Tensor, project: Projection, iterations: int) -> Tensor:
    """Improve ``s`` by half of the steps of each."""
    s = _admm(s, target, project, iterations - iterations // 2)
    return _fast_griffin_lim(s, target, project, iterations // 2)


_ITERATIONS: dict[str, Callable[[Tensor, Tensor, Projection, int], Tensor]] = {
    "admm+fast_griffin_lim": _admm_then_fast,
    "admm": _admm,
    "fast_griffin_lim": _fast_griffin_lim,
    "griffin_lim": _griffin_lim,
}


def _with_magnitude(s: Tensor, target: Tensor) -> Tensor:
    """Give ``s`` the magnitude ``target``, in place: without the dear angle and exponential."""
    parts = torch.view_as_real(s)
    gain = parts[..., 0].square().addcmul_(parts[..., 1], parts[..., 1])
    gain.clamp_min_(torch.finfo(gain.dtype).tiny).rsqrt_().mul_(target)
    return s.mul_(gain)
