"""The published sizes layer by layer, and what the model promises beyond tests/test_models.py."""

import math

import numpy as np
import pytest
import torch
from torch import nn

from tactogram import models
from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind
from tactogram.models.visual_tactile_gan.config import Config
from tactogram.models.visual_tactile_gan.learner import ConditionalBatchNorm, discriminator, generator
from tactogram.recipe import Recipe
from tactogram.signal import Image, Signal
from tactogram.training.loop import fit

TABLE_1 = [
    ("down.0", (64, 128, 128), 1024),
    ("down.1", (128, 64, 64), 131_072), ("down_norms.0", (128, 64, 64), 256),
    ("down.2", (256, 32, 32), 524_288), ("down_norms.1", (256, 32, 32), 512),
    ("down.3", (512, 16, 16), 2_097_152), ("down_norms.2", (512, 16, 16), 1024),
    ("down.4", (512, 8, 8), 4_194_304), ("down_norms.3", (512, 8, 8), 1024),
    ("down.5", (512, 4, 4), 4_194_304), ("down_norms.4", (512, 4, 4), 1024),
    ("down.6", (512, 2, 2), 4_194_304), ("down_norms.5", (512, 2, 2), 1024),
    ("down.7", (512, 1, 1), 4_194_304), ("bottleneck", (512, 1, 1), 10_240),
    ("up.0", (512, 2, 2), 4_194_304), ("up_norms.0", (512, 2, 2), 1024),
    ("up.1", (512, 4, 4), 8_388_608), ("up_norms.1", (512, 4, 4), 1024),
    ("up.2", (512, 8, 8), 8_388_608), ("up_norms.2", (512, 8, 8), 1024),
    ("up.3", (512, 16, 16), 8_388_608), ("up_norms.3", (512, 16, 16), 1024),
    ("up.4", (256, 32, 32), 4_194_304), ("up_norms.4", (256, 32, 32), 512),
    ("up.5", (128, 64, 64), 1_048_576), ("up_norms.5", (128, 64, 64), 256),
    ("up.6", (64, 128, 128), 262_144), ("up_norms.6", (64, 128, 128), 128),
    ("up.7", (1, 256, 256), 2049),
]  # fmt: skip
TABLE_2 = [
    [("convs.0", (64, 129, 129), 2112),
     ("convs.1", (128, 65, 65), 131_200), ("norms.0", (128, 65, 65), 256),
     ("convs.2", (256, 33, 33), 524_544), ("norms.1", (256, 33, 33), 512),
     ("convs.3", (512, 34, 34), 2_097_664), ("norms.2", (512, 34, 34), 1024),
     ("score", (1, 35, 35), 8193)],
    [("convs.0", (64, 65, 65), 2112),
     ("convs.1", (128, 33, 33), 131_200), ("norms.0", (128, 33, 33), 256),
     ("convs.2", (256, 17, 17), 524_544), ("norms.1", (256, 17, 17), 512),
     ("convs.3", (512, 18, 18), 2_097_664), ("norms.2", (512, 18, 18), 1024),
     ("score", (1, 19, 19), 8193)],
    [("convs.0", (64, 33, 33), 2112),
     ("convs.1", (128, 17, 17), 131_200), ("norms.0", (128, 17, 17), 256),
     ("convs.2", (256, 9, 9), 524_544), ("norms.1", (256, 9, 9), 512),
     ("convs.3", (512, 10, 10), 2_097_664), ("norms.2", (512, 10, 10), 1024),
     ("score", (1, 11, 11), 8193)],
]  # fmt: skip


def layers(network, *inputs):
    """(name, shape of what comes out, parameters) of each layer, in the order they are called."""
    seen = []

    def note(name):
        def hook(module, args, out):
            seen.append((name, tuple(out.shape[1:]), sum(p.numel() for p in module.parameters())))

        return hook

    kinds = nn.Conv2d | nn.ConvTranspose2d | nn.BatchNorm2d
    for name, module in network.named_modules():
        if (isinstance(module, kinds) and "bottleneck" not in name) or name == "bottleneck":
            module.register_forward_hook(note(name))
    network(*inputs)
    return seen


