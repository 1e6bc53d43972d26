"""Real signals land at the floor, other materials at the ceiling, copies are caught."""

import json

import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.evaluation.generation.comparison import (
    describe_measures,
)
from tactogram.evaluation.generation.protocol import evaluate_generation
from tactogram.evaluation.measures import signal_measures
from tactogram.signal import Signal

RATE = 500
SURFACES = {
    "cork": (0.9, 0.1, 3.0, 0.0),
    "felt": (0.0, 1.0, 0.0, 0.5),
    "tile": (-0.8, 4.0, 9.0, 1.0),
    "wool": (0.5, 0.4, 25.0, 3.0),
}
"""Pole of the filter, level, rate in Hz at which it swells, and how far the axes go together."""


def texture(name, seed, seconds=4.0, axes=2):
    pole, level, swell, together = SURFACES[name]
    rng = np.random.default_rng([seed, sum(map(ord, name))])
    noise = rng.standard_normal((axes, round(seconds * RATE)))
    noise[-1] += together * noise[0]
    t = np.arange(noise.shape[1]) / RATE
    swelling = 1 + 0.8 * np.sin(2 * np.pi * swell * t + rng.uniform(0, 6))
    x = lfilter([1], [1, -pole], noise) * swelling * rng.lognormal(0, 0.05)
    return Signal(level * x / 3, RATE, "m/s^2", ("x", "z")[:axes])


def drawn(first, count, **options):
    return {name: [texture(name, s, **options) for s in range(first, first + count)] for name in SURFACES}


def shifted(part):
    """Every material in the place of the one before it."""
    names = sorted(part)
    return {name: part[other] for name, other in zip(names, names[1:] + names[:1], strict=True)}


class Told:
    """A classifier that goes by the rms, which tells these surfaces apart."""

    materials = tuple(sorted(SURFACES))

    def probabilities(self, signal):
        levels = {name: rms(texture(name, 999)) for name in self.materials}
        far = np.array([abs(np.log(rms(signal) / levels[name])) for name in self.materials])
        return np.exp(-far) / np.exp(-far).sum()


def rms(signal):
    return float(np.sqrt(np.mean(signal.samples.astype(float) ** 2)))


