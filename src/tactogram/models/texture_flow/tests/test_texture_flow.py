"""Texture flow: the spectra and the way back, the flow, the network's reach, and what was learned and is refused."""

import copy
from functools import cache

import numpy as np
import pytest
import torch
from scipy.signal import csd, lfilter, welch

from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind, Stage
from tactogram.models.texture_flow import Config, build
from tactogram.models.texture_flow.flow_model import flow_loss, guided, solve, straightening_loss
from tactogram.models.texture_flow.networks import VelocityUNet
from tactogram.models.texture_flow.surfaces import Surface, SurfaceSpectra
from tactogram.signal import Image, Signal
from tactogram.signal.motion import Motion
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
def trained(stroked=False, **config):
    learner = build(SMALL.model_copy(update=config), KIND, seed=0)
    fit(learner, STROKED if stroked else EXAMPLES, seed=0)
    return learner


def spectra():
    return SurfaceSpectra(SMALL.model_copy(update={"iterations": 64}), RATE)


def surfaces():
    return [spectra().measure([e.signal for e in EXAMPLES if e.material == name]) for name in KIND.materials]


def coherency(samples):
    a, b = samples - samples.mean(1, keepdims=True)
    cross, own, other = (csd(p, q, RATE, nperseg=128)[1] for p, q in ((a, b), (a, a), (b, b)))
    return cross / np.sqrt(np.abs(own * other))


# -- spectra ------------------------------------------------------------------------------------------------


def test_sources_of_every_surface_are_alike():
    for name, surface in zip(KIND.materials, surfaces(), strict=True):
        values = torch.cat(
            [spectra().encode(e.signal.samples, surface) for e in EXAMPLES if e.material == name], -1
        )
        assert values.shape[:2] == (2, 32)
        torch.testing.assert_close(values.mean(-1), torch.zeros(2, 32), atol=1e-3, rtol=0)
        torch.testing.assert_close(values.std(-1), torch.ones(2, 32), atol=1e-3, rtol=0)


@pytest.mark.parametrize("place", [0, 1])
def test_decoded_spectra_have_the_level_spectrum_coherence_and_mean_of_the_recording(place):
    surface = surfaces()[place]
    samples = next(e for e in EXAMPLES if e.material == KIND.materials[place]).signal.samples
    made = spectra().decode(spectra().encode(samples, surface), [surface], 2400, seed=0)
    assert made.shape == (2, 2400)
    assert made.mean(1) == pytest.approx([0.0, 9.81], abs=0.02)
    assert made.std(1) == pytest.approx(samples.std(1), rel=0.05)
    ours, theirs = (10 * np.log10(welch(x, RATE, nperseg=128)[1][:, 1:-1]) for x in (made, samples))
    assert np.abs(ours - theirs).mean() < 1.0
    assert np.abs(coherency(made) - coherency(samples))[2:-2].mean() < 0.12
    assert np.abs(coherency(samples)).mean() > 0.9


def test_magnitudes_survive_the_way_back():
    found, surface = spectra(), surfaces()[0]
    spectrum = found.encode(EXAMPLES[0].signal.samples, surface)
    made = found.decode(spectrum, [surface], 2400, seed=0)
    again = found.encode(made, surface)
    # Frame k is centred on hop k; the signal begins 16.5 hops after the first, and its first window is 2 hops later.
    kept = (spectrum[..., 18 : 18 + again.shape[-1]] + spectrum[..., 19 : 19 + again.shape[-1]]) / 2
    assert np.corrcoef(again.flatten(), kept.flatten())[0, 1] > 0.8


