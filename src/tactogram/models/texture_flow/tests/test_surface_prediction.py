"""Prediction of surfaces at other speeds: vectors and back, what is learned, and the whole model."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch
from benchmarks.ship import state_with_materials
from scipy.signal import lfilter, welch

from tactogram.errors import ParameterError
from tactogram.model import Example, ItemRatings, SignalKind
from tactogram.models.texture_flow import Config, build
from tactogram.models.texture_flow.signal_flow import rms
from tactogram.models.texture_flow.surface_prediction import (
    Strokes,
    SurfacePredictor,
    surface_of,
    vector_of,
)
from tactogram.models.texture_flow.surfaces import SurfaceSpectra
from tactogram.signal import Signal
from tactogram.signal.motion import Motion
from tactogram.training.loop import fit

RATE = 1000.0
SPEEDS = (50.0, 80.0, 120.0, 200.0)
MATERIALS = tuple(f"m{number}" for number in range(10))
KIND = SignalKind(RATE, "m/s^2", ("z",), MATERIALS, simulated=True)
WORDS = ("high", "loud")
CONFIG = Config(
    widths=(8, 8), embedding=16, frames=16, batch_size=4, steps=30, warm_up=5, solver_steps=2, iterations=16,
    references=1.0, prediction=True, components=12,
)  # fmt: skip


def stroke(number, speed, seed, seconds=3.0):
    """Simulated: a resonance at a frequency, and a level, in proportion to the speed."""
    ridges_per_mm, level = 0.8 + 0.1 * number, 0.002 * (1 + number % 3)
    angle = 2 * np.pi * ridges_per_mm * speed / RATE
    noise = np.random.default_rng([round(10 * number), round(speed), seed]).standard_normal(
        round(seconds * RATE) + 200
    )
    x = lfilter([1], [1, -1.8 * np.cos(angle), 0.81], noise)[200:]
    return Signal((level * speed * x / x.std())[None], RATE, "m/s^2", ("z",))


def examples(places=range(10)):
    return [
        Example(f"{number}-{speed}", stroke(number, speed, 0), f"m{number}", {"speed_mm_s": speed})
        for number in places
        for speed in SPEEDS
    ]


@cache
def trained():
    learner = build(CONFIG, KIND, seed=0)
    fit(learner, examples(), seed=0)
    return learner


@cache
def trained_on_words():
    """How high the resonance is and how loud, both 0 to 1, and no score of the second by half of the raters."""
    config = CONFIG.model_copy(update={"steps": 30})
    learner = build(config, replace(KIND, words=WORDS, scale=(1.0, 7.0)), seed=0)
    rated = [
        ItemRatings(WORDS, ("a", "b"), np.array([[n / 10, n % 3 / 2], [n / 10, np.nan]])) for n in range(10)
    ]
    fit(
        learner,
        [replace(e, item=e.material, rated=rated[int(e.id.split("-")[0])]) for e in examples()],
        seed=0,
    )
    return learner


def conditions(speed):
    """Of an unknown force and contactor."""
    return torch.tensor([speed, torch.nan, torch.nan], dtype=torch.float32)


def measure(signal):
    return SurfaceSpectra(CONFIG, RATE).measure([signal])


def test_a_vector_holds_all_of_a_surface_but_its_mean():
    noise = np.random.default_rng(0).normal([[3.0], [9.81]], 1.0, (2, 3000))
    surface = SurfaceSpectra(CONFIG, RATE).measure(
        [Signal([[1, 0], [0.5, 2]] @ noise, RATE, "m/s^2", ("x", "z"))]
    )
    vector = vector_of(surface)
    assert vector.shape == (SurfaceSpectra(CONFIG, RATE).vector_size(2),)
    for was, now in zip(surface, surface_of(vector, surface), strict=True):
        torch.testing.assert_close(was, now)


def test_all_components_give_the_vectors_back():
    torch.manual_seed(0)
    vectors, measured_at = torch.randn(9, 30) * torch.linspace(0.1, 5, 30), torch.rand(9, 2) + 0.1
    predictor = SurfacePredictor(30, components=16, conditions=("speed_mm_s", "contactor"))
    predictor.fit(Strokes(vectors, measured_at, torch.zeros(9, 0), torch.tensor([4, 5])))
    coordinates = predictor._components(vectors)
    again = (coordinates * predictor.spread) @ predictor.basis * predictor.scale + predictor.mean
    torch.testing.assert_close(again, vectors, atol=1e-3, rtol=1e-3)
    coordinates = coordinates[:, :8]
    torch.testing.assert_close(coordinates.std(0, correction=0), torch.ones(8), atol=1e-2, rtol=0)


def test_speeds_are_logarithms_within_the_recorded_range_and_0_if_unknown():
    predictor = SurfacePredictor(3, components=2, conditions=("speed_mm_s", "force_n", "contactor"))
    measured_at = torch.tensor([[50.0, torch.nan, -1], [100.0, 1.0, 1], [200.0, 2.0, 1]])
    predictor.fit(Strokes(torch.randn(3, 3), measured_at, torch.zeros(3, 0), torch.tensor([3])))
    standardised = predictor._standardised(
        torch.tensor([[50.0, 2, 1], [100, 1, 1], [400, 1, -1], [torch.nan, torch.nan, torch.nan]])
    )
    torch.testing.assert_close(
        standardised[:, 0], torch.tensor([-(1.5**0.5), 0.0, 1.5**0.5, 0.0]), atol=1e-3, rtol=0
    )
    assert not standardised[:, 1].any()  # unknown for one of the strokes
    told = predictor.conditions_of({"vibration_speed_mm_s": 80.0}, prefix="vibration_")
    assert told[0] == 80
    assert told[1].isnan()


def test_a_stroke_of_an_unknown_surface_tells_how_it_is_at_other_speeds():
    predictor = trained().known.predictor
    closer = []
    for number, speed, target in ((2.5, 50.0, 200.0), (4.5, 200.0, 80.0), (6.5, 80.0, 200.0)):
        measured, truth = (measure(stroke(number, v, 9)) for v in (speed, target))
        predicted = predictor.predict(measured, conditions(speed), conditions(target))
        error, before = (
            (s.log_root - truth.log_root).real.square().mean().sqrt().item() for s in (predicted, measured)
        )
        closer.append(error / before)
        levels = [surface.power.log().item() for surface in (measured, predicted, truth)]
        assert abs(levels[1] - levels[2]) < 0.6 * abs(levels[0] - levels[2])
        torch.testing.assert_close(predicted.mean, measured.mean)
    assert max(closer) < 0.6


def test_at_its_own_speed_a_measured_surface_stays_as_it_is():
    measured = measure(stroke(3.5, 80.0, 9))
    for target in (80.0, torch.nan):
        predicted = trained().known.predictor.predict(measured, conditions(80.0), conditions(target))
        torch.testing.assert_close(vector_of(predicted), vector_of(measured), atol=1e-3, rtol=1e-3)


def test_a_band_that_a_recording_lacks_stays_empty_and_says_nothing_of_the_rest():
    """The same stroke, and the stroke as a sensor of 400 Hz records it."""
    whole = stroke(3.5, 80.0, 9)
    spectrum = np.fft.rfft(whole.samples)
    spectrum[:, np.fft.rfftfreq(len(whole), 1 / RATE) > 190] = 0
    cut = whole.with_samples(np.fft.irfft(spectrum, len(whole)))
    bands = SurfaceSpectra(CONFIG, RATE).bands
    levels = []
    for recording in (whole, cut):
        surface = measure(recording)
        predicted = trained().known.predictor.predict(surface, conditions(80.0), conditions(200.0), bands)
        levels.append((predicted.log_root.real - surface.log_root.real).ravel() * 20 / np.log(10))
    frequency = np.arange(1, len(levels[0]) + 1) * RATE / 2 / len(levels[0])
    assert not levels[1][frequency > 260].any()
    below = frequency < 170
    assert (levels[0][below] - levels[1][below]).abs().mean() < 0.4 * levels[0][below].abs().mean()


def test_words_beyond_those_of_training_count_as_the_nearest():
    predictor = trained_on_words().known.predictor
    like, target = measure(stroke(3.5, 80.0, 9)), conditions(120.0)
    low, lower = (predictor.from_words(torch.tensor([0.0, score]), target, like) for score in (0.0, -3.0))
    torch.testing.assert_close(vector_of(low), vector_of(lower))


def test_generated_strokes_grow_with_the_speed_wanted():
    condition = {"vibration": stroke(4.5, 80.0, 9), "vibration_speed_mm_s": 80.0}
    slow, fast = (
        trained().generate(condition | {"speed_mm_s": speed}, seconds=4, seed=0).samples[0]
        for speed in (50.0, 200.0)
    )
    assert fast.std() / slow.std() == pytest.approx(4, rel=0.5)


def test_a_motion_is_followed():
    """A rest, then two steady speeds: each half is as loud as a signal at that speed, and the rest is silent."""
    times = np.array([0.0, 1.0, 1.1, 3.9, 4.1, 7.0])
    speeds = np.array([0.0, 0.0, 60.0, 60.0, 240.0, 240.0])
    motion = Motion(times, speeds, gain=np.array([0.0, 0, 1, 1, 1, 1]))
    signal = trained().generate({"material": MATERIALS[0], "motion": motion}, seed=0)
    assert len(signal) == round(7 * RATE)
    samples = signal.samples[0]
    assert np.ptp(samples[: int(0.95 * RATE)]) == 0
    for part, speed in (
        (samples[int(1.3 * RATE) : int(3.7 * RATE)], 60.0),
        (samples[int(4.3 * RATE) :], 240.0),
    ):
        steady = trained().generate({"material": MATERIALS[0], "speed_mm_s": speed}, seconds=4, seed=1)
        assert part.std() == pytest.approx(steady.samples.std(), rel=0.25)
        frequencies, density = welch(np.stack((part[-2000:], steady.samples[0, -2000:])), RATE, nperseg=128)
        peaks = frequencies[density.argmax(1)]
        assert peaks[0] == pytest.approx(peaks[1], abs=16)


def test_what_is_no_motion_of_its_recordings_is_refused():
    motion = Motion(np.array([0.0, 1.0]), np.array([50.0, 100.0]))
    for more, message in (
        ({"speed_mm_s": 50.0}, "the motion has its own speed_mm_s; omit it"),
        ({}, "at most the motion's 1"),
    ):
        with pytest.raises(ParameterError, match=message):
            trained().generate(
                {"material": MATERIALS[0], "motion": motion, **more}, seconds=2 - len(more), seed=0
            )


def test_a_material_is_predicted_from_its_strokes_at_the_speed_wanted():
    learner = trained()
    for number, speed in ((2, 100.0), (7, 160.0)):
        strokes = learner.known.strokes.of_material(number)
        assert strokes[1][:, 0].tolist() == list(SPEEDS)
        truth = measure(stroke(number, speed, 9))
        predicted = learner.known.predictor.from_strokes(*strokes, conditions(speed), truth)
        errors = [
            (surface.log_root - truth.log_root).real.square().mean().sqrt().item()
            for surface in (predicted, *(surface_of(vector, truth) for vector in strokes[0]))
        ]
        assert errors[0] < min(errors[1:])
    slow, fast = (
        learner.generate({"material": "m7", "speed_mm_s": speed}, seconds=4, seed=0).samples.std()
        for speed in (50.0, 200.0)
    )
    assert fast / slow == pytest.approx(4, rel=0.3)


def test_at_a_recorded_speed_a_material_is_its_stroke():
    vectors, measured_at = trained().known.strokes.of_material(5)
    like = measure(stroke(5, 80.0, 9))
    predicted = trained().known.predictor.from_strokes(vectors, measured_at, measured_at[1], like)
    own, other = (
        (predicted.log_root - surface_of(vectors[index], like).log_root).real.square().mean().sqrt().item()
        for index in (1, 3)
    )
    assert own < 0.3 * other


def test_of_a_material_whose_speed_is_not_asked_it_is_the_median():
    learner = trained()
    strokes, nothing = learner.known.strokes.of_material(3), conditions(torch.nan)
    like = measure(stroke(3, 80.0, 9))
    median = conditions(np.exp(np.log(SPEEDS).mean()))
    predicted, at_median = (
        learner.known.predictor.from_strokes(*strokes, target, like) for target in (nothing, median)
    )
    torch.testing.assert_close(vector_of(predicted), vector_of(at_median), atol=1e-4, rtol=1e-4)


@pytest.mark.parametrize("given", ["vibration", "material"])
def test_a_saved_model_predicts_the_same(given):
    learner = build(CONFIG, trained().kind, seed=1)
    learner.load_state(trained().state())
    described = {
        "vibration": {"vibration": stroke(4.5, 80.0, 9), "vibration_speed_mm_s": 80.0},
        "material": {"material": {"m1": 0.3, "m4": 0.7}},
    }[given]
    condition = described | {"speed_mm_s": 150.0}
    one, other = (model.generate(condition, seconds=1, seed=0).samples for model in (learner, trained()))
    np.testing.assert_array_equal(one, other)


def test_it_is_shipped_with_other_materials_than_it_was_trained_on():
    state = trained().state()
    learner = build(CONFIG, KIND, seed=0)
    learner.load_state(state)
    others = [replace(e, material=f"new-{e.material}") for e in examples((2.5, 6.5))]
    stored = state_with_materials(learner, others)
    again = build(CONFIG, replace(KIND, materials=("new-m2.5", "new-m6.5")), seed=0)
    again.load_state(stored)
    slow, fast = (
        again.generate({"material": "new-m6.5", "speed_mm_s": speed}, seconds=4, seed=0).samples.std()
        for speed in (50.0, 200.0)
    )
    assert fast / slow == pytest.approx(4, rel=0.4)
    assert {"network", "optimiser"}.isdisjoint(stored)
    assert learner.materials == MATERIALS
    again.load_state({**stored, "strokes": None, "surfaces": []})
    assert again.predicted_ranges == {}


def test_it_predicts_the_speeds_of_its_recordings():
    assert trained().predicted_ranges == {"speed_mm_s": (SPEEDS[0], SPEEDS[-1])}


def test_what_cannot_be_learned_or_asked_is_refused():
    kind = SignalKind(RATE, "m/s^2", ("z",), ("m0", "m1"), simulated=True)
    plain = [Example(e.id, e.signal, e.material) for e in examples((0, 1))]
    with pytest.raises(ParameterError, match="needs the speed_mm_s or force_n of every recording"):
        fit(build(CONFIG, kind, seed=0), plain, seed=0)
    with pytest.raises(ParameterError, match="needs several recordings of a material"):
        fit(build(CONFIG, kind, seed=0), [examples((0,))[0], examples((1,))[0]], seed=0)
    with pytest.raises(ParameterError, match="vibration_speed_mm_s is of a vibration, and none is given"):
        trained().generate({"material": "m0", "vibration_speed_mm_s": 80.0}, seed=0)
    with pytest.raises(ParameterError, match="force_n is unknown"):
        trained().generate({"vibration": stroke(0, 80.0, 0), "vibration_force_n": 1.0}, seed=0)


def test_words_describe_a_surface_at_any_speed():
    learner = trained_on_words()

    def made(**condition):
        return learner.generate(condition, seconds=4, seed=0).samples[0]

    def centre(x):
        frequencies, density = welch(x, RATE, nperseg=256)
        return frequencies @ density / density.sum()

    low, high = (made(words={"high": score, "loud": 4.0}, speed_mm_s=120.0) for score in (1.6, 5.8))
    assert centre(high) > 1.2 * centre(low)
    quiet, loud = (made(words={"loud": score}, speed_mm_s=120.0) for score in (1.0, 7.0))
    assert loud.std() > 1.8 * quiet.std()
    slow, fast = (made(words={"high": 4.0}, speed_mm_s=speed) for speed in (50.0, 200.0))
    assert fast.std() > 2 * slow.std()


def test_words_that_were_not_learned_are_refused():
    with pytest.raises(
        ParameterError, match="'words' was not learned by this run; give material or vibration"
    ):
        trained().generate({"words": {"high": 4.0}}, seed=0)
    with pytest.raises(ParameterError, match="words must be of high, loud, got 'soft'"):
        trained_on_words().generate({"words": {"soft": 4.0}}, seed=0)
    with pytest.raises(
        ParameterError, match="words and vibration describe the surface twice|vibration and words"
    ):
        trained_on_words().generate({"words": {"loud": 4.0}, "vibration": stroke(1, 80.0, 0)}, seed=0)


def test_a_vibration_in_another_unit_keeps_its_unit_and_level():
    known = {"vibration_speed_mm_s": 120.0, "speed_mm_s": 120.0}
    loud = stroke(4.5, 120.0, 9)
    scale = trained().rms / rms(loud)
    alike = loud.with_samples(scale * loud.samples)
    full_scale = loud.with_samples(2**-7 * loud.samples, unit="1")
    expected = trained().generate({"vibration": alike, **known}, seconds=2, seed=0)
    generated = trained().generate({"vibration": full_scale, **known}, seconds=2, seed=0)
    assert generated.unit == "1"
    atol = 1e-3 * float(generated.samples.std())
    np.testing.assert_allclose(generated.samples, 2**-7 / scale * expected.samples, rtol=1e-3, atol=atol)
