"""Courses of effects: taken out of recordings, and given to what is generated."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.model import Example, ItemRatings, SignalKind
from tactogram.models.texture_flow import Config, build
from tactogram.models.texture_flow.courses import Course
from tactogram.signal import Signal

RATE = 1000.0
CONFIG = Config(
    widths=(16, 16), embedding=16, frames=16, batch_size=2, steps=2, iterations=4, solver_steps=1, courses=True
)


def effect(times_s, seed=0, seconds=2.0, level=0.1):
    """Noise in pulses of 0.2 s, and 12 mm/s^2 of offset."""
    times = np.arange(round(seconds * RATE)) / RATE
    gate = sum(((times >= begin) & (times < begin + 0.2)) for begin in times_s)
    x = 0.012 + level * gate * np.random.default_rng(seed).standard_normal(len(times))
    return Signal(x[None].astype(np.float32), RATE, "m/s^2", ("z",))


EARLY, LATE = effect((0.1, 0.5)), effect((1.0, 1.4, 2.2), seed=1, seconds=3.0)


def strength(signal):
    """Return the rms of every 0.1 s."""
    return (signal.samples[0, : len(signal) // 100 * 100] - 0.012).reshape(-1, 100).std(1)


def fitted(**config):
    words = ("soon", "late")
    kind = SignalKind(RATE, "m/s^2", ("z",), ("a", "b"), words=words, scale=(1.0, 7.0))
    rated = [ItemRatings(words, ("r",), np.array([means])) for means in ([1.0, 0.0], [0.0, 1.0])]
    examples = [
        Example(name, signal, name, rated=scores)
        for name, signal, scores in zip("ab", (EARLY, LATE), rated, strict=True)
    ]
    learner = build(CONFIG.model_copy(update=config), kind, seed=0)
    learner._fit(examples)
    return learner


def test_without_its_course_an_effect_is_even_and_has_no_pauses():
    times = np.arange(2000) / RATE
    fading = effect((0.0, 0.5, 1.2, 1.6), level=0.3).samples * np.exp(-times)
    signal = Signal(fading.astype(np.float32), RATE, "m/s^2", ("z",))
    course = Course.of(signal)
    assert np.mean(course.strength**2) == pytest.approx(1, rel=0.01)
    even = course.without(signal)
    assert 700 < len(even) < 1300  # of 800 in pulses
    levels = strength(even)
    assert levels.std() / levels.mean() < 0.25
    assert even.samples.std() == pytest.approx(signal.samples.std(), rel=0.25)


def test_a_short_effect_keeps_its_pauses():
    signal = effect((0.0,), seconds=0.5)
    assert len(Course.of(signal).without(signal)) == 500


def test_after_its_end_an_effect_begins_again():
    course = Course.of(EARLY)
    whole = course.over(5000, RATE)
    np.testing.assert_allclose(whole[2000:4000], whole[:2000])


def test_what_is_generated_pulses_like_the_effect_that_it_is_of():
    learner = fitted()
    for condition, recorded in (
        ({"material": "a"}, EARLY),
        ({"words": {"soon": 1.0, "late": 7.0}}, LATE),
        ({"vibration": effect((0.3, 1.5), seed=5)}, effect((0.3, 1.5), seed=5)),
    ):
        made = learner.generate(condition, seed=0)
        assert len(made) == len(recorded)
        assert np.corrcoef(strength(made), strength(recorded))[0, 1] > 0.8
        assert made.samples.std() == pytest.approx(recorded.samples.std(), rel=0.5)


def test_a_mix_has_the_course_of_one_effect():
    learner = fitted()
    made = {len(learner.generate({"material": {"a": 0.5, "b": 0.5}}, seed=seed)) for seed in range(8)}
    assert made == {2000, 3000}
    pure = {len(learner.generate({"material": {"a": 0.0, "b": 1.0}}, seed=seed)) for seed in range(8)}
    assert pure == {3000}


def test_state_keeps_courses():
    learner, again = fitted(), fitted()
    again.known.courses = []
    again.load_state(learner.state())
    made = [each.generate({"material": "b"}, seed=3).samples for each in (learner, again)]
    np.testing.assert_array_equal(*made)


def test_courses_of_friction_or_of_predicted_surfaces_are_refused():
    kind = SignalKind(20.0, "1", ("x",), ("a",), domain="displacement")
    with pytest.raises(ParameterError, match="courses are over time"):
        build(CONFIG, kind, seed=0)
    with pytest.raises(ValueError, match="give one of them"):
        Config(courses=True, prediction_steps=10)