def test_a_mix_lies_between_in_the_logarithm():
    one, other = surfaces()
    half = Surface.mixed([one, other], np.array([3.0, 3.0]))
    assert half.power.log() == pytest.approx((one.power.log() + other.power.log()).item() / 2, abs=1e-4)
    torch.testing.assert_close(half.code, (one.code + other.code) / 2)
    torch.testing.assert_close(
        Surface.mixed([one, other], np.array([0.0, 2.0])).root, other.root, rtol=1e-3, atol=1e-4
    )
    values = torch.randn(2, 32, 48, generator=torch.Generator().manual_seed(0))
    rms = [spectra().decode(values, [surface], 2000, seed=0)[0].std() for surface in (one, half, other)]
    assert rms[0] < 0.5 * rms[1] < 0.25 * rms[2]


def test_surfaces_change_over_the_signal():
    one, other = surfaces()
    frames = spectra().frames(4000, 1)
    values = torch.randn(2, 32, frames, generator=torch.Generator().manual_seed(0))
    made = spectra().decode(values, [one, one, other, other], 4000, seed=0)
    first, last = (spectra().decode(values, [surface], 4000, seed=0) for surface in (one, other))
    assert made[0, :1200].std() == pytest.approx(first[0, :1200].std(), rel=0.05)
    assert made[0, 2800:].std() == pytest.approx(last[0, 2800:].std(), rel=0.05)
    assert 2 * first[0].std() < made[0, 1800:2200].std() < last[0].std()


def test_the_code_tells_levels_and_how_fast_strength_changes():
    noise = np.random.default_rng(0).standard_normal(30_000)
    slow, fast = (1 + 0.9 * np.sin(2 * np.pi * rate * np.arange(30_000) / RATE) for rate in (0.5, 2.0))
    codes = [
        spectra().measure([Signal(x[None], RATE, "1", ("z",))]).code
        for x in (noise, 10 * noise, slow * noise, fast * noise)
    ]
    bands = len(spectra().bands)
    assert len(codes[0]) == spectra().code_size(1) == 10 * bands
    level, *_, lag_16 = (torch.stack(codes).reshape(4, 10, bands)[:, k] for k in range(10))
    torch.testing.assert_close(level[1] - level[0], torch.full((bands,), np.log(10.0)), rtol=0, atol=1e-3)
    assert lag_16[0].abs().max() < 0.15
    assert lag_16[2].min() > 0.2
    assert lag_16[3].max() < -0.2  # 16 hops of 16 ms are half a period


def test_the_faintest_magnitudes_are_silence():
    made = spectra().decode(torch.full((2, 32, 50), -20.0), [surfaces()[1]], 500, seed=0)
    assert made.std(1) == pytest.approx([0, 0], abs=1e-6)


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


# -- flow ---------------------------------------------------------------------------------------------------


def test_the_loss_of_the_true_velocity_is_zero():
    data = torch.full((64, 2, 3), 0.8)

    def true(x, time):
        return (data - x) / (1 - time)[:, None, None]

    torch.manual_seed(0)
    assert flow_loss(true, data).item() == pytest.approx(0, abs=1e-6)
    assert flow_loss(lambda x, t: true(x, t) + 0.5, data).item() == pytest.approx(0.25, abs=1e-4)


def test_a_large_element_does_not_outweigh_the_others():
    torch.manual_seed(0)
    data = torch.randn(400, 50)
    large = torch.cat((data[:200], 30 * data[200:]))
    losses = [flow_loss(lambda x, time: torch.zeros_like(x), x).item() for x in (data, large)]
    assert losses[0] == pytest.approx(1.9, abs=0.1)
    assert losses[1] == pytest.approx(1.45, abs=0.1)  # half of it 1, not 900


def test_the_solver_is_of_second_order():
    """dx/dt = cos(3 t) x has the solution exp(sin(3 t) / 3)."""
    start = torch.ones(1, 1, dtype=torch.float64)
    errors = [
        abs(
            solve(lambda x, time: torch.cos(3 * time)[:, None] * x, start, steps).item()
            - np.exp(np.sin(3) / 3)
        )
        for steps in (16, 32)
    ]
    assert errors[0] < 0.02
    assert errors[1] < 0.3 * errors[0]


