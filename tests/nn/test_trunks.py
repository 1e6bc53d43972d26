"""Trunks from files of weights, the perceptual loss of VGG-19, and the two models that have it."""

import pytest
import torch

from tactogram import models
from tactogram.errors import DataError
from tactogram.model import SignalKind
from tactogram.nn.trunks import PerceptualLoss, Trunk
from tactogram.nn.vision_import import torchvision
from tactogram.recipe import Recipe

both = pytest.mark.parametrize("name", ["pix2pixhd", "residue_fusion_gan"])


def built(name, **changes):
    facts = models.find(name)
    config = facts.config(Recipe.load(facts.recipe("tiny"), changes=changes).config)
    return facts.build(config, SignalKind(1000.0, "m/s^2", ("z",), ("a", "b")), seed=0)


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


@both
def test_weights_of_vgg_are_asked_for_by_a_training_alone(name, tmp_path):
    try:
        torchvision()
    except ImportError as error:
        pytest.skip(str(error))
    made = built(name, **{"config.vgg_weights": str(tmp_path / "gone.pth")})
    made.load_state(made.state())  # as a finished run is loaded, wherever the file went
    assert made.omitted == ""
    with pytest.raises(DataError, match=r"gone\.pth: no weights of VGG-19 there"):
        made.stages(())


@both
def test_a_training_without_vgg_says_that_it_has_no_perceptual_loss(name):
    assert "perceptual loss is omitted" in built(name).set_validation(())


def test_absent_weights_are_one_line_that_says_where_they_go(tmp_path, monkeypatch):
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))
    try:
        trunk = Trunk("densenet201")
    except ImportError as error:
        pytest.skip(str(error))
    with pytest.raises(DataError, match="put densenet201-.*pth into") as error:
        trunk.load()
    assert "\n" not in str(error.value)
    (tmp_path / "bad.pth").write_bytes(b"no weights")
    with pytest.raises(DataError, match="not a readable file of weights"):
        Trunk("densenet201", str(tmp_path / "bad.pth")).load()
    with pytest.raises(DataError, match="no weights of DenseNet-201 there"):
        Trunk("densenet201", str(tmp_path / "none.pth")).load()


def test_weights_of_torchvisions_own_file_are_loaded_old_names_and_all(tmp_path):
    try:
        trunk = Trunk("densenet201")
    except ImportError as error:
        pytest.skip(str(error))
    state = {f"features.{name}": value for name, value in trunk.network.state_dict().items()}
    state = {
        name.replace(".norm1.", ".norm.1.").replace(".conv2.", ".conv.2."): v for name, v in state.items()
    }
    assert any(".norm.1." in name for name in state)
    changed = next(iter(state))
    state[changed] = torch.full_like(state[changed], 0.5)
    torch.save(
        state | {"classifier.weight": torch.zeros(1), "classifier.bias": torch.zeros(1)}, tmp_path / "w.pth"
    )
    other = Trunk("densenet201", str(tmp_path / "w.pth"))
    other.load()
    assert bool((next(iter(other.network.state_dict().values())) == 0.5).all())
