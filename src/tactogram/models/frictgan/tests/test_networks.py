import numpy as np
import pytest
import torch
from torch import nn

from tactogram.models.frictgan import Config
from tactogram.models.frictgan.config import critic_size
from tactogram.models.frictgan.networks import Critic, Generator, SamePaddedConv, match

PAPER = Config()


def shapes(network, *inputs):
    """The shape of what each layer gives, at the published size, without computing it."""
    sizes = []
    for layer in network.modules():
        if isinstance(layer, nn.Conv2d | nn.ConvTranspose2d | nn.Linear):
            layer.register_forward_hook(lambda module, arguments, out: sizes.append(tuple(out.shape[1:])))
    with torch.no_grad():
        network(*inputs)
    return sizes


@pytest.fixture(scope="module")
def published():
    with torch.device("meta"):
        return Generator(PAPER), Critic(PAPER)


def test_generator_of_the_paper_layer_by_layer(published):
    """Cai et al. 2020, Sec. 3.1: "1024 × 1024 × 3 RGB image as input, and output a 128-dimensional latent vector"."""
    photo, noise = torch.empty(2, 3, 1024, 1024, device="meta"), torch.empty(2, 50, device="meta")
    assert shapes(published[0], photo, noise) == [
        (32, 512, 512), (64, 256, 256), (128, 128, 128), (256, 64, 64), (512, 32, 32), (512, 8, 8), (512, 2, 2),
        (128,), (4608,),
        (512, 9, 3), (256, 33, 3), (128, 65, 3), (64, 129, 6), (32, 257, 11), (1, 257, 11),
    ]  # fmt: skip
    assert published[0].spread.in_features == 128 + 50


def test_critic_of_the_paper_layer_by_layer(published):
    """Cai et al. 2020, Sec. 3.1: "with the size of 257 × 11 × 4" to "a 30 × 1 × 1 patch"."""
    photo = torch.empty(2, 3, 1024, 1024, device="meta")
    spectrogram = torch.empty(2, 1, 257, 11, device="meta")
    assert published[1].layers[0].in_channels == 4
    assert shapes(published[1], photo, spectrogram) == [
        (64, 129, 6), (128, 65, 3), (256, 33, 3), (512, 31, 2), (1, 30, 1),
    ]  # fmt: skip
    assert critic_size((257, 11)) == (30, 1)


def test_parameter_counts(published):
    assert sum(p.numel() for p in published[0].parameters()) == 19_677_249
    assert sum(p.numel() for p in published[1].parameters()) == 3_291_009


def test_each_layer_is_a_convolution_with_batch_normalisation_and_a_rectifier(published):
    """Sec. 3.1: "For each layer in the generator, … convolution/deconvolution, batch normalization, and ReLU units"."""
    generator, critic = published

    def kinds(layers):
        return [type(layer).__name__ for layer in layers if not isinstance(layer, nn.Dropout)]

    assert [kinds(layer) for layer in generator.encoder] == [["SamePaddedConv", "BatchNorm2d", "ReLU"]] * 7
    assert [kinds(layer) for layer in generator.decoder] == [
        ["CroppedTransposedConv", "BatchNorm2d", "ReLU"]
    ] * 5
    inner = kinds(critic.layers)[:-1]
    assert (inner[1::3], inner[2::3]) == (["BatchNorm2d"] * 4, ["LeakyReLU"] * 4)


def test_dropout_is_in_the_last_three_layers_of_the_encoder(published):
    """Cai et al. 2020, Sec. 3.1: "three dropout units were added in the last three layers of the encoder"."""
    shares = [m.p for m in published[0].encoder.modules() if isinstance(m, nn.Dropout)]
    assert shares == [0, 0, 0, 0, 0.5, 0.5, 0.5]
    assert all(m.p == 0 for m in published[0].decoder.modules() if isinstance(m, nn.Dropout))


def test_same_padding_is_tensorflows():
    """Of 5 samples with kernel 4 and stride 2 three outputs: one zero before, two after."""
    layer = SamePaddedConv(1, 1, 4, (2, 2), bias=False)
    nn.init.ones_(layer.weight)
    row = torch.zeros(1, 1, 5, 5)
    row[0, 0, 0] = torch.tensor([1.0, 10, 100, 1000, 10000])
    with torch.no_grad():
        np.testing.assert_allclose(layer(row)[0, 0, 0], [111.0, 11110.0, 11000.0])


def test_a_photograph_is_cropped_to_its_middle_or_pooled():
    """Cai et al. 2020, Sec. 3.1: the discriminator sees a "cropped texture image"; which part is not stated."""
    x = torch.arange(64.0).view(1, 1, 8, 8)
    torch.testing.assert_close(match(x, (4, 2), "crop"), x[:, :, 2:6, 3:5])
    torch.testing.assert_close(match(x, (2, 4), "pool")[0, 0, 0, 0], x[0, 0, :4, :2].mean())


def test_output_is_never_negative():
    """Cai et al. 2020, Sec. 3.1: "we added a ReLU function in the last layer of generator"."""
    small = Config(pixels=32, n_fft=64, hop=16, frames=9, channels=(4, 4, 4), strides=(2, 2, 4), up_strides=(4, 2, 2),
                   match="pool", wide=1)  # fmt: skip
    output = Generator(small)(torch.randn(3, 3, 32, 32), torch.randn(3, 50))
    assert output.shape == (3, 1, 33, 9)
    assert float(output.detach().min()) >= 0