def test_the_solver_evaluates_the_velocity_once_per_step_and_misses_only_its_change_in_the_first():
    """dx/dt = 2 t has the solution t^2, of which Euler's first step, to 1/8, finds nothing."""
    times = []

    def velocity(x, time):
        times.append(time[0].item())
        return 2 * time[:, None] * torch.ones_like(x)

    found = solve(velocity, torch.zeros(1, 1, dtype=torch.float64), 4)
    assert found.item() == pytest.approx(1 - 1 / 64)
    assert times == pytest.approx([0, (1 / 4) ** 1.5, (2 / 4) ** 1.5, (3 / 4) ** 1.5])


def test_one_step_is_straight_where_it_ends_with_the_teacher():
    """The teacher flows from every noise to four times its value, dx/dt = 3 x / (1 + 3 t), which bends no path."""
    torch.manual_seed(0)
    noise = 0.1 * torch.randn(5, 2, 3)
    slope = torch.tensor(3.0, requires_grad=True)

    def teacher(x, time):
        return slope * x / (1 + 3 * time)[:, None, None]

    def loss(velocity):
        return straightening_loss(velocity, teacher, noise, 6)

    assert loss(lambda x, time: 3 * x).item() == pytest.approx(0, abs=1e-9)
    assert loss(lambda x, time: 3 * x + 0.5 + time[:, None, None]).item() == pytest.approx(0.25, abs=1e-4)
    assert not loss(lambda x, time: 3 * x).requires_grad


# -- network ------------------------------------------------------------------------------------------------


def test_what_is_far_away_does_not_matter():
    network = trained().flow.average.network
    noise = torch.randn(1, 2, 32, 256, generator=torch.Generator().manual_seed(0))
    changed = noise.clone()
    changed[..., 160:] = 0
    time, label = torch.tensor([0.3]), trained()._label(trained().known.surfaces[0], {}, None)[None]
    with torch.no_grad():
        one, other = network(noise, time, label), network(changed, time, label)
    torch.testing.assert_close(one[..., :96], other[..., :96], atol=1e-5, rtol=1e-4)
    assert not torch.allclose(one[..., 159], other[..., 159], atol=1e-3)


def test_a_label_may_change_over_columns():
    network = trained().flow.average.network
    noise = torch.randn(1, 2, 32, 256, generator=torch.Generator().manual_seed(0))
    one, other = (trained()._label(surface, {}, None) for surface in trained().known.surfaces)
    time = torch.tensor([0.3])
    with torch.no_grad():
        found = [network(noise, time, label[None]) for label in (one, other)]
        same = network(noise, time, one.expand(1, 256, -1))
        both = network(noise, time, torch.cat((one.expand(128, -1), other.expand(128, -1)))[None])
    torch.testing.assert_close(same, found[0], atol=1e-5, rtol=1e-4)
    torch.testing.assert_close(both[..., :64], found[0][..., :64], atol=1e-5, rtol=1e-4)
    torch.testing.assert_close(both[..., 192:], found[1][..., 192:], atol=1e-5, rtol=1e-4)
    assert not torch.allclose(found[0], found[1], atol=1e-2)


def test_an_untrained_network_gives_no_velocity():
    network = VelocityUNet(SMALL, channels=2, labels=3)
    assert not network(torch.randn(2, 2, 32, 16), torch.rand(2), torch.rand(2, 3)).any()


# -- learner ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "level"), [("cork", 0.1), ("tile", 1.0)])
def test_level_mean_and_peak_are_those_of_the_training_data(name, level):
    made = trained().generate({"material": name}, seconds=4, seed=1)
    assert (made.rate, made.unit, made.axes, len(made)) == (RATE, "m/s^2", AXES, 4000)
    assert made.samples[0].std() == pytest.approx(level, rel=0.25)
    assert made.samples[1].mean() == pytest.approx(9.81, abs=0.1)
    frequencies, density = welch(made.samples[0], RATE, nperseg=128)
    reference = welch(recording(name, 9).signal.samples[0], RATE, nperseg=128)[1]
    assert frequencies[density.argmax()] == pytest.approx(frequencies[reference.argmax()], abs=16)