def test_generator_is_table_1():
    with torch.device("meta"):
        network = generator(Config(), 9)
        seen = layers(network, torch.empty(2, 1, 256, 256), torch.empty(2, 9))
    assert seen == TABLE_1
    assert sum(p.numel() for p in network.parameters()) == 54_418_049
    assert not any(isinstance(module, nn.Dropout) for module in network.modules())  # Table 1 lists none


def test_discriminators_are_table_2():
    with torch.device("meta"):
        network = discriminator(Config())
        seen = layers(network, torch.empty(2, 2, 256, 256))
    expected = [
        (f"discriminators.{k}.{name}", *rest) for k, table in enumerate(TABLE_2) for name, *rest in table
    ]
    assert seen == expected
    assert sum(p.numel() for p in network.parameters()) == 8_296_515


KIND = SignalKind(1000.0, "m/s^2", ("z",), ("coarse", "fine"), simulated=True)


def example(material, seed):
    """Simulated: a coarse surface is dark, hums low and strongly; a fine one is bright, high and weak."""
    rng = np.random.default_rng(seed)
    time = np.arange(800) / 1000
    hum = np.sin(2 * np.pi * (60 if material == "coarse" else 400) * time + rng.uniform(0, 6))
    signal = Signal(np.float32((1 if material == "coarse" else 0.05) * hum), 1000, "m/s^2")
    dark = 60 if material == "coarse" else 190
    pixels = np.clip(rng.normal(dark, 20, (24, 24, 1)), 0, 255).astype(np.uint8).repeat(3, 2)
    return Example(f"{material}{seed}", signal, material, photographs=(Image(pixels),))


TRAINING = [example(name, seed) for name in KIND.materials for seed in range(4)]
UNSEEN = [example(name, seed) for name in KIND.materials for seed in (10, 11)]


def learner(**changes):
    facts = models.find("visual_tactile_gan")
    recipe = Recipe.load(facts.recipe("tiny"), changes={f"config.{k}": v for k, v in changes.items()})
    return facts.build(facts.config(recipe.config), KIND, seed=0)


@pytest.fixture(scope="module")
def trained():
    model = learner(
        **{"predictor.epochs": 12, "predictor.learning_rate": 0.01, "steps": 120, "learning_rate": 4e-3}
    )
    model.set_validation(UNSEEN)
    fit(model, TRAINING, seed=0)
    return model


def photo(material):
    return next(e.photographs[0] for e in UNSEEN if e.material == material)


def test_names_unseen_photographs_and_says_how_surely(trained):
    for name in KIND.materials:
        label, sure = trained.classify_photograph(photo(name))
        assert label == name
        assert 0.5 < sure <= 1


