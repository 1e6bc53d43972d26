"""Tonal surfaces: tones beside what the network generates, at the speed wanted, in mixes and of a given stroke."""

import numpy as np
import pytest
import torch

from tactogram.model import Example, SignalKind
from tactogram.models.texture_flow import Config, build
from tactogram.models.texture_flow.surfaces import SurfaceSpectra
from tactogram.models.texture_flow.tonal_surfaces import (
    StrokeTones,
    TonalSurface,
    split_signals,
    split_strokes,
)
from tactogram.signal import Signal
from tactogram.signal.tones import Tones, no_tones

RATE = 1000.0
CONFIG = Config(widths=(16, 16), embedding=16, frames=16, batch_size=2, steps=2, iterations=4, solver_steps=1)


def stroke(seed, *, hz=60.0, ribs=1.0, noise=0.2, seconds=3.0, **condition):
    """Ribs under a finger that is not quite steady, in noise."""
    random = np.random.default_rng(seed)
    count = round(seconds * RATE)
    phase = 2 * np.pi * np.cumsum(hz * np.exp(0.04 * np.sin(np.arange(count) / 150 + seed))) / RATE
    x = ribs * np.cos(phase) + noise * random.standard_normal(count)
    return Example(
        f"{hz}-{seed}", Signal(x[None].astype(np.float32), RATE, "m/s^2", ("x",)), "mat", condition
    )


def fitted(examples, **config):
    materials = tuple(sorted({example.material for example in examples}))
    learner = build(CONFIG.model_copy(update=config), SignalKind(RATE, "m/s^2", ("x",), materials), seed=0)
    learner._fit(examples)
    return learner


def line_hz(samples):
    spectrum = np.abs(np.fft.rfft(samples[0] * np.hanning(samples.shape[1])))
    return float(np.argmax(spectrum) * RATE / samples.shape[1])


def test_tones_of_a_material_are_generated_beside_its_noise():
    strokes = [stroke(seed) for seed in range(3)]
    learner = fitted(strokes)
    [patterns] = learner.known.tones
    assert len(patterns) == 3
    assert [each.tones.frequency[0] for each in patterns] == pytest.approx([60] * 3, rel=0.1)
    samples = learner.generate({"material": "mat"}, seconds=8, seed=0).samples
    assert line_hz(samples) == pytest.approx(60, rel=0.15)
    recorded = np.mean([np.var(e.signal.samples) for e in strokes])
    # The untrained network makes noise of about the surface's power.
    assert np.var(samples) == pytest.approx(recorded, rel=0.2)


def test_each_signal_has_the_tones_of_one_stroke():
    """Strokes along and across ribs: a signal has the lines of one of them, and all have the same power."""
    strokes = [stroke(seed, hz=hz, force_n=hz) for seed, hz in enumerate((60.0, 150.0))]
    learner = fitted(strokes)
    signals = [learner.generate({"material": "mat"}, seconds=4, seed=seed).samples for seed in range(12)]
    assert {round(line_hz(x), -1) for x in signals} <= {50, 60, 70, 130, 140, 150, 160, 170}
    assert 0 < sum(line_hz(x) > 100 for x in signals) < 12
    assert [np.var(x) for x in signals] == pytest.approx([0.54] * 12, rel=0.3)


def test_training_is_on_strokes_without_their_tones():
    learner = fitted([stroke(seed) for seed in range(3)])
    [rest, *_] = learner._without_tones([stroke(5)])
    assert rest.signal.samples.std() == pytest.approx(0.2, rel=0.15)
    assert learner.spectra.variance * float(learner.known.surfaces[0].power) == pytest.approx(0.04, rel=0.2)


def test_tones_follow_the_speed_wanted():
    strokes = [
        stroke(seed, hz=0.5 * speed, speed_mm_s=speed)
        for seed, speed in enumerate((100.0, 100.0, 200.0, 200.0))
    ]
    learner = fitted(strokes)
    for speed in (100.0, 150.0, 200.0):
        samples = learner.generate({"material": "mat", "speed_mm_s": speed}, seconds=8, seed=0).samples
        assert line_hz(samples) == pytest.approx(0.5 * speed, rel=0.15)


def test_tones_have_the_ratio_of_the_mean_powers_of_all_strokes():
    strokes = [stroke(0, force_n=0.5), stroke(1, ribs=0.0, noise=1.0, force_n=1.0)]
    [tones], _ = split_strokes(strokes)
    assert tones.tones.power.sum() / tones.noise == pytest.approx(0.5 / (0.2**2 + 1), rel=0.1)