def test_training_lowers_the_loss():
    learner, losses = build(SMALL, KIND, seed=0), []
    fit(learner, EXAMPLES, seed=0, on_step=lambda place, stage, found: losses.append(found.get("loss")))
    assert losses[1] == pytest.approx(2.0, abs=0.2)  # no velocity yet: data and noise have a variance of 1
    assert np.mean(losses[-20:]) < np.mean(losses[1:21]) - 0.05
    assert learner.validate([recording("cork", 8)])["loss_unseen"] < 1.95


def test_a_longer_signal_begins_with_the_same_spectrum():
    learner = trained()
    label = learner._label(learner.known.surfaces[0], {}, None)[None]
    short, long = (learner._spectrum(label, length, seed=4) for length in (3000, 6000))
    torch.testing.assert_close(short[..., :64], long[..., :64], atol=1e-3, rtol=1e-3)
    assert np.corrcoef(long[..., :64].flatten(), long[..., 64:128].flatten())[0, 1] < 0.3


def test_a_straightened_flow_arrives_in_one_step_near_where_its_teacher_arrives_in_several():
    learner = trained(straightening_steps=60, solver_steps=6)
    flow, label = learner.flow, learner._label(learner.known.surfaces[0], {}, None)[None]
    noise = torch.randn(1, 2, 32, 256, generator=torch.Generator().manual_seed(0))
    taught = guided(flow.teacher, label, flow.config.guidance)
    with torch.no_grad():
        wanted, plain = (solve(taught, noise, steps) for steps in (6, 1))
    times = []
    handle = flow.average.network.register_forward_pre_hook(lambda _, given: times.append(given[1].item()))
    made = flow.sample(noise, label)
    handle.remove()
    assert times == [0]
    assert (made - wanted).square().mean() < 0.5 * (plain - wanted).square().mean()


def test_straightening_goes_on_where_it_was_interrupted_and_validation_is_that_of_the_teacher():
    config = SMALL.model_copy(update={"steps": 2, "straightening_steps": 4})
    whole, again, plain = (build(config, KIND, seed=0) for _ in range(3))
    states = {}

    def keep(at, stage, losses):
        states[at] = copy.deepcopy(whole.state())

    fit(whole, EXAMPLES, seed=0, on_step=keep)
    again.load_state(states[TrainingPosition(2, 2)])
    fit(again, EXAMPLES, seed=0, start=TrainingPosition(2, 2))
    one, other = (learner.flow.average.network.state_dict() for learner in (again, whole))
    assert all(torch.equal(one[name], other[name]) for name in one)
    plain.load_state(states[TrainingPosition(1, 2)])
    assert again.validate(EXAMPLES) == whole.validate(EXAMPLES) == plain.validate(EXAMPLES)


def test_a_training_begins_with_the_weights_before_straightening(tmp_path):
    straightened = trained(straightening_steps=60, solver_steps=6)
    save_state(tmp_path / "model.safetensors", straightened.state())
    learner = build(SMALL.model_copy(update={"start": str(tmp_path)}), KIND, seed=1)
    learner.step(Stage("fit", 1), EXAMPLES)
    begun, before = learner.flow.network.state_dict(), straightened.flow.teacher.state_dict()
    assert all(torch.equal(begun[name], before[name]) for name in before)
    assert not torch.equal(begun["last.weight"], straightened.flow.network.state_dict()["last.weight"])


def test_weights_are_scaled_to_sum_to_one():
    one, other = (trained().generate({"material": {"cork": w, "tile": 3 * w}}, seed=0) for w in (1, 2))
    np.testing.assert_array_equal(one.samples, other.samples)


