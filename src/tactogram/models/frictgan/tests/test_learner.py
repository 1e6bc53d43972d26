import numpy as np
import pytest
import torch
from scipy.ndimage import gaussian_filter

from tactogram.datasets import Recording, create_store
from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind
from tactogram.models.frictgan import Config
from tactogram.models.frictgan.learner import FrictGANLearner
from tactogram.signal import Image, Signal
from tactogram.training.loop import TrainingPosition, fit

MM_PER_PIXEL = 0.1
RATE = 20.0
KIND = SignalKind(RATE, "1", ("along",), ("coarse", "fine"), True, "displacement")
PERIOD_MM = {"coarse": 1.6, "fine": 0.5}
LEVEL = {"coarse": 0.6, "fine": 0.3}


def fabric(name, seed):
    """Simulated: ribs that are seen and felt, at the same places."""
    random = np.random.default_rng(seed)
    columns = np.arange(128) * MM_PER_PIXEL
    phase = 2 * np.pi * random.random()
    seen = 128 + 80 * np.sin(2 * np.pi * columns / PERIOD_MM[name] + phase)
    noise = gaussian_filter(random.standard_normal((64, 128, 3)), (1, 1, 0))
    pixels = np.clip(seen[None, :, None] + 10 * noise, 0, 255).astype(np.uint8)
    x = np.arange(round(12.8 * RATE)) / RATE
    friction = LEVEL[name] * (1 + 0.2 * np.sin(2 * np.pi * x / PERIOD_MM[name] + phase))
    signal = Signal(friction, RATE, "1", ("along",), "displacement")
    return Example(f"{name}-{seed}", signal, name, {"image": Image(pixels, MM_PER_PIXEL)})


EXAMPLES = [fabric(name, seed) for name in PERIOD_MM for seed in range(2)]


def fabric_store(path):
    """Write the examples to a store, and return its folder."""
    recordings = (
        Recording(
            streams={"friction": e.signal}, material=e.material, image=e.condition["image"], simulated=True
        )
        for e in EXAMPLES
    )
    create_store(path, recordings, name="two fabrics", licence="-", simulated=True)
    return path


def config(**changes):
    values = {
        "pixels": 32, "offset": 4, "windows": None, "protocol": "region-split", "shares": (0.5, 0.25, 0.25),
        "n_fft": 64, "hop": 16, "frames": 9, "scale": "bins", "channels": (8, 8, 16), "strides": (2, 2, 4),
        "up_strides": (4, 2, 2), "wide": 1, "latent": 8, "noise": 4, "match": "pool", "critic_channels": (8, 8, 8, 8),
        "critic_updates": 2, "batch_size": 4, "steps": 3, "dropout": 0.0, "learning_rate": 2e-3,
    }  # fmt: skip
    return Config(**{**values, **changes})


def learner(seed=0, **changes):
    return FrictGANLearner(config(**changes), KIND, seed=seed)


def trained(**changes):
    gan = learner(**changes)
    fit(gan, EXAMPLES, seed=0)
    return gan


@pytest.fixture(scope="module")
def model():
    return trained()


def test_gives_friction_over_displacement(model):
    signal = model.generate(EXAMPLES[0].condition, seed=1)
    KIND.check(signal)
    assert signal.length_mm == pytest.approx(32 * MM_PER_PIXEL, abs=1 / RATE)
    assert signal.samples.min() >= 0


@pytest.mark.parametrize("speed", [5.0, 20.0, 80.0])
def test_played_at_a_speed_it_lasts_as_long_as_asked(model, speed):
    asked = {**EXAMPLES[0].condition, "speed_mm_s": speed}
    signal = model.generate(asked, seconds=0.75, seed=1)
    assert (signal.domain, signal.rate, len(signal)) == ("time", 4000.0, 3000)
    own = model.generate(asked, seed=1)
    assert own.seconds == pytest.approx(32 * MM_PER_PIXEL / speed, abs=1e-3)


def test_what_resampling_rings_is_not_below_zero(model, monkeypatch):
    steps = np.tile(np.repeat(np.float32([0, 1]), 8), (1, 40))
    monkeypatch.setattr(model, "_along", lambda *args: steps)
    for speed in (None, 5.0, 80.0):
        condition = {**EXAMPLES[0].condition, **({"speed_mm_s": speed} if speed else {})}
        assert model.generate(condition, seed=1).samples.min() == 0


def test_a_photograph_of_another_scale_is_brought_to_that_of_training(model):
    image = EXAMPLES[0].condition["image"]
    twice = Image(np.repeat(np.repeat(image.pixels, 2, 0), 2, 1), MM_PER_PIXEL / 2)
    np.testing.assert_allclose(
        model.generate({"image": twice}, seed=1).samples,
        model.generate({"image": image}, seed=1).samples,
        atol=1e-5,
    )


def test_a_latent_is_the_noise(model):
    image = EXAMPLES[0].condition["image"]
    one, other = (
        model.generate({"image": image, "latent": np.full(4, z)}, seed=1).samples for z in (0.0, 3.0)
    )
    assert not np.array_equal(one, other)
    with pytest.raises(ParameterError, match="latent must be 4 finite numbers"):
        model.generate({"image": image, "latent": np.zeros(5)}, seed=1)


@pytest.mark.parametrize(
    ("change", "seconds", "message"),
    [
        ({}, 1.0, "need a speed"),
        ({"speed_mm_s": 0.0}, None, "speed_mm_s must be > 0"),
        ({"image": "felt.png"}, None, "image must be Image"),
        ({"image": Image(np.zeros((20, 200, 3), np.uint8))}, None, "holds no window of 32"),
    ],
)
def test_refused(model, change, seconds, message):
    with pytest.raises(ParameterError, match=message):
        model.generate({**EXAMPLES[0].condition, **change}, seconds=seconds, seed=0)


