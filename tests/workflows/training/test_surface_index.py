"""The distance of the surface search, and the threshold of "none of these"."""

import numpy as np
import pytest

from tactogram.model import Example
from tactogram.signal import Signal
from tactogram.workflows.recognition.search import search
from tactogram.workflows.training import surface_index
from tactogram.workflows.training.surface_index import (
    BANDS,
    SurfaceIndex,
    band_levels,
    build_index,
    prediction_limit,
    surface_vector,
    surface_vectors,
    whitening_of,
)

SPREAD = np.array([3.0, 0.1, 0.1, 0.1, 0.1, 0.1])
"""Standard deviations of recordings of one material: large along the first feature, which says nothing about it."""
MATERIALS = ("cork", "foam", "tile")


class Points:
    """An embedder of signals that are their own embedding, beside a number that makes all lengths nearly equal."""

    def embed(self, signal):
        return np.append(signal.samples[0], 1000).astype(np.float32)


@pytest.fixture
def level(monkeypatch):
    """Let all recordings have the same spectrum."""
    monkeypatch.setattr(surface_index, "band_levels", lambda signal: np.zeros(BANDS))


def drawn(random, count, materials=MATERIALS):
    """Return ``count`` recordings per material, whose means are 2 apart along all features but the first."""
    for place, name in enumerate(materials):
        middle = np.zeros(len(SPREAD))
        middle[1 + place] = 2.0
        for number in range(count):
            point = middle + SPREAD * random.standard_normal(len(SPREAD))
            yield Example(f"{name}-{number}", Signal(point[None], 100.0, "1"), name)


def whitened(vectors, materials):
    return vectors @ whitening_of(vectors, materials)


def test_one_is_the_distance_of_two_recordings_of_a_material():
    vectors = np.random.default_rng(0).normal(size=(200, 4)).astype(np.float32) * [5, 1, 1, 1]
    materials = ["a", "b"] * 100
    points = whitened(vectors.astype(np.float32), materials)
    squares = [
        np.sum((one - other) ** 2)
        for part in (points[::2], points[1::2])
        for i, one in enumerate(part)
        for other in part[:i]
    ]
    assert np.mean(squares) == pytest.approx(1, rel=0.02)


def test_a_direction_counts_by_how_little_recordings_of_one_material_differ_in_it():
    random = np.random.default_rng(1)
    known = list(drawn(random, 40))
    vectors = np.stack([Points().embed(example.signal) for example in known])
    matrix = whitening_of(vectors, [example.material for example in known]).astype(np.float64)
    loud, quiet = np.linalg.norm(matrix[0]), np.linalg.norm(matrix[5])
    # Half of each variance is the mean of all seven: 9.05 / 7.
    assert quiet / loud == pytest.approx(np.sqrt((9 + 9.05 / 7) / (0.01 + 9.05 / 7)), rel=0.15)


@pytest.mark.parametrize("materials", [["a", "b", "c"], ["a"] * 3])
def test_distances_exist_with_one_recording_of_each_material_or_without_variation(materials):
    points = np.array([[0, 0], [3, 0], [0, 4]], np.float32)
    assert np.isfinite(whitening_of(points, materials)).all()
    np.testing.assert_array_equal(whitening_of(np.ones((3, 2), np.float32), materials), np.eye(2))


def test_the_threshold_keeps_the_share_it_states_of_new_recordings(level):
    kept, refused = [], []
    for seed in range(40):
        random = np.random.default_rng(seed)
        index = build_index(Points(), list(drawn(random, 20)), list(drawn(random, 10)))
        assert index.calibrated_on == 30

        def novelties(examples, index=index):
            return np.array([index.novelty(surface_vector(Points(), e.signal)) for e in examples])

        kept.append(np.mean(novelties(drawn(random, 20)) <= 1))
        others = drawn(random, 20, ("x", "x", "x", "x", "wool"))
        refused.append(np.mean(novelties(e for e in others if e.material == "wool") > 1))
    assert np.mean(kept) == pytest.approx(0.95, abs=0.02)
    assert np.mean(refused) > 0.9


def test_without_validation_each_recording_is_compared_with_the_others(level):
    known = list(drawn(np.random.default_rng(3), 20))
    index = build_index(Points(), known, [])
    points = surface_vectors(Points(), known) @ index.whitening
    apart = np.linalg.norm(points[:, None] - points[None], axis=2) + np.diag([np.inf] * len(points))
    assert index.threshold == pytest.approx(prediction_limit(apart.min(axis=1)), rel=1e-4)
    assert index.calibrated_on == 0


