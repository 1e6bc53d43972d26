"""Every promise of `SpectrogramPicture`, at the published size and at a small one."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, strategies as st
from scipy import signal as scipy_signal

from tactogram.errors import ParameterError, UnitError
from tactogram.features.spectrogram_picture import SpectrogramPicture, reconstructed
from tactogram.signal import Signal

PAPER = SpectrogramPicture(rate=10_000.0, floor_db=-100.0, ceiling_db=20.0)
EXACT = replace(PAPER, rows=257)
SMALL = SpectrogramPicture(
    rate=2000.0, floor_db=-100.0, ceiling_db=20.0, n_fft=128, hop=32, frames=64, rows=64, columns=64
)
EXACT_SMALL = replace(SMALL, rows=65)


def noise(length, seed=0):
    return torch.from_numpy(np.random.default_rng(seed).standard_normal(length))


def amplitudes(picture, samples, first=0):
    whole = picture.spectrogram.amplitudes(picture.spectrogram.stft(samples))
    return whole[..., first : first + picture.frames]


def test_a_recording_of_the_paper_has_257_x_376_magnitudes_and_121_crops_of_256_x_256():
    samples = noise(48_000)
    assert PAPER.spectrogram.stft(samples).shape == (257, 376)
    assert PAPER.places(48_000) == 376 - 256 + 1
    assert PAPER.crop(samples, 120).shape == (1, 256, 256)
    assert PAPER.length / PAPER.rate == pytest.approx(3.28, abs=0.02)  # Sec. 4.1


def test_the_window_is_the_papers():
    """Neshov et al. 2026, Sec. 4.1: "a 512-point Hamming window and a hop size of 128"."""
    x = noise(48_000).numpy()
    _, _, s = scipy_signal.stft(
        x, nperseg=512, noverlap=512 - 128, window=scipy_signal.get_window("hamming", 512), boundary="zeros"
    )  # scipy divides by the sum of the window
    ours = amplitudes(PAPER, torch.from_numpy(x), 10)
    np.testing.assert_allclose(ours[1:-1], 2 * np.abs(s[1:-1, 10:266]), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("first", [0, 1, 2, 3, 60, 119, 120])
def test_a_crop_is_that_of_the_whole_spectrogram(first):
    samples = noise(48_000)
    torch.testing.assert_close(
        PAPER.crop(samples, first), PAPER.picture(amplitudes(PAPER, samples, first)), rtol=0, atol=1e-12
    )
    start, stop = PAPER.span(first)
    torch.testing.assert_close(
        PAPER.crop(samples[start:stop], first - start // PAPER.hop), PAPER.crop(samples, first)
    )


def test_encode_is_the_crop_of_samples_of_that_length():
    samples = noise(SMALL.length)
    torch.testing.assert_close(SMALL.encode(samples), SMALL.crop(samples, 0))
    with pytest.raises(ParameterError, match=r"2016 samples are a picture of 64 frames, got 4000 samples"):
        SMALL.encode(noise(4000))


def test_resizing_comes_before_the_logarithm_as_in_the_paper():
    """Neshov et al. 2026, Sec. 4.1: "resized to 256 × 256 and then transformed into the logarithmic scale"."""
    a = amplitudes(PAPER, noise(48_000))
    rows = torch.nn.functional.interpolate(
        a[None, None], (256, 256), mode="bilinear", antialias=True, align_corners=False
    )[0]
    expected = (20 * torch.log10(rows) + 100) / 120 * 2 - 1
    torch.testing.assert_close(PAPER.picture(a), expected)


@pytest.mark.parametrize("picture", [PAPER, EXACT, SMALL])
def test_a_picture_is_recovered_from_its_amplitudes(picture):
    z = picture.crop(noise(48_000, 3), 5)
    error = (picture.picture(picture.decode(z)) - z).abs()
    # A few amplitudes of the least-norm inverse are below 0 and become 0.
    assert error.mean() < 1e-5
    assert error.quantile(0.9999) < 1e-6


@given(st.integers(0, 2**32 - 1))
def test_with_as_many_rows_as_bins_any_picture_is_recovered_exactly(seed):
    exact = replace(EXACT_SMALL, floor_db=-90.0, ceiling_db=10.0)
    values = np.random.default_rng(seed).uniform(-1, 1, exact.shape)
    z = torch.from_numpy(values)
    torch.testing.assert_close(exact.picture(exact.decode(z)), z, rtol=0, atol=1e-12)


def test_bilinear_loses_one_pattern_that_alternates_around_the_middle():
    a = amplitudes(PAPER, noise(48_000)) + 1  # so that no amplitude of the inverse is below 0
    lost = a - PAPER.decode(PAPER.picture(a))
    patterns, weights, _ = torch.linalg.svd(lost, full_matrices=False)
    assert weights[1] < 1e-5 * weights[0]
    pattern = patterns[:, 0]
    assert (pattern[100:157].sign() == -pattern[101:158].sign()).all()
    assert pattern[116:141].square().sum() > 0.95
    # White noise: about 1 in 257 of the energy is along it.
    plain = amplitudes(PAPER, noise(48_000))
    left = plain - PAPER.decode(PAPER.picture(plain))
    assert left.square().sum() / plain.square().sum() < 1 / 257


@pytest.mark.parametrize("picture", [PAPER, EXACT, SMALL])
def test_level_is_kept(picture):
    z = picture.crop(noise(48_000, 1), 0)
    quiet = picture.crop(0.01 * noise(48_000, 1), 0)
    heard = quiet > -1  # where nothing fell below the floor
    assert heard.double().mean() > 0.999
    torch.testing.assert_close((z - quiet)[heard], torch.full_like(z, 40 / 120 * 2)[heard], rtol=0, atol=1e-9)
    back, loud = picture.decode(quiet), picture.decode(z)
    # As much as the few amplitudes below the floor, 1e-5, spread.
    assert (back - 0.01 * loud).abs().max() < 1e-4
    assert (back - 0.01 * loud).norm() < 1e-3 * back.norm()


def test_below_the_floor_is_lost_and_above_the_ceiling_is_the_ceiling():
    a = torch.full((65, 64), 1.0, dtype=torch.float64)
    a[:20], a[40:] = 1e-6, 1e3  # -120 dB and 60 dB
    back = EXACT_SMALL.decode(EXACT_SMALL.picture(a))
    assert not back[:20].any()
    torch.testing.assert_close(back[20:40], a[20:40])
    torch.testing.assert_close(back[40:], torch.full_like(back[40:], 10.0))


def test_a_sinusoid_of_one_unit_reads_0_db():
    t = torch.arange(SMALL.length, dtype=torch.float64) / SMALL.rate
    z = EXACT_SMALL.encode(torch.sin(2 * torch.pi * 500.0 * t))  # bin 32
    assert z[0, 32, 32].item() == pytest.approx((0 + 100) / 120 * 2 - 1, abs=1e-6)


@pytest.mark.parametrize("picture", [EXACT_SMALL, SMALL])
def test_the_signal_has_the_spectrum_and_level_of_the_picture(picture):
    t = torch.arange(picture.length, dtype=torch.float64) / picture.rate
    x = 0.03 * (torch.sin(2 * torch.pi * 203.0 * t) + 0.3 * torch.sin(2 * torch.pi * 611.0 * t))
    y = picture.signal(picture.encode(x), seed=1)
    assert y.shape == x.shape
    f = [20 * np.log10(np.sqrt(scipy_signal.welch(v.numpy(), 2000.0, nperseg=256)[1])) for v in (x, y)]
    loud = f[0] > f[0].max() - 30
    assert np.abs(f[0] - f[1])[loud].max() < 1.5
    assert y.std() == pytest.approx(float(x.std()), rel=0.1)


def test_the_seed_decides_and_a_batch_is_item_by_item():
    z = torch.stack([SMALL.crop(noise(4000, k).float(), 3) for k in range(3)])
    together = SMALL.signal(z, seed=4)
    assert together.shape == (3, SMALL.length)
    for item, alone in zip(together, z, strict=True):
        torch.testing.assert_close(SMALL.signal(alone, seed=4), item, rtol=1e-3, atol=1e-4)
    torch.testing.assert_close(SMALL.decode(z)[1], SMALL.decode(z[1]))


def test_another_size_of_picture_from_the_published_transform():
    coarse = SpectrogramPicture(rate=10_000.0, floor_db=-100.0, ceiling_db=20.0, rows=64, columns=64)
    a = torch.full((257, 256), 0.5, dtype=torch.float64)
    torch.testing.assert_close(coarse.decode(coarse.picture(a)), a)  # detail no finer than a row is recovered
    z = coarse.crop(noise(48_000), 0)
    assert z.shape == (1, 64, 64)
    assert (coarse.picture(coarse.decode(z)) - z).abs().mean() < 1e-4


def test_float32_is_as_good():
    x = noise(48_000)
    torch.testing.assert_close(PAPER.crop(x.float(), 9).double(), PAPER.crop(x, 9), rtol=0, atol=1e-4)
    assert PAPER.decode(PAPER.crop(x.float(), 9)).dtype == torch.float32


def test_gradients_flow():
    x = noise(SMALL.length).requires_grad_()
    SMALL.encode(x).sum().backward()
    assert torch.isfinite(x.grad).all()
    assert x.grad.abs().sum() > 0


def test_bad_input_is_one_line():
    with pytest.raises(ParameterError, match=r"picture of 64 frames is 1.01 s long, the recording 0.5 s"):
        SMALL.crop(noise(1000), 0)
    with pytest.raises(ParameterError, match=r"first frame must be in 0..62, got 63"):
        SMALL.crop(noise(4000), 63)
    with pytest.raises(ParameterError, match=r"must be \(\.\.\., \(1, 64, 64\)\), got \(64, 64\)"):
        SMALL.decode(torch.zeros(64, 64))
    with pytest.raises(ParameterError, match="finite"):
        SMALL.decode(torch.full((1, 64, 64), float("nan")))
    with pytest.raises(ParameterError, match="frames must be a whole number >= 2"):
        SpectrogramPicture(rate=1.0, floor_db=0.0, ceiling_db=1.0, frames=1)
    with pytest.raises(UnitError, match="m/s"):
        SMALL.spectrogram.check_signal(Signal(np.zeros(9), 2000.0, "N"))


def test_noise_of_a_picture_has_the_recordings_spectrum_and_level():
    # Noise of a falling spectrum is recovered as other noise of that spectrum.
    taps = np.array([1.0, 0.6, 0.2])
    samples = torch.from_numpy(np.convolve(noise(40 * SMALL.length).numpy(), taps, "same").copy())
    cut = samples.reshape(40, -1)
    back = torch.stack([SMALL.noise(SMALL.encode(x), smooth=17, seed=seed) for seed, x in enumerate(cut)])
    power = (scipy_signal.welch(x.numpy(), nperseg=64)[1].mean(0)[:-2] for x in (cut, back))
    for one, other in zip(*power, strict=True):
        assert 10 * np.log10(other / one) == pytest.approx(0, abs=0.6)


def test_noise_loses_the_grain_and_preserves_slow_changes():
    x = noise(SMALL.length)
    x[: len(x) // 2] *= 0.01
    picture = SMALL.encode(x)
    back = SMALL.noise(picture, smooth=9, seed=1)
    assert abs(np.corrcoef(x, back)[0, 1]) < 0.2
    quiet, loud = back[: len(x) // 2 - 300].std(), back[len(x) // 2 + 300 :].std()
    assert 20 * torch.log10(loud / quiet).item() == pytest.approx(40, abs=3)
    torch.testing.assert_close(back, SMALL.noise(picture, smooth=9, seed=1), rtol=0, atol=0)
    together = SMALL.noise(torch.stack([picture, picture]), smooth=9, seed=1)
    torch.testing.assert_close(together[1], back)


def test_constant_parts_stay_constant_in_noise():
    x = 9.8 + 0.05 * noise(SMALL.length)
    back = SMALL.noise(SMALL.encode(x), smooth=17, seed=1)
    assert back.mean().item() == pytest.approx(9.8, rel=0.02)
    real, ours = (scipy_signal.welch(y.numpy(), 2000, nperseg=256) for y in (x, back))
    above = real[0] > 60  # beyond what the window lets through of the constant
    assert 10 * np.log10(ours[1][above].mean() / real[1][above].mean()) == pytest.approx(0, abs=2)
    assert back[200:-200].std() < 0.3


def test_noise_without_a_constant_gets_none():
    band = scipy_signal.butter(4, [60, 600], "bandpass", fs=2000, output="sos")
    x = torch.from_numpy(scipy_signal.sosfiltfilt(band, noise(SMALL.length).numpy()).copy())
    back = SMALL.noise(SMALL.encode(x), smooth=17, seed=1)
    assert abs(back.mean()) < 0.02 * back.std()
    assert back.std().item() == pytest.approx(x.std().item(), rel=0.2)


def test_noise_is_smoothed_over_an_odd_number_of_columns():
    with pytest.raises(ParameterError, match="odd number of columns, got 4"):
        SMALL.noise(SMALL.encode(noise(SMALL.length)), smooth=4, seed=0)


@pytest.mark.parametrize("rate", [1000.0, 10_000.0])
def test_a_reconstructed_signal_has_the_length_level_and_spectrum_of_its_recording(rate):
    samples = np.random.default_rng(0).standard_normal((2, round(0.53 * rate))).astype(np.float32)
    samples[1] *= 0.1
    recorded = Signal(samples, rate, "m/s^2", ("x", "z"))
    back = reconstructed(recorded, start="gradient", iteration="griffin_lim", seed=0)
    assert (back.samples.shape, back.axes, back.unit) == (samples.shape, ("x", "z"), "m/s^2")
    level = 20 * np.log10(np.sqrt((back.samples**2).mean(1) / (samples**2).mean(1)))
    assert np.abs(level).max() < 1.5
    assert not np.allclose(back.samples, samples, atol=0.1)
    _, one = scipy_signal.welch(samples, rate, nperseg=128)
    _, other = scipy_signal.welch(back.samples, rate, nperseg=128)
    assert np.abs(10 * np.log10(other / one)[:, 4:-4]).mean() < 2
    silent = recorded.with_samples(0 * samples)
    assert not reconstructed(silent, start="random", iteration="griffin_lim", seed=0).samples.any()
