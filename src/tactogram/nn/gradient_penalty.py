"""The gradient penalty of WGAN-GP.

References
----------
- Gulrajani, I., Ahmed, F., Arjovsky, M., Dumoulin, V. & Courville, A. (2017). Improved training of
  Wasserstein GANs. NeurIPS 30. Eq. 3 and Algorithm 1.
"""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor


def gradient_penalty(
    critic: Callable[[Tensor], Tensor], real: Tensor, made: Tensor, share: Tensor | None = None
) -> Tensor:
    """Return the mean of ``(|grad critic(z)| - 1)^2`` at points z between ``real`` and ``made``, (item, …).

    Not weighted by the paper's lambda. ``share``, (item,), places each point from ``made`` (0) to ``real`` (1); by
    default it is uniform from torch's own generator. ``critic`` maps (item, …) to (item,) or (item, 1).
    """
    if share is None:
        share = torch.rand(len(real)).to(real.device)
    share = share.view(-1, *[1] * (real.dim() - 1))
    between = torch.lerp(made.detach(), real.detach(), share).requires_grad_()
    (slope,) = torch.autograd.grad(critic(between).sum(), between, create_graph=True)
    length: Tensor = torch.linalg.vector_norm(slope.flatten(1), dim=1)
    return (length - 1).square().mean()
