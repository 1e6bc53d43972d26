import pytest

from tactogram.model import Stage
from tactogram.training.forecast import duration_text, forecast_text


class Clocked:
    """A learner whose steps take a known time on a clock of its own; the first takes a minute longer."""

    def __init__(self, step_s):
        self.now_s, self.step_s, self.steps = 0.0, step_s, []

    def batches(self, stage, examples, *, seed, start=0):
        yield from examples

    def step(self, stage, batch):
        self.now_s += self.step_s[stage.name] + (0 if stage.name in self.steps else 60)
        self.steps.append(stage.name)
        return {}


def forecast(step_s, *stages, done=0):
    learner = Clocked(step_s)
    return forecast_text(learner, range(1000), stages, done=done, clock=lambda: learner.now_s), learner


def test_each_long_stage_is_forecast_without_its_first_step():
    stages = Stage("train", 300), Stage("match", 1), Stage("straighten", 1000, skippable=True)
    text, learner = forecast({"train": 0.1, "straighten": 0.5}, *stages)
    assert text == "train about 30 s, straighten at most 8 min on this machine"
    assert {name: learner.steps.count(name) for name in learner.steps} == {"train": 2, "straighten": 2}


def test_a_training_that_goes_on_is_forecast_from_where_it_is():
    assert forecast({"train": 1.0}, Stage("train", 300), done=240)[0] == ""  # soon over
    assert forecast({"train": 0.1}, Stage("train", 700), done=200)[0] == "train about 50 s on this machine"


def test_a_short_or_closed_form_is_not_forecast():
    text, learner = forecast({}, Stage("fit", 1), Stage("short", 99))
    assert (text, learner.steps) == ("", [])


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.2, "1 s"), (89, "89 s"), (90, "2 min"), (5399, "90 min"), (12600, "3.5 h")]
)
def test_durations_have_one_unit(seconds, text):
    assert duration_text(seconds) == text
