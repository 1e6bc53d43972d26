"""Synthesis: blocks without seams, the level kept while the model changes."""

import csv

import numpy as np
import pytest
import soundfile
from hypothesis import given, settings, strategies as st
from scipy.signal import lfilter, welch

from tactogram.errors import ParameterError
from tactogram.recipe import Preparation
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.synthesis import Synthesizer, synthesise

RATE = 2000.0


def peak(frequency, radius, power, axes=("z",)):
    """A resonance with a given output power on every axis."""
    angle = 2 * np.pi * frequency / RATE
    polynomial = np.tile([1, -2 * radius * np.cos(angle), radius**2], (len(axes), 1))
    model = AutoregressiveModel.from_coefficients(
        polynomial, np.ones(len(axes)), rate=RATE, unit="m/s^2", axes=axes
    )
    return AutoregressiveModel(model.reflection, np.diag(power / model.gain), RATE, "m/s^2", axes)


LOW, HIGH = peak(60, 0.98, 1.0), peak(400, 0.9, 0.04)


@settings(deadline=None, max_examples=25)
@given(st.lists(st.integers(1, 300), min_size=1, max_size=8), st.integers(0, 2**32))
def test_blocks_are_one_call_bit_for_bit(sizes, seed):
    whole = Synthesizer(LOW, seed=seed).next(sum(sizes)).samples
    voice = Synthesizer(LOW, seed=seed)
    np.testing.assert_array_equal(np.hstack([voice.next(n).samples for n in sizes]), whole)


@settings(deadline=None, max_examples=25)
@given(st.lists(st.integers(1, 60), min_size=1, max_size=8))
def test_blocks_are_one_call_while_the_model_changes(sizes):
    one, many = Synthesizer(LOW, seed=5), Synthesizer(LOW, seed=5)
    one.next(50), many.next(50)
    whole = one.next(sum(sizes), HIGH.of_order(7)).samples
    parts = [many.next(sizes[0], HIGH.of_order(7)), *(many.next(n) for n in sizes[1:])]
    np.testing.assert_array_equal(np.hstack([p.samples for p in parts]), whole)


def test_another_seed_is_another_signal():
    assert not np.array_equal(synthesise(LOW, 1, seed=0).samples, synthesise(LOW, 1, seed=1).samples)


def test_ladder_is_the_all_pole_filter():
    """With white noise in, the ladder's covariances are those of scipy's direct form."""
    made = synthesise(peak(300, 0.8, 1.0), 100, seed=0).samples[0].astype(float)
    noise = np.random.default_rng(1).standard_normal(made.size)
    direct = lfilter([1], peak(300, 0.8, 1.0).coefficients[0], noise * np.sqrt(peak(300, 0.8, 1.0).variance))
    for lag in range(5):
        a, b = (np.mean(x[lag:] * x[: x.size - lag]) for x in (made, direct))
        assert a == pytest.approx(b, abs=0.02)


def test_spectrum_and_level_are_the_models():
    model = peak(200, 0.95, 0.25)
    signal = synthesise(model, 200, seed=0)
    frequencies, density = welch(signal.samples[0], RATE, nperseg=1024)
    chosen = (frequencies > 20) & (frequencies < 900)
    expected = model.power_spectrum(frequencies[chosen])[0]
    assert np.abs(10 * np.log10(density[chosen] / expected)).max() < 1.5
    assert signal.samples.var() == pytest.approx(0.25, rel=0.05)
    assert (signal.unit, signal.axes, signal.rate) == ("m/s^2", ("z",), RATE)


def test_level_is_right_from_the_first_sample():
    first = [Synthesizer(LOW, seed=seed).next(1).samples[0, 0] for seed in range(3000)]
    assert np.var(first) == pytest.approx(1.0, rel=0.1)


def test_level_goes_from_one_model_to_the_other_without_bump():
    """Over 800 voices: at every sample of the change the level lies between the two."""
    rows = []
    for seed in range(800):
        voice = Synthesizer(LOW, seed=seed, glide_s=0.02)
        rows.append(np.hstack([voice.next(10).samples[0], voice.next(60, HIGH).samples[0]]))
    level = 10 * np.log10(np.var(rows, axis=0))
    wanted = np.concatenate([np.zeros(10), np.linspace(0, -13.98, 41)[:-1], np.full(20, -13.98)])
    assert np.abs(level - wanted).max() < 1.0  # 4 standard errors of a variance of 800 are 0.87 dB


def test_change_of_model_is_no_click():
    """At the seam and during the glide no step is larger than the two signals have by themselves."""
    inside, across = [], []
    for seed in range(300):
        voice = Synthesizer(LOW, seed=seed, glide_s=0.01)
        x = np.hstack([voice.next(500).samples[0], voice.next(500, HIGH).samples[0]])
        bend = np.abs(np.diff(x, 2))
        inside += [bend[:490].max(), bend[560:].max()]
        across.append(bend[495:525].max())
    assert np.max(across) <= np.max(inside) * 1.1


