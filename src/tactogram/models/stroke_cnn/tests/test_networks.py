"""The published network: shapes, weights and order of its layers."""

from itertools import pairwise

import torch

from tactogram.models.stroke_cnn.config import Config
from tactogram.models.stroke_cnn.networks import StrokeCNN


def small(**changes):
    values = {"window": 32, "filters": (4, 4, 8, 8, 8, 8), "dense": (16, 8), "batch_size": 8, "steps": 30}
    return Config(**(values | changes))


def test_layers_have_the_shapes_of_the_paper():
    """Saga et al., Sec. II-C: "The input of CNN is 3×200 acceleration data, and the output is 1×30"."""
    network = StrokeCNN(Config(), axes=3, classes=30)
    shapes = []
    for layer in network.convolutions:
        if isinstance(layer, torch.nn.Conv2d | torch.nn.MaxPool2d):
            layer.register_forward_hook(lambda m, x, y: shapes.append(tuple(y.shape[1:])))
    assert network(torch.zeros(2, 3, 200)).shape == (2, 30)
    assert shapes == [
        (64, 3, 200), (64, 3, 200), (64, 3, 100),
        (128, 3, 100), (128, 3, 100), (128, 3, 50),
        (256, 3, 50), (256, 3, 50), (256, 3, 25),
    ]  # fmt: skip


def test_the_network_has_thirteen_layers_and_their_weights():
    """Saga et al., Sec. II-B: "constructed a 13-layered network"."""
    network = StrokeCNN(Config(), axes=3, classes=30)
    convolutions = [m for m in network.modules() if isinstance(m, torch.nn.Conv2d)]
    assert [(m.in_channels, m.out_channels, m.kernel_size) for m in convolutions] == [
        (1, 64, (1, 5)), (64, 64, (1, 5)), (64, 128, (1, 5)),
        (128, 128, (1, 5)), (128, 256, (1, 5)), (256, 256, (1, 5)),
    ]  # fmt: skip
    by_hand = sum(
        5 * i * o + o for i, o in [(1, 64), (64, 64), (64, 128), (128, 128), (128, 256), (256, 256)]
    )
    by_hand += 256 * 3 * 25 * 256 + 256 + 256 * 256 + 256 + 256 * 30 + 30
    by_hand += 2 * (2 * (64 + 128 + 256) + 2 * 256)  # scale and shift of each batch normalisation
    assert sum(p.numel() for p in network.parameters()) == by_hand
    poolings = sum(isinstance(m, torch.nn.MaxPool2d) for m in network.modules())
    dense = sum(isinstance(m, torch.nn.Linear) for m in network.modules())
    assert 1 + len(convolutions) + poolings + dense == 13  # with the input


def test_normalisation_follows_the_activation():
    """Sec. II-B: Batch Normalization "was applied after calculating each layer's activation function"."""
    network = StrokeCNN(Config(), axes=1, classes=2)
    kinds = [type(layer).__name__ for layer in (*network.convolutions, *network.dense)]
    assert [after for before, after in pairwise(kinds) if before == "ReLU"] == 6 * ["BatchNorm2d"] + 2 * [
        "BatchNorm1d"
    ]
    assert [kinds[k - 1] for k, kind in enumerate(kinds) if kind.startswith("BatchNorm")] == 8 * ["ReLU"]


def test_dropout_comes_between_the_second_dense_layer_and_the_output():
    """Sec. II-B: Dropout "between the fully connected second layer and the output layer"."""
    network = StrokeCNN(Config(), axes=3, classes=30)
    everywhere = [layer for layer in network.modules() if isinstance(layer, torch.nn.Dropout)]
    assert everywhere == [network.output[0]]
    assert (network.output[1].in_features, network.output[1].out_features) == (Config().dense[1], 30)


def test_axes_share_their_filters():
    network = StrokeCNN(small(), axes=3, classes=2).eval()
    x = torch.randn(1, 3, 32, generator=torch.Generator().manual_seed(0))
    features = network.convolutions(x[:, None])
    swapped = network.convolutions(x[:, None][:, :, [2, 0, 1]])
    torch.testing.assert_close(swapped, features[:, :, [2, 0, 1]])