def embed(signal):
    """Log band powers of half-second windows."""
    windows = signal.samples.reshape(len(signal.axes), -1, RATE // 2)
    power = np.abs(np.fft.rfft(windows, axis=-1))[..., 1:] ** 2
    bands = power.reshape(*power.shape[:2], 5, -1).mean(-1)
    return np.log(bands).transpose(1, 0, 2).reshape(bands.shape[1], -1)


TRAIN, TEST = drawn(0, 6), drawn(100, 3)


@pytest.fixture(scope="module")
def result():
    copies = {name: [s.cut(0) for s in members] for name, members in TRAIN.items()}
    sets = {"model": drawn(200, 6), "other": shifted(drawn(300, 6)), "copies": copies}
    return evaluate_generation(sets, train=TRAIN, test=TEST, embed=embed, classifier=Told())


def test_real_signals_passed_off_as_the_models_land_at_the_floor(result):
    for name in result.values:
        position = result.position(name)
        assert position is not None, name
        assert abs(position) < 0.3, name


def test_another_material_lands_at_the_ceiling(result):
    for name in result.values:
        if name not in ("memorised_share", "training_correlation"):
            assert 0.6 < result.position(name, column="other") < 1.6, name


def test_a_memorised_copy_is_caught_and_nothing_else_is(result):
    overall = result.overall
    assert overall["memorised_share"]["copies"] == 1
    assert overall["training_correlation"]["copies"] == pytest.approx(1, abs=1e-3)
    assert overall["memorised_share"]["floor"] == pytest.approx(1 / 7)  # one new among six unseen
    assert overall["memorised_share"]["model"] < 0.3
    assert overall["training_correlation"]["model"] == pytest.approx(
        overall["training_correlation"]["floor"], abs=0.05
    )


def test_every_measure_is_there_with_all_its_columns(result):
    assert set(result.values) == set(describe_measures())
    assert set(signal_measures()) < set(result.values)
    columns = {"model", "other", "copies", "floor", "ceiling", "nearest_other"}
    for name, rows in result.values.items():
        assert set(rows) == set(SURFACES)
        assert all(set(row) == columns for row in rows.values()), name
    figures = result.as_dict()
    json.dumps(figures, allow_nan=False)
    assert set(figures["measures"]["density"]) == columns
    assert figures["per_material"]["cork"]["recall"] == result.values["recall"]["cork"]
    assert figures["better"]["recall"] == "higher"
    assert figures["better"]["two_sample_accuracy"] == "lower"
    assert figures["pieces"] == {"seconds": 2.0, "count": 6}


def test_where_it_is_worse_is_said(result):
    assert not {"log_spectral_distance_db", "two_sample_accuracy"} & set(result.worse_than("other"))
    gain = result.advantage("log_spectral_distance_db", "other")
    assert gain["better_on"] == gain["materials"] == 4
    assert 0 < gain["low"] < gain["mean"] < gain["high"]
    far = {material for name, material in result.beyond_ceiling("other") if name == "level_difference_db"}
    assert far == {m for m in SURFACES if result.position("level_difference_db", m, "other") > 1}
    low, high = result.interval("two_sample_accuracy")
    # 12 test recordings and 24 of the model's: Wilson's half-width at 0.5 of 36 is 0.155.
    assert (high - low) / 2 == pytest.approx(0.155, abs=0.01)


def test_the_nearest_other_material_lies_between_floor_and_ceiling(result):
    for name, rows in result.values.items():
        for row in rows.values():
            if row["nearest_other"] is not None:
                ends = sorted((row["floor"], row["ceiling"]))
                assert min(ends[0], row["nearest_other"]) <= row["nearest_other"] <= ends[1] + 1e-9, name


def test_threads_and_the_name_of_the_model_change_nothing(result):
    sets = {"model": drawn(200, 6)}
    sets["same"] = sets["model"]
    alone = evaluate_generation(sets, train=TRAIN, test=TEST, embed=embed, classifier=Told(), workers=1)
    for name, rows in alone.values.items():
        for material, row in rows.items():
            assert row["same"] == row["model"] == pytest.approx(result.values[name][material]["model"])


def test_one_material_and_one_recording_have_a_floor_and_no_ceiling():
    train, test = {"cork": TRAIN["cork"]}, {"cork": TEST["cork"][:1]}
    found = evaluate_generation(
        {"model": {"cork": [texture("cork", 5)]}}, train=train, test=test, embed=embed
    )
    row = found.overall["log_spectral_distance_db"]
    assert row["floor"] > 0
    assert row["ceiling"] is None
    assert found.position("log_spectral_distance_db") is None
    assert found.verdict("log_spectral_distance_db") == "undecided"
    assert "trained_on_generated_accuracy" not in found.values
    json.dumps(found.as_dict(), allow_nan=False)


def test_materials_that_are_not_tested_still_are_other_materials():
    test = {"cork": TEST["cork"]}
    train = {**TRAIN, "silk": [texture("felt", 0, seconds=1)]}  # too short for the pieces
    found = evaluate_generation(
        {"model": {"cork": drawn(200, 6)["cork"]}}, train=train, test=test, embed=embed
    )
    everything = evaluate_generation({"model": drawn(200, 6)}, train=TRAIN, test=TEST, embed=embed)
    for name, rows in found.values.items():
        assert rows["cork"] == everything.values[name]["cork"]


def test_one_axis_has_no_coherence_and_short_pieces_say_what_is_left_out():
    one, other, made = (drawn(s, 3, seconds=0.4, axes=1) for s in (0, 10, 20))
    found = evaluate_generation({"model": made}, train=one, test=other)
    assert "coherence_distance" not in found.values
    assert "log_spectral_distance_db" in found.values
    assert "envelope_spectrum_distance_db" not in found.values
    assert any(note.startswith("envelope_spectrum_distance_db left out: ") for note in found.notes)


def test_what_is_missing_or_does_not_fit_is_said():
    some = {"cork": TRAIN["cork"]}
    with pytest.raises(ParameterError, match="sets must hold 'model'"):
        evaluate_generation({"x": some}, train=some, test=some)
    with pytest.raises(ParameterError, match="test must hold a recording"):
        evaluate_generation({"model": some}, train=some, test={})
    with pytest.raises(ParameterError, match="train must hold a signal of cork"):
        evaluate_generation({"model": some}, train={"cork": []}, test=some)
    with pytest.raises(ParameterError, match="model must hold a signal of cork"):
        evaluate_generation({"model": {}}, train=some, test=some)
    with pytest.raises(ParameterError, match="got 2 kinds"):
        evaluate_generation({"model": {"cork": [texture("cork", 0, axes=1)]}}, train=some, test=some)
    with pytest.raises(ParameterError, match="pieces of 2 s are needed, the signals hold 1"):
        evaluate_generation({"model": {"cork": [texture("cork", 0, seconds=2)]}}, train=some, test=some)
