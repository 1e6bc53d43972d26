"""Course of a training: number of steps, choice of weights, and the share of the training done at each step."""

from types import SimpleNamespace

import pytest
import torch

from tactogram.model import Stage
from tactogram.training.picture_learner import PictureConfig, PictureLearner


class Translation:
    """Ten pairs of photographs and pictures; validation examples are their own pairs."""

    crop_protocol = ""

    def check(self, examples):
        assert len(examples)

    def pairs(self, examples):
        return range(10)

    def unseen(self, examples):
        return examples or None

    def batch(self, pairs, places):
        return torch.zeros(len(places), 1), torch.ones(len(places), 1), torch.zeros(len(places)), places


class Gan:
    """Records the calls."""

    device = torch.device("cpu")
    bare_generator = SimpleNamespace(check_size=lambda rows, columns: None)

    def __init__(self):
        self.calls = []

    def train(self, done):
        self.calls.append(("train", done))

    def choose(self, make, pairs):
        self.calls.append(("choose", pairs))
        return {"unseen": 1.0}

    def settle(self):
        self.calls.append(("settle",))


class Learner(PictureLearner):
    """A learner whose pairs and networks are stand-ins."""

    predictor = None
    validation_examples = ()

    def __init__(self, **changes):
        self.config = PictureConfig(**({"batch_size": 4, "epochs": 2} | changes))
        self.translation, self.gan = Translation(), Gan()

    def update(self, *batch):
        return {"loss": float(len(batch))}


@pytest.mark.parametrize(("changes", "steps"), [({}, 2 * 3), ({"epochs": 5}, 15), ({"steps": 7}, 7)])
def test_epochs_are_passes_over_all_pairs(changes, steps):
    assert Learner(**changes).stages(["a"])[-1] == Stage("gan", steps)


@pytest.mark.parametrize(("every", "chosen"), [(None, {3, 6, 7}), (2, {2, 4, 6, 7})])
def test_weights_are_chosen_once_an_epoch_or_as_often_as_asked_and_settled_at_the_end(every, chosen):
    made = Learner(steps=7, choose_every=every)
    made.validation_examples = ["unseen"]
    stage = made.stages(["a"])[-1]
    expected = []
    for number, batch in zip(range(7), made.batches(stage, ["a"], seed=0), strict=False):
        figures = made.step(stage, batch)
        expected.append(("train", number / 7))
        if number + 1 in chosen:
            expected.append(("choose", ["unseen"]))
        assert set(figures) == ({"loss", "unseen"} if number + 1 in chosen else {"loss"})
    assert made.gan.calls == [*expected, ("settle",)]
