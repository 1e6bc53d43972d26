"""U-Net against pix2pix's nested one."""

import pytest
import torch
import torch.nn.functional as F

from tactogram.errors import ParameterError
from tactogram.models.visual_tactile_gan.learner import ConditionalBatchNorm
from tactogram.nn.unet import UNet


def rand(*shape, seed=0):
    return torch.rand(*shape, generator=torch.Generator().manual_seed(seed)) * 2 - 1


def block_form(unet, x, given):
    """The U-Net as pix2pix writes it: a block within a block, activations of what is handed across in place."""

    def block(depth, x):
        if depth == len(unet.down) - 1:
            inner = unet.bottleneck(unet.down[depth](F.leaky_relu(x, 0.2)), given)
            up = unet.up_norms[0](unet.up[0](F.relu(inner)))
        else:
            h = unet.down[depth](F.leaky_relu(x, 0.2) if depth else x)
            h = unet.down_norms[depth - 1](h) if depth else h
            inner = block(depth + 1, h)
            number = len(unet.up) - 1 - depth
            up = unet.up[number](F.relu(inner))
            if depth == 0:
                return torch.tanh(up)
            up = unet.up_norms[number](up)
        # LeakyReLU(inplace=True) has changed x by now; the ReLU that follows sees no difference.
        return torch.cat((F.leaky_relu(x, 0.2), up), 1)

    return block(0, x)


def test_unet_is_the_nested_one_of_pix2pix():
    """Neshov et al. 2026, Sec. 3.1: "a standard U-Net architecture based on the pix2pix framework"."""
    torch.manual_seed(0)
    unet = UNet(into=1, out=2, widths=(3, 4, 5), bottleneck=ConditionalBatchNorm(5, 2)).eval()
    x, label = rand(3, 1, 16, 24), torch.eye(2)[[0, 1, 1]]
    torch.testing.assert_close(unet(x, label), block_form(unet, x, label))


def test_unet_refuses_invalid_sizes_and_widths():
    unet = UNet(into=1, out=1, widths=(2, 2, 2))
    with pytest.raises(ParameterError, match="multiples of 8 for 3 stages, got"):
        unet(rand(1, 1, 12, 16))
    with pytest.raises(ParameterError, match="widths must be >= 2 stages"):
        UNet(into=1, out=1, widths=(2,))


def test_dropout_acts_on_the_coarsest_stages_in_training_or_with_noise():
    unet = UNet(into=1, out=1, widths=(4, 4, 4, 4), dropout=2).eval()
    x = rand(2, 1, 16, 16)
    torch.testing.assert_close(unet(x), unet(x), rtol=0, atol=0)
    unet.noise = True
    assert not torch.equal(unet(x), unet(x))
