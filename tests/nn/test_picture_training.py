"""Course of a training: how many steps, when weights are chosen, and at what share of it each step stands."""

from types import SimpleNamespace

import pytest
import torch

from tactogram.model import Stage
from tactogram.nn.picture_training import PictureTraining


class Ends:
    """Ten pairs of photographs and pictures; one part to judge by."""

    config = SimpleNamespace(size=16)
    kind = SimpleNamespace(materials=("cork",))
    splits_crops = ""

    def check(self, examples):
        assert len(examples)

    def pairs(self, examples):
        return range(10)

    def unseen(self, examples):
        return examples or None

    def batches(self, examples, *, size, seed, start):
        for number in range(start, 100):
            yield number, torch.zeros(size, 1), torch.ones(size, 1), torch.zeros(size), torch.arange(size)


class Gan:
    """Notes what is asked of it."""

    device = torch.device("cpu")
    bare_generator = SimpleNamespace(check_size=lambda rows, columns: None)

    def __init__(self):
        self.seen = []

    def train(self, done):
        self.seen.append(("train", done))

    def choose(self, make, pairs):
        self.seen.append(("choose", pairs))
        return {"unseen": 1.0}

    def settle(self):
        self.seen.append(("settle",))


def training(**changes):
    values = {"batch_size": 4, "epochs": 2, "steps": None, "choose_every": None} | changes
    return PictureTraining(Ends(), Gan(), **values)


@pytest.mark.parametrize(("changes", "steps"), [({}, 2 * 3), ({"epochs": 5}, 15), ({"steps": 7}, 7)])
def test_epochs_are_passes_over_all_pairs(changes, steps):
    assert training(**changes).stages(["a"])[-1] == Stage("gan", steps)


@pytest.mark.parametrize(("every", "chosen"), [(None, {3, 6, 7}), (2, {2, 4, 6, 7})])
def test_weights_are_chosen_once_an_epoch_or_as_often_as_asked_and_settled_at_the_end(every, chosen):
    made = training(steps=7, choose_every=every)
    made.watched = ["unseen"]
    stage = made.stages(["a"])[-1]
    expected = []
    for number, batch in zip(range(7), made.batches(stage, ["a"], seed=0), strict=False):
        figures = made.step(stage, batch, lambda *given: {"loss": float(len(given))}, lambda photo: photo)
        expected.append(("train", number / 7))
        if number + 1 in chosen:
            expected.append(("choose", ["unseen"]))
        assert set(figures) == ({"loss", "unseen"} if number + 1 in chosen else {"loss"})
    assert made.gan.seen == [*expected, ("settle",)]
