"""The fusion is a residue; the critic's penalty is each pair's own."""

import torch

from tactogram.models.residue_fusion_gan.config import Config
from tactogram.models.residue_fusion_gan.learner import ResidueFusion, discriminator, generator


def test_fusion_without_a_residue_leaves_the_generator_as_it_is():
    torch.manual_seed(0)
    fusion, x, maps = ResidueFusion(6, 9), torch.rand(2, 6, 2, 2), torch.rand(2, 9, 5, 7)
    assert not torch.allclose(fusion(x, maps), x)
    assert not torch.allclose(fusion(x, maps), fusion(x, maps.flip(0)))
    with torch.no_grad():
        fusion.residue.weight.zero_()
        fusion.residue.bias.zero_()
    torch.testing.assert_close(fusion(x, maps), x)


def test_published_size_takes_densenets_maps():
    with torch.device("meta"):
        network = generator(Config(), 1920)
        output = network(torch.empty(2, 1, 256, 256), torch.empty(2, 1920, 8, 8))
    assert output.shape == (2, 1, 256, 256)
    fused = 1920 * 512 + 512 + 9 * 1024 * 512 + 512 + 9 * 512 * 512 + 512
    assert sum(p.numel() for p in network.parameters()) == 54_407_809 + fused


def test_critic_judges_each_pair_by_itself():
    torch.manual_seed(0)
    critic, x = discriminator(Config(width=4)), torch.rand(3, 2, 64, 64)
    torch.testing.assert_close(critic(x)[-1][1:2], critic(x[1:2])[-1])
