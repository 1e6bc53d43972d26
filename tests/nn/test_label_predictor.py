"""The label predictor: its head, its learning rate, and what is done to photographs before it sees them."""

from copy import deepcopy

import numpy as np
import pytest
import torch

from tactogram.nn.label_predictor import (
    LabelPredictor,
    PredictorConfig,
    PredictorTraining,
    erased,
    mixed,
    moved,
)


def photographs(count=6, side=16):
    return torch.rand(count, 1, side, side, generator=torch.Generator().manual_seed(0)) * 2 - 1


def test_without_scale_and_rotation_only_flips_remain():
    """Neshov et al. 2026, Sec. 3.1: "horizontal and vertical flipping, random rotation, random erasing, and mixup"."""
    photo = photographs()
    got = moved(photo, scale=1.0, rotation_deg=0.0, rng=np.random.default_rng(0))
    seen = set()
    for before, after in zip(photo, got, strict=True):
        flips = {(): before, (1,): before.flip(1), (2,): before.flip(2), (1, 2): before.flip(1, 2)}
        fits = [axes for axes, flipped in flips.items() if torch.allclose(flipped, after, atol=1e-5)]
        assert len(fits) == 1
        seen.add(fits[0])
    assert len(seen) > 1


def test_scaled_photographs_are_crops_of_the_original():
    """A ramp scaled by s has 1/s of its slope, and never leaves the range it had.

    Sec. 3.1: "scaling the images by factors sampled uniformly from the range [1, 1.5]".
    """
    ramp = torch.linspace(-0.9, 0.9, 32).expand(64, 1, 32, 32)
    got = moved(ramp, scale=1.5, rotation_deg=0.0, rng=np.random.default_rng(0))
    slopes = (got[:, 0, 16, 20] - got[:, 0, 16, 12]).abs() / (ramp[0, 0, 0, 20] - ramp[0, 0, 0, 12])
    assert float(slopes.min()) > 1 / 1.5 - 1e-3
    assert float(slopes.max()) < 1 + 1e-3
    assert float(slopes.std()) > 0.05
    assert float(got.abs().max()) <= 0.9 + 1e-5


def test_same_draws_are_the_same_photographs():
    one, other = (
        moved(photographs(), scale=1.5, rotation_deg=30, rng=np.random.default_rng(3)) for _ in range(2)
    )
    torch.testing.assert_close(one, other, rtol=0, atol=0)


def test_erasing_takes_one_rectangle_of_2_to_33_percent():
    photo = torch.ones(40, 1, 32, 32)
    got = erased(photo, share=1.0, rng=np.random.default_rng(0))
    for item in got[:, 0] == 0:
        rows, columns = item.any(1).nonzero(), item.any(0).nonzero()
        box = (rows.max() - rows.min() + 1) * (columns.max() - columns.min() + 1)
        assert int(item.sum()) == int(box)
        assert 0.01 < float(item.float().mean()) < 0.36
    assert bool((photo == 1).all())
    assert bool((erased(photo, share=0.0, rng=np.random.default_rng(0)) == 1).all())


def test_mixup_mixes_labels_as_it_mixes_photographs():
    photo = torch.arange(4.0)[:, None, None, None].expand(4, 1, 2, 2)
    got, label = mixed(photo, torch.eye(4), alpha=0.4, rng=np.random.default_rng(1))
    torch.testing.assert_close(got[:, 0, 0, 0], label @ torch.arange(4.0))
    torch.testing.assert_close(label.sum(1), torch.ones(4))
    same, _ = mixed(photo, torch.eye(4), alpha=0.0, rng=np.random.default_rng(1))
    assert same is photo


@pytest.mark.parametrize("rotation", [10.0, 90.0])
def test_rotation_stays_within_its_limit(rotation):
    """The brightest end of a ramp, as an angle."""
    axis = torch.linspace(-0.7, 0.7, 33)
    ramp = axis.expand(50, 1, 33, 33)
    got = moved(ramp, scale=1.0, rotation_deg=rotation, rng=np.random.default_rng(0))[:, 0, 12:21, 12:21]
    across = (got[:, :, -1] - got[:, :, 0]).mean(1)
    down = (got[:, -1] - got[:, 0]).mean(1)
    angle = torch.rad2deg(torch.atan2(down.abs(), across.abs()))
    assert float(angle.max()) <= rotation + 0.5
    assert float(angle.max()) > rotation / 2


def test_label_predictor_has_the_published_head():
    """Neshov et al. 2026, Sec. 3.1: "reduces the dimensionality from 1920 to 256", "default negative slope of 0.01"."""
    try:
        with torch.device("meta"):
            network = LabelPredictor(PredictorConfig(), 9)
    except ImportError as error:
        pytest.skip(str(error))
    assert [tuple(p.shape) for p in network.head.parameters()] == [
        (256, 1920), (256,), (256,), (256,), (9, 256), (9,)
    ]  # fmt: skip
    assert network.head[2].negative_slope == 0.01
    assert not any(p.requires_grad for p in network.trunk.parameters())
    assert all(p.requires_grad for p in network.head.parameters())
    assert not network.train().trunk.network.training  # frozen: its batch norms as well


def test_learning_rate_of_the_predictor_halves_every_five_epochs():
    """Neshov et al. 2026, Sec. 3.2: a scheduler "halves the learning rate every 5 epochs"."""
    training = PredictorTraining(PredictorConfig(trunk="own", hidden=4), 2, device=torch.device("cpu"))
    batch = (torch.rand(4, 1, 16, 16), torch.eye(2)[[0, 1, 0, 1]])
    rates = {}
    for epoch in (0, 4, 5, 9, 10, 29):
        training.step((epoch * 7, *batch), epoch_steps=7, unseen=None)
        rates[epoch] = training.optimiser.param_groups[0]["lr"]
    assert rates == {0: 2e-4, 4: 2e-4, 5: 1e-4, 9: 1e-4, 10: 5e-5, 29: 2e-4 / 32}


def test_the_most_accurate_weights_on_unseen_photographs_are_kept_the_later_of_equal_ones(monkeypatch):
    """Sec. 3.2: "the model with the best score on the validation set is integrated into the main architecture"."""
    training = PredictorTraining(PredictorConfig(trunk="own", hidden=4), 2, device=torch.device("cpu"))
    accuracies = iter([0.5, 0.9, 0.9, 0.7])
    monkeypatch.setattr(training, "accuracy", lambda unseen: next(accuracies))
    batch, after = (torch.rand(4, 1, 16, 16), torch.eye(2)[[0, 1, 0, 1]]), []
    for number in range(4):
        training.step((number, *batch), epoch_steps=1, unseen=())
        after.append(deepcopy(training.bare.state_dict()))
    training.settle()
    kept = training.bare.state_dict()
    same = [all(torch.equal(kept[name], each[name]) for name in kept) for each in after]
    assert same == [False, False, True, False]