def test_changing_to_the_model_in_use_changes_nothing():
    one, other = Synthesizer(LOW, seed=0), Synthesizer(LOW, seed=0)
    np.testing.assert_array_equal(
        np.hstack([one.next(40).samples, one.next(40, LOW).samples]), other.next(80).samples
    )


def test_model_may_change_again_before_it_has_arrived():
    voice = Synthesizer(LOW, seed=0, glide_s=0.1)
    for model in (HIGH, LOW.of_order(9), HIGH, LOW):
        assert np.isfinite(voice.next(7, model).samples).all()
    voice.next(1000)
    assert voice.next(100_000).samples.var() == pytest.approx(1.0, rel=0.1)


def test_axes_go_together_as_in_the_data():
    mixing = np.array([[1, 0.7], [0.7, 1]])
    model = AutoregressiveModel(np.full((2, 1), -0.8), mixing, RATE, "m/s^2", ("x", "y"))
    made = synthesise(model, 60, seed=0)
    assert np.corrcoef(made.samples)[0, 1] == pytest.approx(0.7, abs=0.03)


def test_order_60_is_kept_to_its_own_spectrum():
    """Deep stop bands are where direct forms of high order lose their numbers."""
    rng = np.random.default_rng(0)
    noise = np.fft.irfft(
        np.fft.rfft(rng.standard_normal(40000)) * (np.arange(20001) > 2000) * (np.arange(20001) < 9000)
    )
    model = fit_autoregressive(Signal(noise, RATE, "m/s^2"), order=60)
    again = fit_autoregressive(synthesise(model, 60, seed=1), order=60)
    frequencies = np.linspace(150, 400, 100)
    ratio = again.power_spectrum(frequencies) / model.power_spectrum(frequencies)
    assert np.sqrt(np.mean((10 * np.log10(ratio)) ** 2)) < 0.5


def test_mean_comes_back():
    model = AutoregressiveModel(np.zeros((1, 1)), np.eye(1) * 1e-4, RATE, "1", ("mu",), np.array([0.4]))
    assert synthesise(model, 1, seed=0).samples.mean() == pytest.approx(0.4, abs=0.01)


def test_glide_of_0_s_changes_at_once():
    voice = Synthesizer(LOW, seed=0, glide_s=0)
    voice.next(10)
    assert voice.next(100_000, HIGH).samples.var() == pytest.approx(0.04, rel=0.1)


@pytest.mark.parametrize("seconds", [0, -1, np.nan, np.inf])
def test_length_that_makes_no_sense_is_refused(seconds):
    with pytest.raises(ParameterError, match="seconds must be > 0"):
        synthesise(LOW, seconds, seed=0)


def test_block_of_no_samples_is_refused():
    with pytest.raises(ParameterError, match="samples must be >= 1"):
        Synthesizer(LOW, seed=0).next(0)


def test_model_of_another_kind_is_refused_and_nothing_is_lost():
    voice, same = Synthesizer(LOW, seed=0), Synthesizer(LOW, seed=0)
    with pytest.raises(ParameterError, match="expected 2000 Hz"):
        voice.next(10, peak(60, 0.9, 1.0, axes=("x", "y")))
    np.testing.assert_array_equal(voice.next(10).samples, same.next(10).samples)


@pytest.mark.real_data
def test_synthetic_is_as_near_to_unseen_recordings_as_real_ones(real_data):
    """Log-spectral distance at 20-1000 Hz; the model is fitted to four recordings, judged by four others."""
    folder = real_data("lmt108_sound")
    prepare = Preparation(band=(20, 1000), rate=2500)
    rows = list(csv.DictReader((folder / "index.csv").read_text(encoding="utf-8").splitlines()))
    for material in sorted({row["material"] for row in rows})[::5]:
        files = [folder / row["file"] for row in rows if row["material"] == material]
        sounds = [soundfile.read(file, dtype="float32") for file in files]
        signals = [prepare.apply(Signal(x, rate, "1")) for x, rate in sounds]
        model = fit_autoregressive(signals[:4])
        made = [synthesise(model, signals[0].seconds, seed=seed) for seed in range(4)]

        def levels(signal):
            frequencies, density = welch(signal.samples[0], signal.rate, nperseg=256)
            return 10 * np.log10(density[(frequencies >= 20) & (frequencies <= 1000)])

        def distance(some, others):
            pairs = [levels(a) - levels(b) for a in some for b in others]
            return np.mean([np.sqrt(np.mean(pair**2)) for pair in pairs])

        assert distance(made, signals[4:]) < distance(signals[:4], signals[4:]) + 0.5
