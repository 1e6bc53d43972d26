"""The fusion is a residue; the critic's penalty is each pair's own."""

import pytest
import torch

from tactogram import models
from tactogram.errors import DataError
from tactogram.model import SignalKind
from tactogram.models.residue_fusion_gan.config import Config
from tactogram.models.residue_fusion_gan.networks import ResidueFusion, discriminator, generator
from tactogram.nn.perceptual_loss import PerceptualLoss
from tactogram.nn.vision_import import torchvision
from tactogram.recipe import Recipe


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
        made = network(torch.empty(2, 1, 256, 256), torch.empty(2, 1920, 8, 8))
    assert made.shape == (2, 1, 256, 256)
    fused = 1920 * 512 + 512 + 9 * 1024 * 512 + 512 + 9 * 512 * 512 + 512
    assert sum(p.numel() for p in network.parameters()) == 54_407_809 + fused


def test_critic_judges_each_pair_by_itself():
    torch.manual_seed(0)
    critic, x = discriminator(Config(width=4)), torch.rand(3, 2, 64, 64)
    torch.testing.assert_close(critic(x)[-1][1:2], critic(x[1:2])[-1])


def test_perceptual_loss_is_the_weighted_distance_after_five_layers_of_vgg():
    """relu1_1, 2_1, 3_1, 4_1 and 5_1, with 1/32 to 1: the authors' code of pix2pixHD."""
    try:
        loss = PerceptualLoss("", random=True)
    except ImportError as error:
        pytest.skip(str(error))
    torch.manual_seed(0)
    made, real = torch.rand(1, 1, 32, 32, requires_grad=True), torch.rand(1, 1, 32, 32, requires_grad=True)
    layers = [layer for part in loss.slices for layer in part]
    a, b, expected = made.repeat(1, 3, 1, 1), real.repeat(1, 3, 1, 1), 0.0
    weights = {1: 1 / 32, 6: 1 / 16, 11: 1 / 8, 20: 1 / 4, 29: 1.0}
    for place, layer in enumerate(layers):
        a, b = layer(a), layer(b)
        expected += weights.get(place, 0.0) * (a - b).abs().mean()
        assert isinstance(layer, torch.nn.ReLU) or place not in weights
    found = loss(made, real)
    torch.testing.assert_close(found, expected)
    found.backward()
    assert bool(made.grad.abs().sum() > 0)
    assert real.grad is None


def test_weights_of_vgg_are_asked_for_by_a_training_alone(tmp_path):
    try:
        torchvision()
    except ImportError as error:
        pytest.skip(str(error))
    facts = models.find("residue_fusion_gan")
    changes = {"config.vgg_weights": str(tmp_path / "gone.pth")}
    config = facts.config(Recipe.load(facts.recipe("tiny"), changes=changes).config)
    made = facts.build(config, SignalKind(1000.0, "m/s^2", ("z",), ("a", "b")), seed=0)
    made.load_state(made.state())  # as a finished run is loaded, wherever the file went
    assert made.omitted == ""
    with pytest.raises(DataError, match=r"gone\.pth: no weights of VGG-19 there"):
        made.stages(())


def test_a_training_without_vgg_says_that_it_has_no_perceptual_loss():
    facts = models.find("residue_fusion_gan")
    config = facts.config(Recipe.load(facts.recipe("tiny")).config)
    made = facts.build(config, SignalKind(1000.0, "m/s^2", ("z",), ("a", "b")), seed=0)
    assert "perceptual loss is omitted" in made.set_validation(())
