"""Rectified flow: a straight way from noise to data, learned as a velocity.

References
----------
- Lipman, Y. et al. (2023). Flow matching for generative modeling. ICLR.
- Liu, X., Gong, C. & Liu, Q. (2023). Flow straight and fast: learning to generate and transfer data with rectified
  flow. ICLR.
- Liu, X. et al. (2024). InstaFlow: one step is enough for high-quality diffusion-based text-to-image generation. ICLR.
- Hairer, E., Nørsett, S. P. & Wanner, G. (1993). Solving ordinary differential equations I. Springer. Sec. III.5.
- Esser, P. et al. (2024). Scaling rectified flow transformers for high-resolution image synthesis. ICML. Sec. 3.1.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import torch
from torch import Tensor

Velocity = Callable[[Tensor, Tensor], Tensor]
"""Maps values, (batch, …), and times, (batch,), to velocities, (batch, …)."""
DENSITY = 1.5
"""Exponent of the times of the solver's steps: above 1 they are denser near the noise, where paths bend most."""


def flow_loss(velocity: Velocity, data: Tensor) -> Tensor:
    """Return the mean squared error of the velocity at random points between noise and ``data``, (batch, …).

    The errors of an element with a mean square above 1 are divided by it, so that it does not outweigh the others.
    Noise and times are drawn from torch's own generator, the times from the logit-normal distribution (Esser et al.).
    """
    noise = torch.randn(data.shape).to(data)
    time = torch.sigmoid(torch.randn(len(data))).to(data)
    share = time.view(-1, *[1] * (data.ndim - 1))
    error = velocity((1 - share) * noise + share * data, time) - (data - noise)
    return _mean_square(error, data)


def straightening_loss(velocity: Velocity, teacher: Velocity, noise: Tensor, steps: int) -> Tensor:
    """Return the mean squared error of one step from ``noise`` to where it flows in ``steps`` steps of ``teacher``.

    The distillation of a flow to a single step (Liu et al. 2023, Sec. 2; InstaFlow), with errors limited as in
    `flow_loss`. ``noise`` is (batch, …); no gradient reaches the teacher.
    """
    with torch.no_grad():
        data = solve(teacher, noise, steps)
    return _mean_square(velocity(noise, torch.zeros(len(noise)).to(noise)) - (data - noise), data)


def _mean_square(error: Tensor, data: Tensor) -> Tensor:
    inner = tuple(range(1, data.ndim))
    return (error.square().mean(inner) / data.square().mean(inner).clamp_min(1)).mean()


def times_of(steps: int) -> list[float]:
    """Return the times between the solver's steps, from 0 to 1."""
    return [(place / steps) ** DENSITY for place in range(steps + 1)]


def solve(velocity: Velocity, noise: Tensor, steps: int) -> Tensor:
    """Return data, (batch, …), that ``noise`` flows to in ``steps`` steps, one evaluation of ``velocity`` each.

    The method is that of Adams and Bashforth, of second order and with unequal steps (Hairer et al., Sec. III.5): each
    step continues the change of the velocity over the one before. The first is Euler's. The times are denser near the
    noise.
    """
    x = noise
    earlier: tuple[float, Tensor] | None = None
    for begin, end in pairwise(times_of(steps)):
        slope = mean = velocity(x, torch.full((len(x),), begin).to(x))
        if earlier is not None:
            time, before = earlier
            mean = slope + (slope - before) * (end - begin) / (2 * (begin - time))
        earlier = begin, slope
        x = x + mean * (end - begin)
    return x