def test_two_surfaces_sound_apart_and_two_seeds_of_one_do_not(trained):
    def spectrum(name, seed):
        x = trained.generate({"image": photo(name)}, seed=seed).samples[0]
        pieces = np.abs(np.fft.rfft(x[: len(x) // 32 * 32].reshape(-1, 32))).mean(0)
        return 20 * np.log10(pieces + 1e-4)

    within = np.abs(spectrum("coarse", 0) - spectrum("coarse", 1)).mean()
    between = np.abs(spectrum("coarse", 0) - spectrum("fine", 0)).mean()
    assert between > 3 * within
    strong, weak = (trained.generate({"image": photo(name)}, seed=0).samples.std() for name in KIND.materials)
    assert strong > 3 * weak  # the level is that of the training data


def test_length_is_the_training_datas_or_as_asked(trained):
    assert trained.generate({"image": photo("fine")}, seed=0).seconds == pytest.approx(0.8)
    assert len(trained.generate({"image": photo("fine")}, seconds=1.7, seed=0)) == 1700


def test_given_material_replaces_the_predicted_label(trained):
    image = photo("fine")
    own = trained.generate({"image": image}, seed=0).samples
    np.testing.assert_array_equal(trained.generate({"image": image, "material": "fine"}, seed=0).samples, own)
    assert not np.array_equal(trained.generate({"image": image, "material": "coarse"}, seed=0).samples, own)


def test_probabilities_of_the_instance_replace_its_label(trained):
    """Neshov et al. 2026, Sec. 4.5: "conditioning the generator on more specific instance-level features"."""
    model = learner(label="probabilities")
    model.predictor.bare.load_state_dict(trained.predictor.bare.state_dict())
    crops = torch.cat([model.translation.photo({"image": photo("fine")}, n, seed=0) for n in range(5)])
    expected = model.predictor.bare.eval()(crops).softmax(1)
    torch.testing.assert_close(model.conditioning(crops)[0], expected)
    torch.testing.assert_close(model._label({"image": photo("fine")}), expected.mean(0)[None])
    torch.testing.assert_close(
        trained.conditioning(crops)[0], torch.eye(len(KIND.materials))[expected.argmax(1)]
    )


def test_weights_kept_are_the_best_on_what_is_watched(trained):
    """Neshov et al. 2026, Sec. 3.2: "the model with the lowest LPIPS score is selected"."""
    judged = trained.validate(UNSEEN)["row_statistics_unseen"]
    assert judged == pytest.approx(trained.gan.best)
    assert trained.state()["gan"]["chosen_by"] == "row_statistics"
    assert trained.state()["trunk"] == "own"


def test_without_anything_to_watch_the_last_weights_stay_and_it_says_so():
    model = learner()
    fit(model, TRAINING, seed=0)
    assert model.state()["gan"]["chosen_by"] == "last step"


def test_a_size_the_generator_cannot_halve_is_refused_before_the_predictor_is_trained():
    with pytest.raises(ParameterError, match=r"multiples of 8 for 3 stages, got \(12, 12\)"):
        learner(**{"pairs.size": 12}).stages(TRAINING)


def test_where_crops_are_split_weights_are_chosen_by_crops_kept_apart():
    model = learner(**{"pairs.protocol": "crop-split", "pairs.per_photo": 5, "pairs.per_recording": 5})
    model.set_validation(())  # --split all: no recording is kept apart
    fit(model, TRAINING, seed=0)
    assert model.state()["gan"]["chosen_by"] == "row_statistics"
    assert set(model.validate(())) == {"row_statistics_unseen", "label_accuracy_unseen"}
    train, judged = model.translation.pairs(TRAINING), model.unseen(())
    assert not set(train.pairs[:, 0]) & set(judged.pairs[:, 0])
    assert not set(train.pairs[:, 1]) & set(judged.pairs[:, 1])


def test_figures_bear_the_name_of_what_they_are_not_of_what_weights_were_chosen_by(trained):
    state = trained.state()
    state["gan"] = state["gan"] | {"chosen_by": "lpips", "best": 1e-9}
    copy = learner()
    copy.load_state(state)
    assert copy.gan.state()["chosen_by"] == "lpips"
    assert copy.validate(UNSEEN)["row_statistics_unseen"] == trained.validate(UNSEEN)["row_statistics_unseen"]
    copy.set_validation(UNSEEN)  # LPIPS is gone: what it said is not compared with what is said now
    copy.gan.choose(copy.make, copy.translation.unseen(UNSEEN))
    assert copy.gan.state()["chosen_by"] == "row_statistics"
    assert copy.gan.best > 1e-9


@pytest.mark.parametrize(
    "changes",
    [
        {"conditional": False},
        {"l1": 0.0},
        {"feature_matching": 0.0},
        {"discriminators": 1},
        {"label": "true"},
    ],
)
def test_ablations_and_variant_train(changes):
    model, seen = learner(**changes), []
    fit(model, TRAINING, seed=0, on_step=lambda position, stage, losses: seen.append((stage.name, losses)))
    assert all(math.isfinite(value) for _, losses in seen for value in losses.values())
    assert ("label predictor" in dict(seen)) == changes.get("conditional", True)


def test_without_cbn_nothing_is_named_and_no_material_taken():
    model = learner(conditional=False)
    with pytest.raises(ParameterError, match="cannot classify"):
        model.classify_photograph(photo("fine"))
    with pytest.raises(ParameterError, match="takes no material"):
        model.generate({"image": photo("fine"), "material": "fine"}, seed=0)


def test_small_photographs_missing_ones_and_several_axes_are_one_line_each(trained):
    small = Image(np.zeros((10, 30, 3), np.uint8))
    with pytest.raises(ParameterError, match="10 x 30 pixels is smaller than the crop of 16"):
        trained.generate({"image": small}, seed=0)
    bare = [Example(e.id, e.signal, e.material) for e in TRAINING]
    with pytest.raises(ParameterError, match="no recording has a photograph"):
        learner().stages(bare)
    facts = models.find("visual_tactile_gan")
    with pytest.raises(ParameterError, match="prepare.axes=\\['z'\\]"):
        facts.build(facts.config(), SignalKind(1000.0, "m/s^2", ("x", "y", "z"), ("a",)), seed=0)


def hum_db(x):
    """Level of what lies above 30 Hz, dB."""
    power = np.abs(np.fft.rfft(x * np.hanning(len(x)))) ** 2
    return 10 * np.log10(power[np.fft.rfftfreq(len(x), 1e-3) > 30].sum())


def test_matched_bands_give_the_labels_recordings_their_level_whatever_was_drawn():
    model = learner(match_bands=True, **{"pairs.excitation": "noise", "pairs.smooth": 9})
    figures = []
    fit(model, TRAINING, seed=0, on_step=lambda position, stage, losses: figures.append(losses))
    assert figures[-1]["band_correction_db"] > 3  # four steps teach next to nothing
    off = []
    for name in KIND.materials:
        real = np.mean([hum_db(e.signal.samples[0]) for e in UNSEEN if e.material == name])
        condition = {"image": photo(name), "material": name}
        ours = [hum_db(model.generate(condition, seed=seed).samples[0]) for seed in range(6)]
        plain = [hum_db(model._unmatched(condition, 0.8, seed=seed).samples[0]) for seed in range(6)]
        assert abs(np.mean(ours) - real) < 3
        off.append(abs(np.mean(plain) - real))
    assert max(off) > 6
    signal = model.generate({"image": photo("fine")}, seed=0)
    again = learner(match_bands=True, **{"pairs.excitation": "noise", "pairs.smooth": 9})
    again.load_state(model.state())
    np.testing.assert_array_equal(again.generate({"image": photo("fine")}, seed=0).samples, signal.samples)


def test_matching_needs_labels_and_recordings_longer_than_its_filters():
    with pytest.raises(ParameterError, match="needs the label"):
        learner(match_bands=True, conditional=False)
    model = learner(match_bands=True)
    brief = [Example(e.id, e.signal.cut(0, 480), e.material, photographs=e.photographs) for e in TRAINING]
    with pytest.raises(ParameterError, match=r"recordings of coarse of at least 0.501 s"):
        fit(model, brief, seed=0)


def test_a_label_is_heard_from_the_first_step_where_its_weights_begin_large():
    def heard(gain):
        model, image = learner(label_gain=gain), photo("fine")
        model.translation.fit(TRAINING)
        one, other = (model._label({"image": image, "material": name}) for name in KIND.materials)
        crop = model.translation.photo({"image": image}, 0, seed=0)
        return (model._generated(crop, one) - model._generated(crop, other)).abs().mean().item()

    assert heard(1.0) > 10 * heard(0.02)


def rand(*shape, seed=0):
    return torch.rand(*shape, generator=torch.Generator().manual_seed(seed)) * 2 - 1


def test_conditional_batch_norm_is_its_equation():
    """Neshov et al. 2026, Sec. 3.1: scale and shift are "learned linear projections" of the label."""
    layer = ConditionalBatchNorm(3, 2)
    x, label = rand(4, 3, 2, 2), torch.eye(2)[[0, 1, 0, 1]]
    mean = x.mean((0, 2, 3), keepdim=True)
    deviation = (x.var((0, 2, 3), correction=0, keepdim=True) + 1e-5).sqrt()
    gamma = label @ layer.scale.weight.T + layer.scale.bias
    beta = label @ layer.shift.weight.T + layer.shift.bias
    expected = gamma[..., None, None] * (x - mean) / deviation + beta[..., None, None]
    torch.testing.assert_close(layer(x, label), expected)


def test_conditional_batch_norm_of_a_mixed_label_lies_between():
    layer = ConditionalBatchNorm(3, 2).eval()
    x, one, other = rand(1, 3, 2, 2), torch.tensor([[1.0, 0.0]]), torch.tensor([[0.0, 1.0]])
    between = layer(x, 0.3 * one + 0.7 * other)
    torch.testing.assert_close(between, 0.3 * layer(x, one) + 0.7 * layer(x, other))
