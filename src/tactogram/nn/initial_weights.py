"""Initial weights of pix2pix and related networks.

References
----------
- Radford, A., Metz, L. & Chintala, S. (2016). Unsupervised representation learning with deep convolutional
  generative adversarial networks. ICLR. Sec. 4.
- Isola, P. et al. (2017). Image-to-image translation with conditional adversarial networks. CVPR. Sec. 6.2.
"""

from __future__ import annotations

from torch import nn


def normal_(network: nn.Module, gain: float = 0.02) -> None:
    """Draw convolutions from N(0, gain), scales of batch normalisation from N(1, gain); biases become 0.

    Weights of a `ConditionalBatchNorm` and other dense layers are unchanged.
    """
    for module in network.modules():
        if isinstance(module, nn.Conv2d | nn.ConvTranspose2d):
            nn.init.normal_(module.weight, 0, gain)
        elif isinstance(module, nn.BatchNorm2d) and module.affine:
            nn.init.normal_(module.weight, 1, gain)
        else:
            continue
        if module.bias is not None:
            nn.init.zeros_(module.bias)
