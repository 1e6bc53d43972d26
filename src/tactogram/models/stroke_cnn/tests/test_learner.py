import copy

import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind, Stage
from tactogram.models.stroke_cnn.config import Config
from tactogram.models.stroke_cnn.learner import StrokeCNNLearner, Windows
from tactogram.signal import Signal
from tactogram.training.loop import fit

KIND = SignalKind(330.0, "m/s^2", ("x", "y", "z"), ("a", "b", "c"))


def small(**changes):
    values = {"window": 32, "filters": (4, 4, 8, 8, 8, 8), "dense": (16, 8), "batch_size": 8, "steps": 30}
    return Config(**(values | changes))


def examples(count=9, length=400):
    random = np.random.default_rng(0)
    return [
        Example(
            str(i),
            Signal(random.standard_normal((3, length)) * (1 + 3 * (i % 3)), 330.0, "m/s^2"),
            "abc"[i % 3],
        )
        for i in range(count)
    ]


def trained(config=None):
    learner = StrokeCNNLearner(config or small(), KIND, seed=0)
    data = examples()
    for stage in learner.stages(data):
        for _, batch in zip(range(stage.steps), learner.batches(stage, data, seed=1), strict=False):
            learner.step(stage, batch)
    return learner


def test_a_shorter_training_that_settles_is_the_whole_training():
    config = small(steps=2000, short_steps=120, window=64, learning_rate=1e-2, schedule="one-cycle")
    learner = StrokeCNNLearner(config, KIND, seed=0)
    learner.set_validation(examples(3))
    assert [stage.name for stage in learner.stages(examples())] == ["standardise", "short", "classify"]
    steps = []
    fit(learner, examples(), seed=0, on_step=lambda position, stage, losses: steps.append(stage.name))
    assert (steps.count("short"), steps.count("classify")) == (120, 0)
    assert learner.outcome() == {"short_training": {"validation_window_accuracy": 1.0, "kept": True}}
    assert learner.optimiser.param_groups[0]["lr"] < 0.01 * learner.config.learning_rate


def test_a_shorter_training_that_does_not_settle_leaves_nothing():
    config = small(steps=40, batch_size=32, short_steps=2, schedule="one-cycle")
    tried, plain = (StrokeCNNLearner(config, KIND, seed=0) for _ in range(2))
    tried.set_validation([Example("x", examples()[0].signal, "b")])  # which is an a
    few = examples(length=40)
    fit(tried, few, seed=0)
    fit(plain, few, seed=0)  # without validation
    assert tried.outcome()["short_training"]["kept"] is False
    assert plain.outcome() == {}
    for one, other in zip(tried.network.parameters(), plain.network.parameters(), strict=True):
        torch.testing.assert_close(one, other, rtol=0, atol=0)


@pytest.mark.parametrize(("config", "length"), [({"short_steps": 0}, 400), ({"short_steps": 5}, 40_000)])
def test_no_shorter_training_where_none_is_wanted_or_there_are_many_recordings(config, length):
    learner = StrokeCNNLearner(small(steps=2000, **config), KIND, seed=0)
    learner.set_validation(examples(3))
    assert [stage.name for stage in learner.stages(examples(length=length))] == ["standardise", "classify"]


@pytest.mark.parametrize("stage", ["short", "classify"])
def test_a_training_resumed_in_any_stage_equals_the_whole(stage):
    config = small(steps=40, batch_size=32, short_steps=8, schedule="one-cycle")
    data, unseen = examples(length=40), [Example("x", examples()[0].signal, "b")]
    whole, resumed = (StrokeCNNLearner(config, KIND, seed=0) for _ in range(2))
    whole.set_validation(unseen)
    resumed.set_validation(unseen)
    kept = {}

    def keep(position, current, losses):
        if (current.name, position.step) == (stage, 5):
            kept.update(place=position, state=copy.deepcopy(whole.state()))

    fit(whole, data, seed=0, on_step=keep)
    resumed.load_state(kept["state"])
    fit(resumed, data, seed=0, start=kept["place"])
    for one, other in zip(whole.network.parameters(), resumed.network.parameters(), strict=True):
        torch.testing.assert_close(one, other, rtol=0, atol=0)


