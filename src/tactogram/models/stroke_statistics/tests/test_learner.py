import numpy as np
import pytest
import torch
from scipy.signal import lfilter
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind
from tactogram.models.stroke_statistics import Config, build
from tactogram.models.stroke_statistics.learner import _takes
from tactogram.signal import Signal
from tactogram.training.loop import fit

RATE = 400.0
AXES = ("x", "y")
KIND = SignalKind(RATE, "m/s^2", AXES, ("cork", "felt", "tile"))
SURFACES = {"cork": (0.5, 1.0), "felt": (0.9, 0.2), "tile": (-0.6, 2.0)}
"""Pole of a filter, and level."""


def stroke(material, seed, seconds=3.0):
    pole, level = SURFACES[material]
    rng = np.random.default_rng([seed, len(material), ord(material[0])])
    x = lfilter([1], [1, -pole], rng.standard_normal((2, round(seconds * RATE))))
    level *= np.exp(0.2 * rng.standard_normal())
    return Example(f"{material}-{seed}", Signal(level * x / x.std(), RATE, "m/s^2", AXES), material)


def strokes(count=4, first=0, **options):
    return [stroke(m, seed, **options) for seed in range(first, first + count) for m in SURFACES]


def trained(examples, seed=0, **config):
    learner = build(Config(**config), KIND, seed=seed)
    fit(learner, examples, seed=seed)
    return learner


LEARNER = trained(strokes())


def test_new_strokes_are_named_with_probabilities_that_sum_to_one():
    new = strokes(5, first=50)
    assert LEARNER.validate(new) == {"recording_accuracy": 1.0}
    probabilities = LEARNER.window_probabilities(new[0].signal)
    assert probabilities.shape == (5, 3)  # three seconds, a second each, by half a second
    assert probabilities.sum(1) == pytest.approx(np.ones(5), abs=1e-6)


def test_the_discriminant_is_that_of_scikit_learn_where_nothing_is_shrunk_or_weighted(monkeypatch):
    monkeypatch.setattr(
        "tactogram.models.stroke_statistics.learner.ledoit_wolf",
        lambda x, assume_centered: (x.T @ x / len(x), 0.0),
    )
    learner = trained(strokes(60), recording_weight=0.0, window_s=0.25)
    x = learner._features(stroke("felt", 99).signal, np.arange(0, 1000, 50))
    examples = strokes(60)
    features, recording = learner._training_features(examples)
    of = np.array([KIND.materials.index(str(e.material)) for e in examples])[recording]
    theirs = LinearDiscriminantAnalysis(solver="lsqr", priors=np.full(3, 1 / 3)).fit(features, of)
    ours = learner._logits(x)
    difference = (ours - ours[:, :1]) - (theirs.decision_function(x) - theirs.decision_function(x)[:, :1])
    assert np.abs(difference).max() < 0.02 * np.ptp(ours, axis=1).mean()


def test_probabilities_of_surfaces_that_are_alike_are_not_too_sure():
    rng = np.random.default_rng(3)

    def noise():
        return Signal(
            rng.standard_normal((2, 1200)) * np.exp(0.3 * rng.standard_normal()), RATE, "m/s^2", AXES
        )

    alike = [Example(str(i), noise(), m) for i, m in enumerate(list(SURFACES) * 8)]
    learner = trained(alike)
    assert np.mean([learner.probabilities(noise()).max() for _ in range(20)]) < 0.6


def test_the_right_material_is_among_the_candidates_of_as_many_recordings_as_stated():
    rng = np.random.default_rng(5)

    def alike(seed):
        example = stroke(("cork", "felt")[seed % 2], seed)
        mixed = example.signal.samples + 2 * rng.standard_normal(example.signal.samples.shape)
        return Example(example.id, Signal(mixed, RATE, "m/s^2", AXES), example.material)

    learner = trained([*map(alike, range(60)), *strokes(10)])
    new = [alike(seed) for seed in range(100, 400)]
    candidates = [learner.candidates(learner.probabilities(example.signal)) for example in new]
    share = np.mean([example.material in names for example, names in zip(new, candidates, strict=True)])
    assert 0.9 <= share <= 0.99
    assert 1.1 < np.mean([len(names) for names in candidates]) < 2  # they are hard to tell apart


def test_a_feature_that_drifts_between_recordings_counts_less():
    rng = np.random.default_rng(4)
    material = np.arange(30) % 3
    recording = np.repeat(np.arange(30), 5)
    features = np.zeros((150, LEARNER.network.statistics.count))
    features[:, 0] = material[recording] + rng.standard_normal(30)[recording] + 0.1 * rng.standard_normal(150)
    features[:, 1] = material[recording] + rng.standard_normal(150)

    def share(weight, take=material):
        learner = build(Config(recording_weight=weight), KIND, seed=0)
        learner._fit(features, material, take, recording)
        size = np.linalg.norm(learner.network.directions.numpy(), axis=1)
        return size[0] / size[1]

    assert share(10.0) < 0.6 * share(0.0)
    assert share(10.0, np.arange(30)) == share(0.0)  # no two recordings under the same conditions


def test_recordings_are_compared_under_the_same_conditions():
    conditions = [("cork", "pen", 50.0), ("felt", "pen", 50.0), ("cork", "pen", 99.0), ("cork", "pen", 50.0)]
    signal = stroke("cork", 0).signal
    examples = [
        Example("", signal, m, {"contactor": c, "speed_mm_s": v, "force_n": float(n)})
        for n, (m, c, v) in enumerate(conditions)
    ]
    assert _takes(examples).tolist() == [0, 1, 2, 0]


def test_a_short_recording_shortens_the_window_and_the_run_remembers_it():
    learner = trained([*strokes(), stroke("cork", 9, seconds=0.5)])
    assert learner.samples == 200
    again = build(Config(), KIND, seed=0)
    again.load_state(learner.state())
    signal = stroke("tile", 70).signal
    assert again.samples == 200
    np.testing.assert_array_equal(again.probabilities(signal), learner.probabilities(signal))
    with pytest.raises(ParameterError, match="must have at least 200 samples at 400 Hz, got 150"):
        learner.probabilities(stroke("tile", 70, seconds=150 / RATE).signal)


def test_most_windows_are_drawn_and_a_seed_repeats_them():
    few = [trained(strokes(), windows=20, seed=seed) for seed in (1, 1, 2)]
    first, same, other = (learner.network.mean for learner in few)
    assert torch.equal(first, same)
    assert not torch.equal(first, other)


def test_embeddings_of_one_surface_are_near_each_other():
    embedded = {m: [LEARNER.embed(stroke(m, seed).signal) for seed in (80, 81)] for m in SURFACES}
    assert embedded["cork"][0].shape == (2,)
    for m, (one, two) in embedded.items():
        others = [np.linalg.norm(one - each[0]) for name, each in embedded.items() if name != m]
        assert np.linalg.norm(one - two) < min(others)


def test_unsuitable_recordings_are_refused():
    with pytest.raises(ParameterError, match="recording cork-0 has 40 samples, a window needs 64"):
        trained([stroke("cork", 0, seconds=0.1), *strokes()])
    with pytest.raises(ParameterError, match="at least 2 materials, got 1"):
        build(Config(), SignalKind(RATE, "m/s^2", AXES, ("cork",)))
    flat = Signal(np.stack([np.ones(800), np.arange(800.0)]), RATE, "m/s^2", AXES)
    with pytest.raises(ParameterError, match="constant on an axis"):
        trained([Example(m, flat, m) for m in SURFACES])