def test_offsets_of_single_strokes_are_not_noise():
    offsets = (-3.0, 0.0, 3.0)
    strokes = [stroke(seed) for seed in range(3)]
    moved = [
        Example(e.id, e.signal.with_samples(e.signal.samples + np.float32(offset)), "mat")
        for e, offset in zip(strokes, offsets, strict=True)
    ]
    learner = fitted(moved)
    assert learner.spectra.variance * float(learner.known.surfaces[0].power) == pytest.approx(0.04, rel=0.2)
    recorded = np.mean([np.var(e.signal.samples) for e in strokes])
    assert np.var(learner.generate({"material": "mat"}, seconds=8, seed=0).samples) == pytest.approx(
        recorded, rel=0.2
    )


def test_a_given_stroke_keeps_its_tones_and_moves_them_from_its_speed_to_the_one_wanted():
    learner = fitted([stroke(seed, hz=90.0, speed_mm_s=v) for seed, v in enumerate((50.0, 200.0))])
    vibration = {"vibration": stroke(9).signal, "vibration_speed_mm_s": 100.0}
    for target, hz in (({}, 60.0), ({"speed_mm_s": 150.0}, 90.0)):
        samples = learner.generate({**vibration, **target}, seconds=8, seed=0).samples
        assert line_hz(samples) == pytest.approx(hz, rel=0.15)


def test_a_mix_has_the_lines_of_both_and_their_mean_power_in_db():
    spectra = SurfaceSpectra(CONFIG, RATE)
    members = []
    for hz, level in ((60.0, 1.0), (150.0, 3.0)):
        [tones], [noise] = split_signals([stroke(0, hz=hz, ribs=level, noise=0.2 * level).signal])
        members.append(TonalSurface(spectra.measure([noise]), tones, spectra.variance))
    mix = TonalSurface.mixed(members, np.array([1.0, 1.0]))
    assert mix.tones.frequency == pytest.approx([60, 150], rel=0.1)
    assert mix.power == pytest.approx(np.sqrt(members[0].power * members[1].power))


def test_a_mix_keeps_its_lines_in_order_as_one_moves_past_the_other():
    spectra, tones = SurfaceSpectra(CONFIG, RATE), []
    noise = spectra.measure([stroke(0, ribs=0.0).signal])
    fixed = Tones(np.array([90.0]), np.ones((2, 1, 1)), np.zeros(5))
    for hz in (60.0, 90.0, 120.0):
        moving = Tones(np.array([hz]), np.ones((2, 1, 1)), np.zeros(5))
        members = [TonalSurface(noise, each, spectra.variance) for each in (moving, fixed)]
        tones.append(TonalSurface.mixed(members, np.array([1.0, 1.0])).tones.frequency.tolist())
    assert tones == [[60.0, 90.0], [90.0, 90.0], [120.0, 90.0]]


def test_speeds_take_turns_among_the_strokes_that_are_kept():
    strokes = [
        stroke(seed, hz=0.5 * speed, ribs=ribs, speed_mm_s=speed)
        for speed, ribs in ((100.0, 1.0), (200.0, 0.8))
        for seed in range(6)
    ]
    kept, _ = split_strokes(strokes)
    assert [each.speed_mm_s for each in kept] == [100.0, 200.0] * 4


def test_a_mix_without_tones_is_that_of_surfaces():
    spectra = SurfaceSpectra(CONFIG, RATE)
    surfaces = [
        spectra.measure([stroke(seed, ribs=0.0, noise=level).signal]) for seed, level in ((0, 1), (1, 3))
    ]
    members = [TonalSurface(surface, no_tones(1), spectra.variance) for surface in surfaces]
    mix = TonalSurface.mixed(members, np.array([0.25, 0.75])).surface
    expected = type(mix).mixed(surfaces, np.array([0.25, 0.75]))
    assert all(torch.equal(a, b) for a, b in zip(mix, expected, strict=True))


def test_friction_over_displacement_has_no_tones():
    signal = Signal(stroke(0).signal.samples, 20.0, "1", ("x",), domain="displacement")
    tones, [rest] = split_signals([signal])
    assert tones == []
    assert rest is signal


def test_state_keeps_tones():
    tones = StrokeTones(Tones(np.array([50.0]), np.ones((2, 1, 1)), np.arange(5.0)), 100.0, 0.5)
    again = StrokeTones.from_state(tones.state())
    assert (again.speed_mm_s, again.noise) == (100.0, 0.5)
    np.testing.assert_array_equal(again.tones.amplitude, tones.tones.amplitude)
    np.testing.assert_array_equal(again.tones.unsteadiness, tones.tones.unsteadiness)