def test_the_average_of_the_weights_generates():
    learner = build(SMALL, KIND, seed=0)
    learner.load_state(trained().state())
    with torch.no_grad():
        for parameter in learner.flow.network.parameters():
            parameter.zero_()
    made = learner.generate({"material": "cork"}, seed=0).samples
    np.testing.assert_array_equal(made, trained().generate({"material": "cork"}, seed=0).samples)


def test_the_default_length_is_that_of_the_recordings():
    assert len(trained().generate({"material": "cork"}, seed=0)) == 3000


def test_guidance_of_zero_ignores_speed_and_material():
    free = trained(stroked=True, guidance=0.0)
    label = free._label(free.known.surfaces[0], {"speed_mm_s": 50}, None)[None]
    other = free._label(free.known.surfaces[1], {"speed_mm_s": 200}, None)[None]
    torch.testing.assert_close(free._spectrum(label, 500, seed=1), free._spectrum(other, 500, seed=1))
    strong = trained(stroked=True, guidance=2.0)
    assert not torch.equal(strong._spectrum(label, 500, seed=1), strong._spectrum(other, 500, seed=1))


def test_speed_is_told_from_its_absence_and_limited_to_what_was_recorded():
    learner = trained(stroked=True)
    surface, size = learner.known.surfaces[0], learner.codes.shape[1]
    labels = {
        v: learner._label(surface, {"speed_mm_s": v}, None).tolist() for v in (None, 100.0, 200.0, 900.0)
    }
    assert labels[100.0][size:] == [1, 0, 0, 0, 0, 0, 0, 0, 1, 0]  # the median; no force
    assert labels[None][size:] == [1, 0, 0, 0, 0, 0, 0, 0, 0, 0]
    assert labels[200.0] == labels[900.0]
    assert labels[200.0][size + 6] > 1
    measured = learner._label(surface, {}, {"speed_mm_s": 200.0}).tolist()
    assert measured[size:] == [1, 1, labels[200.0][size + 6], 0, 1, 0, 0, 0, 0, 0]
    with pytest.raises(ParameterError, match="force_n is unknown"):
        learner.generate({"material": "cork", "force_n": 1.0}, seed=0)


def test_conditions_are_dropped_apart():
    learner = trained(stroked=True, dropped=0.5)
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


def test_a_recording_stands_for_its_surface():
    learner, stroke = trained(), recording("tile", 9, seconds=1.0)
    made = learner.generate({"vibration": stroke.signal}, seconds=4, seed=1)
    assert made.samples[0].std() == pytest.approx(stroke.signal.samples[0].std(), rel=0.25)
    with pytest.raises(ParameterError, match="material and vibration describe the surface twice"):
        learner.generate({"material": "cork", "vibration": stroke.signal}, seed=0)
    with pytest.raises(ParameterError, match="condition 'material' is needed, or vibration instead"):
        learner.generate({}, seed=0)
    with pytest.raises(ParameterError, match="at least 80 samples, got none of the vibration"):
        learner.generate({"vibration": stroke.signal.cut(0, 79)}, seed=0)


def test_a_quarter_of_the_crops_is_told_another_recording_of_its_surface():
    learner, size = trained(stroked=True), trained().codes.shape[1]
    _, labels = learner._batch(learner._crops(STROKED), learner._measured(STROKED), 0, 200, seed=0)
    other = labels[:, size + 1] == 1
    assert other.float().mean() == pytest.approx(0.25, abs=0.1)
    assert not (labels[other, size + 2] == labels[other, size + 6]).any()  # never the recording itself
    assert (labels[:, size + 8] == 1).all()


