"""Training on signals: level and fluctuation learned, conditions dropped, straightening, and old runs."""

import copy
from functools import cache

import numpy as np
import pytest
import torch
from scipy.signal import lfilter, welch

from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind, Stage
from tactogram.models.texture_flow import Config, build
from tactogram.models.texture_flow.flow_model import guided, solve
from tactogram.models.texture_flow.surfaces import SurfaceSpectra
from tactogram.signal import Signal
from tactogram.training.checkpoint import save_state
from tactogram.training.loop import TrainingPosition, fit

RATE = 1000.0
AXES = ("x", "z")
KIND = SignalKind(RATE, "m/s^2", AXES, ("cork", "tile"), simulated=True)
SMALL = Config(
    widths=(16, 16),
    embedding=16,
    frames=16,
    batch_size=4,
    steps=100,
    warm_up=5,
    learning_rate=0.01,
    solver_steps=2,
    iterations=8,
)


def recording(name, seed, seconds=3.0, **condition):
    """Simulated: noise through a filter, its axes correlated, with gravity on z."""
    angle, level = {"cork": (0.5, 0.1), "tile": (1.6, 1.0)}[name]
    noise = np.random.default_rng(seed).standard_normal((2, round(seconds * RATE) + 200))
    x, z = lfilter([1], [1, -1.6 * np.cos(angle), 0.64], noise)[:, 200:]
    samples = level * np.array([x, 0.8 * x + 0.3 * z]) / x.std() + [[0.0], [9.81]]
    return Example(f"{name}-{seed}", Signal(samples, RATE, "m/s^2", AXES), name, condition)


EXAMPLES = [recording(name, seed) for name in KIND.materials for seed in range(3)]
STROKED = [
    recording(name, seed, speed_mm_s=speed)
    for name in KIND.materials
    for seed, speed in enumerate((50.0, 100.0, 200.0))
]


@cache
def trained(stroked=False, steps=20, **config):
    """Return a learner whose flow has hardly begun: spectra and labels are measured, not learned."""
    learner = build(SMALL.model_copy(update={"steps": steps, **config}), KIND, seed=0)
    fit(learner, STROKED if stroked else EXAMPLES, seed=0)
    return learner


def spectra():
    return SurfaceSpectra(SMALL.model_copy(update={"iterations": 64}), RATE)


def test_recordings_shorter_than_a_window_are_left_out_and_refused_if_there_are_no_others():
    long = EXAMPLES[0]
    short = Example("short", long.signal.cut(0, 63), "cork")
    torch.testing.assert_close(
        spectra().measure([long.signal, short.signal]), spectra().measure([long.signal])
    )
    for samples in (63, 79):  # of a single window no deviation is known
        short = Example("short", long.signal.cut(0, samples), "cork")
        with pytest.raises(ParameterError, match="at least 80 samples, got none of cork"):
            fit(build(SMALL, KIND, seed=0), [short, recording("tile", 0)], seed=0)


def test_windows_with_too_few_bins_are_refused():
    with pytest.raises(ParameterError, match="have 2 bins at 1000 Hz, which must be a multiple of 4"):
        build(Config(widths=(16, 16), window_s=0.005), KIND, seed=0)


@pytest.mark.parametrize(("name", "level"), [("cork", 0.1), ("tile", 1.0)])
def test_level_mean_and_peak_are_those_of_the_training_data(name, level):
    signal = trained().generate({"material": name}, seconds=4, seed=1)
    assert (signal.rate, signal.unit, signal.axes, len(signal)) == (RATE, "m/s^2", AXES, 4000)
    assert signal.samples[0].std() == pytest.approx(level, rel=0.25)
    assert signal.samples[1].mean() == pytest.approx(9.81, abs=0.1)
    frequencies, density = welch(signal.samples[0], RATE, nperseg=128)
    reference = welch(recording(name, 9).signal.samples[0], RATE, nperseg=128)[1]
    assert frequencies[density.argmax()] == pytest.approx(frequencies[reference.argmax()], abs=16)


def test_training_lowers_the_loss():
    learner, losses = build(SMALL, KIND, seed=0), []
    fit(learner, EXAMPLES, seed=0, on_step=lambda position, stage, values: losses.append(values.get("loss")))
    assert losses[1] == pytest.approx(2.0, abs=0.2)  # no velocity yet: data and noise have a variance of 1
    assert np.mean(losses[-20:]) < np.mean(losses[1:21]) - 0.05
    assert learner.validate([recording("cork", 8)])["loss_unseen"] < 1.95


def test_a_straightened_flow_arrives_in_one_step_near_where_its_teacher_arrives_in_several():
    learner = trained(steps=60, straightening_steps=40, solver_steps=6)
    flow, label = learner.flow, learner._label(learner.known.surfaces[0], {}, None)[None]
    noise = torch.randn(1, 2, 32, 256, generator=torch.Generator().manual_seed(0))
    taught = guided(flow.teacher, label, flow.config.guidance)
    with torch.no_grad():
        target, plain = (solve(taught, noise, steps) for steps in (6, 1))
    times = []
    handle = flow.average.network.register_forward_pre_hook(lambda _, inputs: times.append(inputs[1].item()))
    straightened = flow.sample(noise, label)
    handle.remove()
    assert times == [0]
    assert (straightened - target).square().mean() < 0.5 * (plain - target).square().mean()


