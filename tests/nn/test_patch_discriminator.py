"""PatchGAN discriminators against plain PyTorch, at one and several resolutions."""

import pytest
import torch
from torch import nn

from tactogram.nn.patch_discriminator import MultiScaleDiscriminator, PatchDiscriminator


def rand(*shape, seed=0):
    return torch.rand(*shape, generator=torch.Generator().manual_seed(seed)) * 2 - 1


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
    """Neshov et al. 2026, Sec. 3.1: average pooling reduces "spatial resolution by a factor of two at each stage"."""
    network = MultiScaleDiscriminator(count=3, into=1, layers=1, width=2, norm="none")
    seen = []
    for discriminator in network.discriminators:
        discriminator.register_forward_pre_hook(lambda module, given: seen.append(given[0]))
    judged = network(torch.ones(1, 1, 32, 32))
    assert [tuple(x.shape[-2:]) for x in seen] == [(32, 32), (16, 16), (8, 8)]
    assert all(bool((x == 1).all()) for x in seen)  # what lies outside is not averaged in
    assert len(judged) == 3