def test_an_update_is_adam_on_the_cross_entropy():
    """Sec. II-B: "The cross-entropy error was used for the loss function", and Adam for the weights."""
    learner = StrokeCNNLearner(small(dropout=0.0), KIND, seed=0)
    plain = copy.deepcopy(learner.network)
    x, which = np.random.default_rng(0).standard_normal((8, 3, 32)).astype(np.float32), np.arange(8) % 3
    probabilities = plain(torch.from_numpy(x)).softmax(1)
    loss = -probabilities[torch.arange(8), torch.from_numpy(which)].log().mean()
    loss.backward()
    assert learner.step(Stage("classify", 1), (x, which))["loss"] == pytest.approx(loss.item(), rel=1e-5)
    for ours, theirs in zip(learner.network.parameters(), plain.parameters(), strict=True):
        torch.testing.assert_close(ours.grad, theirs.grad, rtol=1e-4, atol=1e-6)
    assert type(learner.optimiser) is torch.optim.Adam
    assert (learner.optimiser.param_groups[0]["lr"], learner.config.schedule) == (1e-3, "constant")


def test_it_learns_what_is_plain():
    learner = trained(small(steps=150, learning_rate=3e-3))
    assert learner.validate(examples()) == {"recording_accuracy": 1.0}


def test_a_batch_is_judged_like_its_items():
    learner = trained()
    signal = examples()[0].signal
    windows = learner.window_probabilities(signal)
    alone = [learner.window_probabilities(signal.cut(k * 16, k * 16 + 32))[0] for k in range(len(windows))]
    np.testing.assert_allclose(windows, alone, atol=1e-5)
    np.testing.assert_allclose(windows.sum(1), 1, atol=1e-9)
    geometric = np.exp(np.log(windows).mean(0))
    np.testing.assert_allclose(learner.probabilities(signal), geometric / geometric.sum(), atol=1e-6)


def test_standardising_takes_gravity_and_level_away():
    learner = StrokeCNNLearner(small(), KIND, seed=0)
    data = [Example(e.id, e.signal.with_samples(e.signal.samples * 5 + 9.81), e.material) for e in examples()]
    learner.step(Stage("standardise", 1), data)
    x = np.stack([e.signal.samples for e in data])
    seen = learner._input(torch.from_numpy(x))
    torch.testing.assert_close(seen.mean((0, 2)), torch.zeros(3), atol=1e-4, rtol=0)
    torch.testing.assert_close(seen.std((0, 2)), torch.ones(3), atol=1e-3, rtol=0)


def test_every_window_is_equally_likely():
    """Saga et al., Sec. II-B: "randomly extracted from the collected acceleration information"."""
    data = [
        Example("short", Signal(np.zeros((1, 12)), 10, "1"), "a"),
        Example("long", Signal(np.arange(19.0), 10, "1"), "b"),
    ]
    windows = Windows(data, ("a", "b"), 10)  # 3 places and 10 places
    x, which = windows.draw(13_000, np.random.default_rng(0))
    starts = x[which == 1][:, 0, 0]
    assert np.bincount(which).tolist() == pytest.approx([3000, 10_000], rel=0.06)
    counts = np.bincount(starts.astype(int), minlength=10)
    assert len(counts) == 10
    assert counts == pytest.approx(1000, rel=0.15)


def test_what_cannot_be_learned_is_refused():
    with pytest.raises(ParameterError, match="at least 2 materials, got 1"):
        StrokeCNNLearner(small(), SignalKind(330.0, "N", ("z",), ("a",)), seed=0)
    learner = StrokeCNNLearner(small(), KIND, seed=0)
    with pytest.raises(ParameterError, match="has 20 samples, a window needs 32"):
        next(learner.batches(Stage("classify", 1), examples(3, 20), seed=0))
    with pytest.raises(ParameterError, match="at least 32 samples at 330 Hz, got 31"):
        learner.probabilities(examples(1, 31)[0].signal)
    with pytest.raises(ParameterError, match="constant on an axis"):
        learner.step(Stage("standardise", 1), [Example("c", Signal(np.ones((3, 40)), 330.0, "m/s^2"), "a")])


def test_a_signal_is_embedded_window_by_window_and_as_their_mean():
    learner = trained(small(hop=1.0))
    signal = examples(1)[0].signal
    points = learner.window_embeddings(signal)
    assert points.shape == (400 // 32, 8)
    np.testing.assert_allclose(learner.embed(signal), points.mean(axis=0), rtol=1e-6)
    np.testing.assert_allclose(learner.window_embeddings(signal.cut(32, 64))[0], points[1], atol=1e-5)


def test_windows_of_one_axis_are_no_read_only_views(recwarn):
    kind = SignalKind(330.0, "m/s^2", ("z",), ("a", "b"))
    learner = StrokeCNNLearner(small(), kind, seed=0)
    learner.probabilities(Signal(np.ones(400), 330.0, "m/s^2"))
    assert not recwarn.list