def test_a_band_is_half_an_octave_of_each_axis_in_decibels():
    rate, time = 2000.0, np.arange(20_000) / 2000.0
    # 600 Hz lies in the second half octave below 1,000 Hz, 100 Hz in the seventh.
    axes = [np.sin(2 * np.pi * frequency * time) for frequency in (600.0, 100.0)]
    signal = Signal(np.stack(axes), rate, "m/s^2", ("x", "y"))
    levels = band_levels(signal).reshape(2, BANDS)
    assert levels.argmax(axis=1).tolist() == [1, 6]
    louder = band_levels(signal.with_samples(10 * signal.samples)).reshape(2, BANDS)
    assert louder.max(axis=1) - levels.max(axis=1) == pytest.approx([20, 20])
    assert np.isfinite(band_levels(signal.with_samples(0 * signal.samples))).all()
    assert np.isfinite(band_levels(signal.cut(0, 20))).all()


def test_what_the_network_does_not_tell_apart_is_refused_by_its_spectrum():
    class Blind:
        def embed(self, signal):
            return np.array([1.0, 0.0], np.float32)

    def noise(name, count, colour):
        for number in range(count):
            white = np.random.default_rng([number, *name.encode()]).standard_normal(4001)
            samples = white[1:] + colour * white[:-1]
            yield Example(f"{name}-{number}", Signal(samples[None], 1000.0, "m/s^2"), name)

    index = build_index(
        Blind(), [*noise("cork", 20, 0.5), *noise("tile", 20, 0.4)], [*noise("wood", 9, 0.45)]
    )
    refused = [index.novelty(surface_vector(Blind(), e.signal)) > 1 for e in noise("felt", 20, -0.5)]
    kept = [index.novelty(surface_vector(Blind(), e.signal)) <= 1 for e in noise("glass", 20, 0.45)]
    assert np.mean(refused) == 1
    assert np.mean(kept) > 0.8


@pytest.mark.parametrize(("told_apart", "weight"), [(True, 1.0), (False, 10.0)])
def test_levels_count_more_where_known_surfaces_are_then_found_more_often(monkeypatch, told_apart, weight):
    random = np.random.default_rng(5)
    of = {"cork": 0.0, "tile": 1.0}

    class Embedder:
        def embed(self, signal):
            return signal.samples[0, :-1].astype(np.float32)

    def strokes(count):
        for name, place in of.items():
            for number in range(count):
                embedded = random.standard_normal(20) + told_apart * 40 * (place - 0.5)
                samples = np.array([[*embedded, place + 0.2 * random.standard_normal()]])
                yield Example(f"{name}-{number}", Signal(samples, 100.0, "1"), name)

    monkeypatch.setattr(surface_index, "band_levels", lambda s: np.full(BANDS, s.samples[0, -1]))
    known = list(strokes(10))
    index = build_index(Embedder(), known, list(strokes(50)))
    vectors, names = surface_vectors(Embedder(), known), [e.material for e in known]
    expected = whitening_of(vectors, names, levels=BANDS, weight=weight)
    np.testing.assert_array_equal(index.whitening, expected)


@pytest.mark.parametrize("count", [3, 12, 40])
def test_the_limit_keeps_new_distances_however_few_set_it(count):
    random = np.random.default_rng(count)
    drawn = np.exp(0.3 * random.standard_normal((4000, count + 1)))
    limits = np.array([prediction_limit(row[:-1]) for row in drawn])
    assert np.mean(drawn[:, -1] <= limits) == pytest.approx(0.95, abs=0.011)  # 3 standard errors


def test_the_limit_is_that_of_a_log_normal_distribution():
    # By hand: logarithms 0, 1, 2; Student's t of 0.95 with 2 degrees of freedom is 2.920.
    assert prediction_limit(np.exp([0.0, 1.0, 2.0])) == pytest.approx(
        np.exp(1 + 2.920 * np.sqrt(4 / 3)), rel=1e-3
    )
    assert prediction_limit([0.7]) == pytest.approx(0.7)
    assert np.isfinite(prediction_limit([0.0, 0.0, 1.0]))


def test_a_loaded_index_measures_as_the_saved_one(run, texture):
    index = SurfaceIndex.load(run)
    facts = run.read_json("search.json", dict)
    assert (facts["kept"], facts["threshold"]) == (0.95, index.threshold)
    found = search(run.folder, texture("tile", 77))
    assert found["threshold"] == index.threshold
    assert [each["distance"] for each in found["nearest"]] == sorted(
        each["distance"] for each in found["nearest"]
    )
