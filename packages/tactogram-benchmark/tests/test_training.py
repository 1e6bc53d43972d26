"""Trainings for a task."""

from collections import Counter

from tactogram import models
from tactogram_benchmark.task_kind import kind_of
from tactogram_benchmark.training import training_plan


def test_a_model_of_a_display_learns_from_the_rated_surfaces_too(tasks):
    opened = tasks.open("display")
    kind = kind_of("words")
    kind.check(opened)
    assert not any(kind.fits(tasks.open("words"), models.find(name)) for name in ("ultrasonic_cgan", "rater"))
    materials = {info.id: info.material for info in opened.store.index}
    found = {}
    for name in ("ultrasonic_cgan", "texture_flow"):
        assert kind.fits(opened, models.find(name))
        parts = training_plan(opened, models.find(name), seed=0).parts
        assert not parts.validation  # it trains the judge
        found[name] = Counter(materials[segment.id] for segment in parts.train)
    assert found["texture_flow"] == {None: 6}
    assert found["ultrasonic_cgan"] == {None: 6, "material-0": 2, "material-1": 2}