def test_signals_below_zero_are_refused_with_what_to_do():
    image = EXAMPLES[0].condition["image"]
    vibration = Signal(np.sin(np.arange(256)) - 0.1, RATE, "1", ("along",), "displacement")
    with pytest.raises(ParameterError, match=r"config\.nonnegative=false"):
        learner().stages([Example("a", vibration, "coarse", {"image": image})])


def test_epochs_are_passes_over_the_training_windows():
    gan = learner(steps=None, epochs=3)
    assert len(gan.pairs(EXAMPLES)) == 4 * 9  # 64 columns hold windows at 0, 4, …, 32
    assert gan.stages(EXAMPLES)[-1].steps == 3 * 9


@pytest.mark.parametrize(
    ("changes", "pairs"), [({}, 8), ({"critic_updates": 5}, 20), ({"adversarial": 0.0}, 4)]
)
def test_a_step_takes_a_batch_for_each_update_of_the_critic(changes, pairs):
    gan = learner(**changes)
    photo, friction, _ = next(gan.batches(gan.stages(EXAMPLES)[-1], EXAMPLES, seed=0))
    assert len(photo) == len(friction) == pairs


def test_cross_entropy_of_the_authors_code():
    gan = learner(loss="cross-entropy", latent=0, noise=0, first_norm=False)
    fit(gan, EXAMPLES, seed=0)
    batch = gan.pairs(EXAMPLES).batch(range(4))
    figures = gan._update_critic(batch.photo, gan.as_learned(batch.friction))
    assert figures["critic_loss"] == pytest.approx(
        2 * np.log(2), abs=0.1
    )  # weights of at most 0.01 cannot tell yet


def test_learns_which_fabric_has_which_level_and_ripple():
    gan = trained(steps=150, scale="log", adversarial=0.0, noise=0, batch_size=8, learning_rate=5e-4)
    levels = {e.id: float(gan.generate(e.condition, seed=0).samples.mean()) for e in EXAMPLES}
    assert levels["coarse-0"] == pytest.approx(0.6, abs=0.15)
    assert levels["fine-0"] == pytest.approx(0.3, abs=0.15)
    for part in ("train", "test"):
        pairs = gan.pairs(EXAMPLES, part)
        spectra, real = gan.spectra(pairs.batch([pairs.of(0)[0], pairs.of(2)[0]]))
        peaks = 5 + spectra[:, 0, 5:].mean(-1).argmax(-1)
        np.testing.assert_allclose(peaks, 5 + real[:, 0, 5:].mean(-1).argmax(-1), atol=1)


def test_judges_other_windows_where_no_recording_is_kept_apart(model):
    assert set(model.validate(())) == {"l1", "mse"}
    assert learner(protocol="examples").validate(()) == {}


def test_a_resumed_training_judges_the_same_windows(model):
    resumed = learner(seed=3)
    resumed.load_state(model.state())
    fit(resumed, EXAMPLES, seed=0, start=TrainingPosition(1, 3))
    assert resumed.validate(()) == model.validate(())


def test_one_photograph_gives_one_spectrogram_per_axis():
    kind = SignalKind(500.0, "m/s^2", ("x", "y", "z"), ("a",))
    signal = Signal(np.random.default_rng(0).standard_normal((3, 600)), 500.0, "m/s^2")
    gan = FrictGANLearner(config(nonnegative=False, protocol="examples"), kind, seed=0)
    example = Example("a", signal, "a", {"image": EXAMPLES[0].condition["image"]})
    fit(gan, [example], seed=0)
    generated = gan.generate(example.condition, seconds=1.1, seed=0)
    kind.check(generated)
    assert len(generated) == 550
    with pytest.raises(ParameterError, match="over time, at the speeds"):
        gan.generate({**example.condition, "speed_mm_s": 30.0}, seed=0)


def test_eval_does_not_depend_on_what_stands_beside(model):
    pairs = model.pairs(EXAMPLES)
    with torch.no_grad():
        together = model._magnitude(pairs.batch([0, 5]).photo, torch.zeros(2, 4))
        alone = model._magnitude(pairs.batch([5]).photo, torch.zeros(1, 4))
    torch.testing.assert_close(together[1:], alone, rtol=1e-4, atol=1e-5)


def test_learning_rates_fall_to_0_after_their_constant_share():
    gan = learner(constant=0.5, learning_rate=4e-4, critic_learning_rate=2e-4)
    for done, factor in ((0.0, 1.0), (0.5, 1.0), (0.75, 0.5), (0.95, 0.1)):
        gan.lower_rates(done, constant=gan.config.constant)
        rates = [optimiser.param_groups[0]["lr"] for optimiser in gan.optimisers]
        assert rates == pytest.approx([4e-4 * factor, 2e-4 * factor])


def test_a_mix_lies_between_its_photographs():
    """Cai et al. 2020, Sec. 5: "creating new virtual fabric textures"."""
    gan = learner()
    gan.step(gan.stages(EXAMPLES)[0], (EXAMPLES,))
    photo = gan.pairs(EXAMPLES).batch([0, len(gan.pairs(EXAMPLES)) - 1]).photo
    one, other = photo[:1], photo[1:]
    assert torch.equal(gan.mixed(one, other, 0.0), gan.mixed(one))
    assert torch.allclose(gan.mixed(one, other, 1.0), gan.mixed(other))
    half = gan.mixed(one, other, 0.5)
    assert not torch.allclose(half, gan.mixed(one))
    assert torch.allclose(half, gan.mixed(other, one, 0.5))
