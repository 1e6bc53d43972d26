"""Losses of generators and discriminators: scores of patches, features, and the gradient penalty of WGAN-GP.

References
----------
- Goodfellow, I. et al. (2014). Generative adversarial nets. NeurIPS 27. Sec. 3: the non-saturating form.
- Mao, X. et al. (2017). Least squares generative adversarial networks. ICCV.
- Gulrajani, I., Ahmed, F., Arjovsky, M., Dumoulin, V. & Courville, A. (2017). Improved training of
  Wasserstein GANs. NeurIPS 30. Eq. 3 and Algorithm 1.
- Wang, T.-C. et al. (2018). High-resolution image synthesis … with conditional GANs. CVPR. Eq. 4.
- Neshov, N. et al. (2026). Visual-to-tactile cross-modal generation … Sensors 26, 426. Sec. 3.1.
- Gulrajani, I., Ahmed, F., Arjovsky, M., Dumoulin, V. & Courville, A. (2017). Improved training of
  Wasserstein GANs. NeurIPS 30. Eq. 3 and Algorithm 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

import torch
import torch.nn.functional as F
from torch import Tensor

LossKind = Literal["cross-entropy", "least-squares"]


def adversarial_loss(scores: Sequence[Tensor], *, real: bool, kind: LossKind = "cross-entropy") -> Tensor:
    """Return the loss of ``scores``, one tensor of any shape per discriminator, against ``real``, summed over them.

    ``cross-entropy``: -log of the sigmoid of a score (real), or of that of its negative, mean over patches. A
    generator that minimises it with ``real=True`` maximises log D(G) rather than minimising log(1 - D(G)): the
    non-saturating form. ``least-squares``: (score - 1)^2, or score^2.
    """
    losses = []
    for score in scores:
        target = torch.ones_like(score) if real else torch.zeros_like(score)
        if kind == "cross-entropy":
            losses.append(F.binary_cross_entropy_with_logits(score, target))
        else:
            losses.append(F.mse_loss(score, target))
    return torch.stack(losses).sum()


def feature_matching_loss(made: Sequence[Sequence[Tensor]], real: Sequence[Sequence[Tensor]]) -> Tensor:
    """Return the mean distance of the features of generated pictures from those of real ones.

    ``1/N_D sum_k 1/(L+1) sum_l |D_k^(l)(real) - D_k^(l)(made)|_1``, the norm a mean over the features' values as in
    pix2pixHD; over all layers but the last, which is the score. Features are those of a `MultiScaleDiscriminator`; no
    gradient flows into the real ones.
    """
    distances = [
        torch.stack([F.l1_loss(a, b.detach()) for a, b in zip(ours[:-1], theirs[:-1], strict=True)]).mean()
        for ours, theirs in zip(made, real, strict=True)
    ]
    return torch.stack(distances).mean()


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