def test_a_photograph_stands_for_the_material_it_shows():
    rng = np.random.default_rng(0)
    plain, striped = rng.integers(120, 136, (48, 48, 3)), rng.integers(120, 136, (48, 48, 3))
    striped[::4] += 80
    shown = {
        name: [Image(x.astype(np.uint8))] for name, x in zip(KIND.materials, (plain, striped), strict=True)
    }
    examples = [Example(e.id, e.signal, e.material, {}, shown[str(e.material)]) for e in EXAMPLES]
    learner = build(SMALL.model_copy(update={"steps": 1}), KIND, seed=0)
    fit(learner, examples, seed=0)
    again = build(SMALL, KIND, seed=1)
    again.load_state(learner.state())
    turned = Image(np.ascontiguousarray(shown["tile"][0].pixels.swapaxes(0, 1)))
    name, probability = again.classify_photograph(turned)
    assert (name, probability > 0.9) == ("tile", True)
    made, tile = (
        again.generate(c, seconds=2, seed=0).samples for c in ({"image": turned}, {"material": "tile"})
    )
    assert made.std() == pytest.approx(tile.std(), rel=0.3)


def test_a_run_without_photographs_refuses_one_and_says_what_to_give_instead():
    refused = (
        "condition 'image' was not learned by this run; give material (by name, or a text that describes it) or "
        "vibration, or train on recordings with photographs of two materials or more"
    )
    with pytest.raises(ParameterError) as error:
        trained().generate({"image": Image(np.zeros((48, 48, 3), np.uint8))}, seed=0)
    assert str(error.value) == refused


def test_frames_that_the_network_cannot_halve_are_refused():
    with pytest.raises(ValueError, match="multiple of 32"):
        Config(widths=(8, 8, 8, 8, 8), frames=40)


def test_a_recording_of_few_windows_has_a_code():
    """Of 4 to 20 windows: fewer than the longest lag, so that nothing is known of it."""
    for frames in (4, 10, 17, 20):
        signal = EXAMPLES[0].signal.cut(0, spectra().samples(frames))
        code = spectra().measure([signal]).code
        assert code.isfinite().all()
        assert (code[-len(spectra().bands) :] == 0).all() == (frames <= 16)


# -- over displacement -------------------------------------------------------------------------------------


def friction(name, seed):
    """Simulated: a coefficient of friction over 60 mm at 20 samples per mm, with a rib every 4 mm or every mm."""
    period, level = {"cork": (4.0, 0.6), "tile": (1.0, 0.2)}[name]
    rng = np.random.default_rng(seed)
    place = np.arange(1200) / 20 + rng.uniform(0, period)
    ripple = np.sin(2 * np.pi * place / period) + 0.3 * rng.standard_normal(1200)
    return Example(
        f"{name}-{seed}", Signal(level + 0.05 * ripple[None], 20.0, "1", ("along",), "displacement"), name
    )


@cache
def rubbed():
    kind = SignalKind(20.0, "1", ("along",), ("cork", "tile"), simulated=True, domain="displacement")
    learner = build(SMALL.model_copy(update={"window_samples": 128, "frames": 8}), kind, seed=0)
    fit(learner, [friction(name, seed) for name in kind.materials for seed in range(3)], seed=0)
    return learner


def test_friction_over_displacement_keeps_its_level_and_period():
    for name, level, period in (("cork", 0.6, 4.0), ("tile", 0.2, 1.0)):
        made = rubbed().generate({"material": name}, seed=1)
        assert (made.domain, made.rate, made.unit, len(made)) == ("displacement", 20.0, "1", 1200)
        assert made.samples.mean() == pytest.approx(level, abs=0.01)
        assert made.samples.std() == pytest.approx(0.05 * np.hypot(0.5**0.5, 0.3), rel=0.25)
        frequency, power = welch(made.samples[0], 20.0, nperseg=256)
        assert frequency[power.argmax()] == pytest.approx(1 / period, abs=0.1)


