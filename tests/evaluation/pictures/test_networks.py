"""LPIPS, FID and distances in a trunk: published formulas, files of weights, and honest errors."""

from importlib.util import find_spec

import numpy as np
import pytest
import torch
import torch.nn.functional as F

from tactogram.errors import DataError
from tactogram.evaluation.measures import frechet_distance
from tactogram.evaluation.pictures.networks import Fid, Lpips, TrunkDistance
from tactogram.nn.vision_import import torchvision, vision_module
from tactogram.nn.weight_files import PRETRAINED

pytestmark = pytest.mark.skipif(find_spec("torchvision") is None, reason="the extra vision is not installed")


def pictures(count, seed=0, size=32):
    return torch.from_numpy(np.random.default_rng(seed).uniform(-1, 1, (count, 1, size, size))).float()


@pytest.fixture(scope="module")
def alexnet(tmp_path_factory):
    """A file of AlexNet's convolutions, from a seed, and the network."""
    with torch.random.fork_rng():
        torch.manual_seed(3)
        network = torchvision().models.alexnet(weights=None).features
    file = tmp_path_factory.mktemp("weights") / "alexnet.pth"
    torch.save({f"features.{name}": value for name, value in network.state_dict().items()}, file)
    return file, network


@pytest.fixture(scope="module")
def lpips(alexnet):
    return Lpips(alexnet[0])


@pytest.fixture(scope="module")
def random_fid():
    return Fid(random=True)


def test_lpips_is_the_published_formula(alexnet, lpips):
    """Neshov et al. 2026, Sec. 4.1: "AlexNet … is thus adopted as the default backbone"."""
    network = alexnet[1]
    heads = torch.load(
        vision_module("torchmetrics").__path__[0] + "/functional/image/lpips_models/alex.pth",
        map_location="cpu",
        weights_only=True,
    )
    real, made = pictures(2, 1, 256), pictures(2, 2, 256)
    shift, scale = torch.tensor([-0.030, -0.088, -0.188]), torch.tensor([0.458, 0.448, 0.450])
    expected = torch.zeros(2)
    a, b = ((p.expand(-1, 3, -1, -1) - shift[:, None, None]) / scale[:, None, None] for p in (real, made))
    head = 0
    for number, layer in enumerate(network):
        with torch.no_grad():
            a, b = layer(a), layer(b)
        if number in (1, 4, 7, 9, 11):  # behind each rectifier
            one, other = (x / (x.square().sum(1, keepdim=True) + 1e-8).sqrt() for x in (a, b))
            weight = heads[f"lin{head}.model.1.weight"]
            expected += ((one - other).square() * weight).sum(1).mean((1, 2))
            head += 1
    torch.testing.assert_close(lpips(real, made), expected, rtol=1e-4, atol=1e-6)


def test_lpips_of_a_picture_with_itself_is_0_and_of_two_is_symmetric(lpips):
    real, made = pictures(3, 1), pictures(3, 2)
    assert lpips(real, real).abs().max() == 0
    torch.testing.assert_close(lpips(real, made), lpips(made, real))
    assert (lpips(real, made) > 0).all()


def test_pictures_are_judged_at_256_whatever_their_size(lpips):
    real, made = pictures(2, 1, 64), pictures(2, 2, 64)
    large = [F.interpolate(p, (256, 256), mode="bilinear", antialias=True) for p in (real, made)]
    torch.testing.assert_close(lpips(real, made), lpips(*large))


def test_weights_that_are_absent_are_said_in_a_line(tmp_path, monkeypatch):
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))
    with pytest.raises(
        DataError, match=r"AlexNet \(LPIPS\) are missing: put alexnet-owt-\w+.pth into .*checkpoints"
    ):
        Lpips()
    with pytest.raises(
        DataError, match=r"Inception \(FID\) are missing: put weights-inception.*set inception to the file"
    ):
        Fid()
    with pytest.raises(DataError, match=r"nowhere.pth: no weights of AlexNet"):
        Lpips(tmp_path / "nowhere.pth")


