"""Spectra of surfaces and the way back, and the lowest frequencies."""

import numpy as np
import pytest
import torch
from scipy.signal import butter, csd, sosfiltfilt, welch

from tactogram.models.texture_flow import Config
from tactogram.models.texture_flow.surfaces import Surface, SurfaceSpectra
from tactogram.models.texture_flow.tests.test_signal_learner import EXAMPLES, KIND, RATE, SMALL
from tactogram.signal import Signal

SECONDS = 20


def noise(above_hz: float) -> Signal:
    white = np.random.default_rng(0).standard_normal((1, int(RATE * SECONDS)))
    filtered = sosfiltfilt(butter(4, above_hz, "highpass", fs=RATE, output="sos"), white)
    return Signal(filtered.astype(np.float32), RATE, "m/s^2", ("x",))


def gain_db(spectra: SurfaceSpectra, signal: Signal) -> float:
    """Return the gain at 1.2 bins that a signal has by encoding and decoding."""
    surface = spectra.measure([signal])
    coded = spectra.encode(signal.samples, surface)
    generated = spectra.decode(coded, [surface], len(signal) - spectra.transform.n_fft, seed=0)
    low = 1.2 * RATE / spectra.transform.n_fft
    densities = []
    for samples in (generated, signal.samples):
        hertz, density = welch(samples[0], RATE, nperseg=512)
        densities.append(density[np.abs(hertz - low) < 4].mean())
    return float(10 * np.log10(densities[0] / densities[1]))


def test_the_lowest_frequencies_are_as_strong_as_recorded():
    spectra, signal = SurfaceSpectra(Config(), RATE), noise(8.0)
    without = gain_db(spectra, signal)
    spectra.lowest = spectra.lowest_of([signal])
    assert spectra.lowest > 0.6
    assert abs(gain_db(spectra, signal)) < 1.5 < abs(without)


def test_recordings_with_nothing_below_the_first_bin_get_nothing_there():
    assert SurfaceSpectra(Config(), RATE).lowest_of([noise(30.0)]) == 0


def spectra():
    return SurfaceSpectra(SMALL.model_copy(update={"iterations": 64}), RATE)


def surfaces():
    return [spectra().measure([e.signal for e in EXAMPLES if e.material == name]) for name in KIND.materials]


def coherency(samples):
    a, b = samples - samples.mean(1, keepdims=True)
    cross, own, other = (csd(p, q, RATE, nperseg=128)[1] for p, q in ((a, b), (a, a), (b, b)))
    return cross / np.sqrt(np.abs(own * other))


def test_sources_of_every_surface_are_alike():
    for name, surface in zip(KIND.materials, surfaces(), strict=True):
        values = torch.cat(
            [spectra().encode(e.signal.samples, surface) for e in EXAMPLES if e.material == name], -1
        )
        assert values.shape[:2] == (2, 32)
        torch.testing.assert_close(values.mean(-1), torch.zeros(2, 32), atol=1e-3, rtol=0)
        torch.testing.assert_close(values.std(-1), torch.ones(2, 32), atol=1e-3, rtol=0)


@pytest.mark.parametrize("place", [0, 1])
def test_decoded_spectra_have_the_level_spectrum_coherence_and_mean_of_the_recording(place):
    surface = surfaces()[place]
    samples = next(e for e in EXAMPLES if e.material == KIND.materials[place]).signal.samples
    generated = spectra().decode(spectra().encode(samples, surface), [surface], 2400, seed=0)
    assert generated.shape == (2, 2400)
    assert generated.mean(1) == pytest.approx([0.0, 9.81], abs=0.02)
    assert generated.std(1) == pytest.approx(samples.std(1), rel=0.05)
    ours, theirs = (10 * np.log10(welch(x, RATE, nperseg=128)[1][:, 1:-1]) for x in (generated, samples))
    assert np.abs(ours - theirs).mean() < 1.0
    assert np.abs(coherency(generated) - coherency(samples))[2:-2].mean() < 0.12
    assert np.abs(coherency(samples)).mean() > 0.9