def test_friction_is_felt_at_a_speed_for_any_time():
    made = rubbed().generate({"material": "cork", "speed_mm_s": 80.0}, seconds=2.0, seed=1)
    assert (made.domain, made.seconds) == ("time", pytest.approx(2.0, abs=1e-3))
    assert made.samples.mean() == pytest.approx(0.6, abs=0.01)
    frequency, power = welch(made.samples[0], made.rate, nperseg=len(made) // 2)
    assert frequency[power.argmax()] == pytest.approx(80 / 4, abs=1.5)


def test_friction_is_felt_along_a_motion():
    motion = Motion(
        np.array([0.0, 2.0, 2.01, 3.0, 3.01, 4.0]), np.array([80.0, 80.0, 0.0, 0.0, 0.0, 0.0]),
        contact=np.array([1.0, 1, 1, 1, 0, 0]),
    )  # fmt: skip
    made = rubbed().generate({"material": "cork", "motion": motion}, seed=1)
    assert (made.domain, made.seconds) == ("time", pytest.approx(4.0, abs=1e-3))
    frequency, power = welch(made.samples[0, :8000], made.rate, nperseg=4000)
    assert frequency[power.argmax()] == pytest.approx(80 / 4, abs=1.5)
    assert np.ptp(made.samples[0, 8400:11600]) < 1e-3  # a finger at rest feels the friction where it is
    assert made.samples[0, 10000] == pytest.approx(0.6, abs=0.2)
    assert not made.samples[0, 12200:].any()
    fast = Motion(np.array([0.0, 0.2]), np.array([0.0, 1200.0]))
    assert rubbed().generate({"material": "cork", "motion": fast}, seed=1).seconds == pytest.approx(
        0.2, abs=1e-3
    )
    with pytest.raises(ParameterError, match="at most the motion's 4, got 5"):
        rubbed().generate({"material": "cork", "motion": motion}, seconds=5, seed=1)
    with pytest.raises(ParameterError, match="motion must be a Motion, got str"):
        rubbed().generate({"material": "cork", "motion": "simulated"}, seed=1)


def test_what_friction_cannot_be_is_refused():
    with pytest.raises(ParameterError, match="over displacement need a speed: give speed_mm_s"):
        rubbed().generate({"material": "cork"}, seconds=2.0, seed=1)
    with pytest.raises(ParameterError, match="speed_mm_s must be > 0, got 0"):
        rubbed().generate({"material": "cork", "speed_mm_s": 0}, seed=1)
    with pytest.raises(ParameterError, match=r"256 samples have 128 bins.*config\.window_samples"):
        SurfaceSpectra(Config(widths=(8,) * 8, frames=256), 20.0, "displacement")


def test_noise_has_the_local_amplitudes_of_its_recordings():
    learner = trained()
    own, of_words = learner.known.local, np.mean(learner.known.local, axis=0)
    assert [each.shape for each in own] == [(2, 3, 41)] * 2
    noise = np.random.default_rng(0).standard_normal((2, 3000))
    given = KIND.signal((noise**3 + [[0.0], [9.81]]).astype(np.float32))
    clicking = learner.generate({"vibration": given}, seconds=3, seed=1)
    made = learner.generate({"material": "cork"}, seconds=3, seed=1)
    found = [learner.known.local_of([each])[:, 1, -10] for each in (clicking, made)]
    assert found[0] == pytest.approx(learner.known.local_of([given])[:, 1, -10], rel=0.25)
    assert found[1] == pytest.approx(own[0][:, 1, -10], rel=0.1)
    assert (found[0] > 1.3 * found[1]).all()
    at = learner.known.described({"material": {"cork": 1.0, "tile": 1.0}}, draw=0.0)
    np.testing.assert_allclose(at({})[0].local, of_words)


def test_a_run_of_before_local_amplitudes_loads_and_generates_without_them():
    state = {name: value for name, value in trained().state().items() if name != "local"}
    again = build(SMALL, KIND, seed=0)
    again.load_state(state)
    now, before = (each.generate({"material": "cork"}, seconds=1, seed=1) for each in (trained(), again))
    assert again.known.local == []
    assert before.samples.std(1) == pytest.approx(now.samples.std(1), rel=0.05)
    assert not np.array_equal(before.samples, now.samples)