def test_straightening_goes_on_where_it_was_interrupted_and_validation_is_that_of_the_teacher():
    config = SMALL.model_copy(update={"steps": 2, "straightening_steps": 4})
    whole, again, plain = (build(config, KIND, seed=0) for _ in range(3))
    states = {}

    def keep(position, stage, losses):
        states[position] = copy.deepcopy(whole.state())

    fit(whole, EXAMPLES, seed=0, on_step=keep)
    again.load_state(states[TrainingPosition(2, 2)])
    fit(again, EXAMPLES, seed=0, start=TrainingPosition(2, 2))
    one, other = (learner.flow.average.network.state_dict() for learner in (again, whole))
    assert all(torch.equal(one[name], other[name]) for name in one)
    plain.load_state(states[TrainingPosition(1, 2)])
    assert again.validate(EXAMPLES) == whole.validate(EXAMPLES) == plain.validate(EXAMPLES)


def test_a_training_begins_with_the_weights_before_straightening(tmp_path):
    straightened = trained(steps=60, straightening_steps=40, solver_steps=6)
    save_state(tmp_path / "model.safetensors", straightened.state())
    learner = build(SMALL.model_copy(update={"start": str(tmp_path)}), KIND, seed=1)
    learner.step(Stage("fit", 1), EXAMPLES)
    begun, before = learner.flow.network.state_dict(), straightened.flow.teacher.state_dict()
    assert all(torch.equal(begun[name], before[name]) for name in before)
    assert not torch.equal(begun["last.weight"], straightened.flow.network.state_dict()["last.weight"])


def test_the_average_of_the_weights_generates():
    learner = build(SMALL, KIND, seed=0)
    learner.load_state(trained().state())
    with torch.no_grad():
        for parameter in learner.flow.network.parameters():
            parameter.zero_()
    samples = learner.generate({"material": "cork"}, seed=0).samples
    np.testing.assert_array_equal(samples, trained().generate({"material": "cork"}, seed=0).samples)


def test_conditions_are_dropped_apart():
    learner = trained(stroked=True, steps=1, dropped=0.5)
    label = learner._label(learner.known.surfaces[1], {"speed_mm_s": 200}, {"speed_mm_s": 200}).repeat(
        2000, 1
    )
    torch.manual_seed(0)
    kept = learner._with_some_dropped(label)
    size = learner.codes.shape[1]
    surface, speed = kept[:, size] == 1, kept[:, size + 8] == 1
    assert surface.float().mean() == pytest.approx(0.5, abs=0.05)
    assert (surface & speed).float().mean() == pytest.approx(0.25, abs=0.05)
    assert torch.equal(kept[:, size + 6] > 0, speed)
    assert torch.equal(kept[:, size + 2] > 0, surface)


def test_a_quarter_of_the_crops_is_told_another_recording_of_its_surface():
    learner, size = trained(stroked=True, steps=1), trained().codes.shape[1]
    _, labels = learner._batch(learner._crops(STROKED), learner._measured(STROKED), 0, 200, seed=0)
    other = labels[:, size + 1] == 1
    assert other.float().mean() == pytest.approx(0.25, abs=0.1)
    assert not (labels[other, size + 2] == labels[other, size + 6]).any()  # never the recording itself
    assert (labels[:, size + 8] == 1).all()


def test_noise_has_the_local_amplitudes_of_its_recordings():
    learner = trained()
    own, of_words = learner.known.local, np.mean(learner.known.local, axis=0)
    assert [each.shape for each in own] == [(2, 3, 41)] * 2
    noise = np.random.default_rng(0).standard_normal((2, 3000))
    recorded = KIND.signal((noise**3 + [[0.0], [9.81]]).astype(np.float32))
    clicking = learner.generate({"vibration": recorded}, seconds=3, seed=1)
    plain = learner.generate({"material": "cork"}, seconds=3, seed=1)
    amplitudes = [learner.known.local_of([each])[:, 1, -10] for each in (clicking, plain)]
    assert amplitudes[0] == pytest.approx(learner.known.local_of([recorded])[:, 1, -10], rel=0.25)
    assert amplitudes[1] == pytest.approx(own[0][:, 1, -10], rel=0.1)
    assert (amplitudes[0] > 1.3 * amplitudes[1]).all()
    source = learner.known.described({"material": {"cork": 1.0, "tile": 1.0}}, draw=0.0)
    np.testing.assert_allclose(source.at({})[0].local, of_words)


def test_a_run_of_before_local_amplitudes_loads_and_generates_without_them():
    state = {name: value for name, value in trained().state().items() if name != "local"}
    again = build(SMALL, KIND, seed=0)
    again.load_state(state)
    now, before = (each.generate({"material": "cork"}, seconds=1, seed=1) for each in (trained(), again))
    assert again.known.local == []
    assert before.samples.std(1) == pytest.approx(now.samples.std(1), rel=0.05)
    assert not np.array_equal(before.samples, now.samples)