def test_published_files_are_those_of_torchvision_and_torch_fidelity():
    models = torchvision().models
    published = {one.network: one.url for one in PRETRAINED}
    assert published["AlexNet"] == models.AlexNet_Weights.DEFAULT.url
    assert published["VGG-19"] == models.VGG19_Weights.DEFAULT.url
    assert published["DenseNet-201"] == models.DenseNet201_Weights.DEFAULT.url
    inception = vision_module("torch_fidelity.feature_extractor_inceptionv3").URL_INCEPTION_V3
    assert published["Inception"] == inception


def test_a_file_of_something_else_is_said_in_a_line(tmp_path, alexnet):
    text = tmp_path / "text.pth"
    text.write_text("no weights")
    with pytest.raises(DataError, match=r"text.pth: not a readable file of weights") as caught:
        Lpips(text)
    assert "\n" not in str(caught.value)
    with pytest.raises(DataError, match=r"not weights of torch-fidelity's Inception") as caught:
        Fid(alexnet[0])
    assert "\n" not in str(caught.value)
    half = tmp_path / "half.pth"
    torch.save({"features.0.weight": torch.zeros(64, 3, 11, 11)}, half)
    with pytest.raises(DataError, match=r"half.pth: not weights of AlexNet"):
        Lpips(half)


def test_weights_are_found_in_torchs_cache(tmp_path, monkeypatch, alexnet, lpips):
    url = torchvision().models.AlexNet_Weights.DEFAULT.url
    (tmp_path / "checkpoints").mkdir()
    (tmp_path / "checkpoints" / url.rpartition("/")[2]).write_bytes(alexnet[0].read_bytes())
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))
    real, made = pictures(2, 1), pictures(2, 2)
    torch.testing.assert_close(Lpips()(real, made), lpips(real, made))


def test_fid_reads_the_file_it_is_given(tmp_path, random_fid):
    state = random_fid._network.state_dict()
    file = tmp_path / "inception.pth"
    torch.save({name: value * 0.5 for name, value in state.items()}, file)
    loaded = Fid(file)._network.state_dict()
    torch.testing.assert_close(
        loaded["Mixed_7c.branch1x1.conv.weight"], state["Mixed_7c.branch1x1.conv.weight"] / 2
    )


def test_fid_is_the_frechet_distance_in_inceptions_features(random_fid, monkeypatch):
    """Neshov et al. 2026, Sec. 4.1: FID compares "their mean and covariance"."""
    real, made = pictures(2, 1), pictures(2, 2)
    features = {id(p): random_fid.features(p) for p in (real, made)}
    assert features[id(real)].shape == (2, 2048)
    monkeypatch.setattr(random_fid, "features", lambda pictures: features[id(pictures)])
    assert random_fid(real, made) == pytest.approx(frechet_distance(*features.values()))
    assert random_fid(real, real) == pytest.approx(0, abs=1e-6 * features[id(real)].var(0).sum() + 1e-12)


def test_our_frechet_distance_is_that_of_torchmetrics():
    class Identity(torch.nn.Module):
        num_features = 3

        def forward(self, x):
            return x

    metric = vision_module("torchmetrics.image.fid").FrechetInceptionDistance(feature=Identity()).double()
    random = np.random.default_rng(0)
    one, other = random.standard_normal((50, 3)), 0.3 + random.standard_normal((40, 3)) * (1, 2, 3)
    metric.update(torch.from_numpy(one), real=True)
    metric.update(torch.from_numpy(other), real=False)
    assert frechet_distance(one, other) == pytest.approx(float(metric.compute()), rel=1e-6)


def test_the_trunk_tells_unlike_pictures_apart():
    distance = TrunkDistance()
    real = pictures(3, 1)
    stripes = torch.sin(torch.arange(32.0) / 2)[None, None, None].expand(3, 1, 32, 32).contiguous()
    assert distance.paired(real, real).abs().max() < 1e-5
    near, far = distance.paired(real, (real + 0.05).clamp(-1, 1)), distance.paired(real, stripes)
    assert (near < far).all()
    other = 0.9 * stripes + 0.1 * real
    assert distance.frechet(real, pictures(3, 2)) < distance.frechet(real, other)
