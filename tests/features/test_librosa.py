"""Transforms as librosa computes them; its import compiles for twenty seconds in a new environment."""

import numpy as np
import pytest
import torch

from tactogram.features import STFT
from tactogram.features.spectrogram import AmplitudeSpectrogram

pytestmark = pytest.mark.slow


def noise(length):
    return torch.randn(length, generator=torch.Generator().manual_seed(0), dtype=torch.float64)


@pytest.mark.parametrize(
    ("n_fft", "hop", "window"),
    [(256, 64, "hann"), (512, 128, "hamming"), (2048, 204, "hann"), (65, 16, "hann")],
)
def test_a_transform_is_librosas_on_whole_hops(n_fft, hop, window):
    import librosa

    x = noise(hop * 40)
    ours = STFT(n_fft, hop, window).forward(x).numpy()
    theirs = librosa.stft(
        x.numpy(), n_fft=n_fft, hop_length=hop, window=window, center=True, pad_mode="constant", dtype=complex
    )
    frames = min(ours.shape[1], theirs.shape[1])  # with an odd window librosa drops the last frame
    assert ours.shape[1] == 41
    np.testing.assert_allclose(ours[:, :frames], theirs[:, :frames], atol=1e-11)


def test_published_amplitudes_are_librosas_with_mirrored_ends():
    import librosa

    x = 0.4 + 0.1 * noise(1280)
    expected = librosa.stft(x.numpy(), n_fft=512, hop_length=128, window="hamming", pad_mode="reflect")
    np.testing.assert_allclose(AmplitudeSpectrogram().encode(x), np.abs(expected), atol=1e-10)
