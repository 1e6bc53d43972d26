"""U-Net, PatchGAN, conditional batch norm and their losses against plain PyTorch and by hand."""

import math

import pytest
import torch
import torch.nn.functional as F
from torch import nn

from tactogram.errors import ParameterError
from tactogram.models.visual_tactile_gan.learner import ConditionalBatchNorm
from tactogram.nn.adversarial_networks import adversarial_loss, feature_matching_loss
from tactogram.nn.initial_weights import normal_
from tactogram.nn.patch_discriminator import MultiScaleDiscriminator, PatchDiscriminator
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


def test_conditional_batch_norm_is_its_equation():
    layer = ConditionalBatchNorm(3, 2)
    x, label = rand(4, 3, 2, 2), torch.eye(2)[[0, 1, 0, 1]]
    mean = x.mean((0, 2, 3), keepdim=True)
    deviation = (x.var((0, 2, 3), correction=0, keepdim=True) + 1e-5).sqrt()
    gamma = label @ layer.scale.weight.T + layer.scale.bias
    beta = label @ layer.shift.weight.T + layer.shift.bias
    expected = gamma[..., None, None] * (x - mean) / deviation + beta[..., None, None]
    torch.testing.assert_close(layer(x, label), expected)


def test_conditional_batch_norm_of_a_mixed_label_lies_between():
    layer = ConditionalBatchNorm(3, 2).eval()
    x, one, other = rand(1, 3, 2, 2), torch.tensor([[1.0, 0.0]]), torch.tensor([[0.0, 1.0]])
    between = layer(x, 0.3 * one + 0.7 * other)
    torch.testing.assert_close(between, 0.3 * layer(x, one) + 0.7 * layer(x, other))


def test_patch_discriminator_is_the_plain_sequence_of_pix2pixhd():
    torch.manual_seed(0)
    ours = PatchDiscriminator(into=2, layers=2, width=4, norm="batch")
    plain = nn.Sequential(
        nn.Conv2d(2, 4, 4, 2, 2), nn.LeakyReLU(0.2),
        nn.Conv2d(4, 8, 4, 2, 2), nn.BatchNorm2d(8), nn.LeakyReLU(0.2),
        nn.Conv2d(8, 16, 4, 1, 2), nn.BatchNorm2d(16), nn.LeakyReLU(0.2),
        nn.Conv2d(16, 1, 4, 1, 2),
    )  # fmt: skip
    weights = [*ours.convs[0].parameters()]
    for conv, norm in zip(list(ours.convs)[1:], ours.norms, strict=True):
        weights += [*conv.parameters(), *norm.parameters()]
    with torch.no_grad():
        for a, b in zip(plain.parameters(), [*weights, *ours.score.parameters()], strict=True):
            a.copy_(b)
    x = rand(3, 2, 32, 32)
    torch.testing.assert_close(ours(x)[-1], plain(x))
    assert len(ours(x)) == 2 + 2  # L + 1 features, and the score


@pytest.mark.parametrize(("layers", "patch"), [(1, 16), (2, 34), (3, 70), (4, 142)])
def test_patches_are_as_large_as_published(layers, patch):
    """Isola et al., Sec. 6.1.2: three layers make 70 x 70; the rest by its recursion."""
    network = PatchDiscriminator(into=1, layers=layers, width=2, norm="none", padding=1).double()
    x = rand(1, 1, 256, 256).double().requires_grad_()
    score = network(x)[-1]
    middle = score.shape[-1] // 2
    (slope,) = torch.autograd.grad(score[0, 0, middle, middle], x)
    assert int((slope[0, 0].abs().sum(0) > 0).sum()) == patch


def test_each_discriminator_sees_half_the_resolution_and_edges_count_fully():
    network = MultiScaleDiscriminator(count=3, into=1, layers=1, width=2, norm="none")
    seen = []
    for discriminator in network.discriminators:
        discriminator.register_forward_pre_hook(lambda module, given: seen.append(given[0]))
    judged = network(torch.ones(1, 1, 32, 32))
    assert [tuple(x.shape[-2:]) for x in seen] == [(32, 32), (16, 16), (8, 8)]
    assert all(bool((x == 1).all()) for x in seen)  # what lies outside is not averaged in
    assert len(judged) == 3


def test_adversarial_loss_by_hand():
    scores = [torch.tensor([0.0, 2.0]), torch.tensor([-1.0])]
    real = (math.log(2) + math.log(1 + math.exp(-2))) / 2 + math.log(1 + math.exp(1))
    fake = (math.log(2) + math.log(1 + math.exp(2))) / 2 + math.log(1 + math.exp(-1))
    assert adversarial_loss(scores, real=True).item() == pytest.approx(real)
    assert adversarial_loss(scores, real=False).item() == pytest.approx(fake)
    least = adversarial_loss(scores, real=True, kind="least-squares")
    assert least.item() == pytest.approx((1 + 1) / 2 + 4)


def test_feature_matching_by_hand_leaves_the_score_out_and_the_real_ones_alone():
    real = [[torch.zeros(2, requires_grad=True), torch.zeros(1), torch.full((1,), 9.0)] for _ in range(2)]
    made = [[torch.tensor([1.0, 3.0]), torch.tensor([-4.0]), torch.zeros(1)],
            [torch.tensor([0.0, 0.0]), torch.tensor([2.0]), torch.zeros(1)]]  # fmt: skip
    made[0][0].requires_grad_()
    loss = feature_matching_loss(made, real)
    assert loss.item() == pytest.approx(((2 + 4) / 2 + (0 + 2) / 2) / 2)
    loss.backward()
    assert real[0][0].grad is None
    assert made[0][0].grad is not None


def test_initial_weights_are_normal_with_the_given_gain():
    torch.manual_seed(0)
    network = nn.Sequential(nn.Conv2d(8, 64, 4), nn.BatchNorm2d(64), nn.ConvTranspose2d(64, 8, 4))
    normal_(network, 0.02)
    assert network[0].weight.std().item() == pytest.approx(0.02, rel=0.05)
    assert network[2].weight.mean().item() == pytest.approx(0, abs=0.001)
    assert network[1].weight.mean().item() == pytest.approx(1, abs=0.01)
    assert not network[0].bias.any()