def test_magnitudes_survive_the_way_back():
    model, surface = spectra(), surfaces()[0]
    spectrum = model.encode(EXAMPLES[0].signal.samples, surface)
    generated = model.decode(spectrum, [surface], 2400, seed=0)
    again = model.encode(generated, surface)
    # Frame k is centred on hop k; the signal begins 16.5 hops after the first, and its first window is 2 hops later.
    kept = (spectrum[..., 18 : 18 + again.shape[-1]] + spectrum[..., 19 : 19 + again.shape[-1]]) / 2
    assert np.corrcoef(again.flatten(), kept.flatten())[0, 1] > 0.8


def test_a_mix_lies_between_in_the_logarithm():
    one, other = surfaces()
    half = Surface.mixed([one, other], np.array([3.0, 3.0]))
    assert half.power.log() == pytest.approx((one.power.log() + other.power.log()).item() / 2, abs=1e-4)
    torch.testing.assert_close(half.code, (one.code + other.code) / 2)
    torch.testing.assert_close(
        Surface.mixed([one, other], np.array([0.0, 2.0])).root, other.root, rtol=1e-3, atol=1e-4
    )
    values = torch.randn(2, 32, 48, generator=torch.Generator().manual_seed(0))
    rms = [spectra().decode(values, [surface], 2000, seed=0)[0].std() for surface in (one, half, other)]
    assert rms[0] < 0.5 * rms[1] < 0.25 * rms[2]


def test_surfaces_change_over_the_signal():
    one, other = surfaces()
    frames = spectra().frames(4000, 1)
    values = torch.randn(2, 32, frames, generator=torch.Generator().manual_seed(0))
    generated = spectra().decode(values, [one, one, other, other], 4000, seed=0)
    first, last = (spectra().decode(values, [surface], 4000, seed=0) for surface in (one, other))
    assert generated[0, :1200].std() == pytest.approx(first[0, :1200].std(), rel=0.05)
    assert generated[0, 2800:].std() == pytest.approx(last[0, 2800:].std(), rel=0.05)
    assert 2 * first[0].std() < generated[0, 1800:2200].std() < last[0].std()


def test_the_code_tells_levels_and_how_fast_strength_changes():
    noise = np.random.default_rng(0).standard_normal(30_000)
    slow, fast = (1 + 0.9 * np.sin(2 * np.pi * rate * np.arange(30_000) / RATE) for rate in (0.5, 2.0))
    codes = [
        spectra().measure([Signal(x[None], RATE, "1", ("z",))]).code
        for x in (noise, 10 * noise, slow * noise, fast * noise)
    ]
    bands = len(spectra().bands)
    assert len(codes[0]) == spectra().code_size(1) == 10 * bands
    level, *_, lag_16 = (torch.stack(codes).reshape(4, 10, bands)[:, k] for k in range(10))
    torch.testing.assert_close(level[1] - level[0], torch.full((bands,), np.log(10.0)), rtol=0, atol=1e-3)
    assert lag_16[0].abs().max() < 0.15
    assert lag_16[2].min() > 0.2
    assert lag_16[3].max() < -0.2  # 16 hops of 16 ms are half a period


def test_the_faintest_magnitudes_are_silence():
    generated = spectra().decode(torch.full((2, 32, 50), -20.0), [surfaces()[1]], 500, seed=0)
    assert generated.std(1) == pytest.approx([0, 0], abs=1e-6)


def test_a_recording_of_few_windows_has_a_code():
    """Of 4 to 20 windows: fewer than the longest lag, so that nothing is known of it."""
    for frames in (4, 10, 17, 20):
        signal = EXAMPLES[0].signal.cut(0, spectra().samples(frames))
        code = spectra().measure([signal]).code
        assert code.isfinite().all()
        assert (code[-len(spectra().bands) :] == 0).all() == (frames <= 16)
