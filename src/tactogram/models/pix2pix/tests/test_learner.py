"""The published sizes, and dropout as the only noise."""

import torch

from tactogram.models.pix2pix.config import Config
from tactogram.models.pix2pix.learner import discriminator, generator
from tactogram.nn.patch_discriminator import PatchDiscriminator
from tactogram.nn.unet import UNet


def count(network):
    return sum(p.numel() for p in network.parameters())


def test_sizes_are_those_the_authors_code_counts():
    """54.414 M and 2.769 M for three channels in and out."""
    config = Config()
    with torch.device("meta"):
        assert count(UNet(into=3, out=3, widths=config.widths, dropout=3)) == 54_413_955
        assert count(PatchDiscriminator(into=6, padding=1, bias=False)) == 2_768_705
        assert count(generator(config)) == 54_407_809
        outputs = discriminator(config)(torch.empty(1, 2, 256, 256))
    assert [tuple(f.shape[1:]) for f in outputs] == [
        (64, 128, 128), (128, 64, 64), (256, 32, 32), (512, 31, 31), (1, 30, 30)
    ]  # fmt: skip


def test_dropout_stays_on_in_use_and_is_all_the_noise_there_is():
    torch.manual_seed(0)
    network = generator(Config(widths=(4, 8, 8, 8), dropout=2)).eval()
    photo = torch.rand(1, 1, 16, 16)
    torch.manual_seed(1)
    one = network(photo)
    other = network(photo)
    torch.manual_seed(1)
    torch.testing.assert_close(network(photo), one, rtol=0, atol=0)
    assert not torch.equal(one, other)
