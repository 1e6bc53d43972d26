import librosa
import numpy as np
import pytest
import torch
from hypothesis import given, settings, strategies as st
from scipy.signal import get_window

from tactogram.errors import ParameterError
from tactogram.features.amplitude_spectrogram import AmplitudeSpectrogram

PUBLISHED = AmplitudeSpectrogram()
SMALL = AmplitudeSpectrogram(n_fft=64, hop=16, frames=11)
T = torch.arange(1280, dtype=torch.float64)


def test_published_size():
    assert (PUBLISHED.bins, PUBLISHED.frames, PUBLISHED.length) == (257, 11, 1280)
    assert PUBLISHED.encode(torch.ones(2, 1280)).shape == (2, 257, 11)


def test_it_is_librosa_with_mirrored_ends():
    x = 0.4 + 0.1 * torch.randn(1280, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    expected = librosa.stft(x.numpy(), n_fft=512, hop_length=128, window="hamming", pad_mode="reflect")
    np.testing.assert_allclose(PUBLISHED.encode(x), np.abs(expected), atol=1e-10)


@settings(max_examples=10, deadline=None)
@given(
    level=st.floats(0.1, 1.5),
    ripple=st.floats(0.0, 0.9),
    cycles=st.floats(0.02, 0.4),
    seed=st.integers(0, 99),
)
def test_a_constant_plus_ripple_is_recovered_with_its_mean(level, ripple, cycles, seed):
    x = level * (1 + ripple * torch.sin(2 * np.pi * cycles * T))
    back = PUBLISHED.decode(PUBLISHED.encode(x), seed=seed)
    assert float(back.mean()) == pytest.approx(float(x.mean()), rel=5e-3)
    assert float(back.std()) == pytest.approx(float(x.std()), rel=0.05, abs=1e-6)
    assert float(back.min()) >= 0


def test_a_constant_is_recovered_exactly():
    x = torch.full((1280,), 0.37, dtype=torch.float64)
    np.testing.assert_allclose(PUBLISHED.decode(PUBLISHED.encode(x)), x, atol=1e-9)


def test_a_slow_change_of_level_is_recovered_in_place():
    slow = 0.5 + 0.2 * torch.sin(2 * np.pi * T / 1280)
    x = slow + 0.02 * torch.sin(2 * np.pi * 0.1 * T)
    back = PUBLISHED.decode(PUBLISHED.encode(x))
    assert float((back - slow).abs().max()) < 0.04
    level = PUBLISHED.encode(x)[0] / get_window("hamming", 512).sum()
    np.testing.assert_allclose(level[2:-2], slow[256:-255:128], atol=0.03)


def test_magnitudes_of_noise_are_recovered():
    noise = torch.randn(3, 1280, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    wanted = PUBLISHED.encode(0.4 + 0.05 * noise)
    made = PUBLISHED.encode(PUBLISHED.decode(wanted))
    ripple = slice(3, None)  # the window spreads the mean over three bins
    error = (made - wanted)[:, ripple].square().sum() / wanted[:, ripple].square().sum()
    assert 10 * np.log10(float(error)) < -12


def test_nothing_is_below_zero_even_of_magnitudes_that_no_signal_has():
    drawn = torch.rand(2, 33, 11, generator=torch.Generator().manual_seed(2))
    assert float(SMALL.decode(drawn).min()) >= 0
    signed = AmplitudeSpectrogram(n_fft=64, hop=16, frames=11, nonnegative=False)
    assert float(signed.decode(drawn).min()) < 0


def test_a_bin_that_vanishes_on_the_way_does_not_spoil_the_signal():
    spectrogram = AmplitudeSpectrogram(n_fft=16, hop=4, frames=5)
    large = torch.full((1, spectrogram.frames, spectrogram.bins), 1e6)
    vanished = torch.zeros(large.shape, dtype=torch.complex64)
    assert torch.isfinite(torch.view_as_real(spectrogram._with_magnitude(vanished, large))).all()


def test_level_is_absolute():
    x = 0.4 + 0.1 * torch.rand(160, generator=torch.Generator().manual_seed(3))
    z = SMALL.encode(x)
    torch.testing.assert_close(SMALL.encode(0.01 * x), 0.01 * z)
    torch.testing.assert_close(SMALL.decode(0.01 * z), 0.01 * SMALL.decode(z), rtol=1e-3, atol=1e-6)


def test_batch_is_item_by_item_and_a_seed_is_a_signal():
    x = torch.rand(3, 160, generator=torch.Generator().manual_seed(4))
    z = SMALL.encode(x)
    together = SMALL.decode(z, seed=5)
    for item, one in zip(together, z, strict=True):
        torch.testing.assert_close(SMALL.decode(one, seed=5), item, rtol=1e-4, atol=1e-5)
    assert not torch.allclose(together, SMALL.decode(z, seed=6), atol=1e-3)


def test_gradients_flow_forward():
    x = torch.rand(160, dtype=torch.float64, requires_grad=True)
    SMALL.encode(x).sum().backward()
    assert torch.isfinite(x.grad).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: AmplitudeSpectrogram(frames=2), "frames must be more than 3"),
        (lambda: AmplitudeSpectrogram(n_fft=65, hop=16), "n_fft must be even"),
        (lambda: AmplitudeSpectrogram(iterations=-1), "iterations must be >= 0"),
        (lambda: SMALL.encode(torch.ones(159)), "160 samples"),
        (lambda: SMALL.encode(torch.ones(160, dtype=torch.int64)), "float32 or float64"),
        (lambda: SMALL.decode(torch.ones(33, 10)), "33 bins, 11 frames"),
        (lambda: SMALL.decode(-torch.ones(33, 11)), ">= 0"),
    ],
)
def test_refused(call, message):
    with pytest.raises(ParameterError, match=message):
        call()
