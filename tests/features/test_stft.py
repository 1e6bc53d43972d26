import numpy as np
import pytest
import scipy.signal
import torch
from hypothesis import given, settings, strategies as st

from tactogram.errors import ParameterError
from tactogram.features import STFT
from tactogram.features.stft import Projection, overlap_add


def noise(*shape, seed=0, dtype=torch.float64):
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=dtype)


@st.composite
def transforms(draw):
    n_fft = draw(st.sampled_from([2, 3, 64, 65, 66, 255, 256, 2048]))
    hop = draw(st.integers(max(1, n_fft // 20), max(1, 3 * n_fft // 4)))
    window = draw(st.sampled_from(["hann", "hamming", ("kaiser", 6.0)]))
    return STFT(n_fft, min(hop, n_fft // 2) if n_fft < 4 else hop, window)


@settings(deadline=None, max_examples=150)
@given(transforms(), st.integers(1, 5000), st.sampled_from([(torch.float32, 1e-5), (torch.float64, 1e-12)]))
def test_exact_for_every_length(transform, length, precision):
    dtype, atol = precision
    x = noise(2, length, dtype=dtype)
    s = transform.forward(x)
    assert s.shape == (2, transform.n_fft // 2 + 1, 1 + -(-length // transform.hop))
    # Rounding in a frame grows by the cover of the worst sample: at hop = 3/4 of a Hann window about 5 times.
    torch.testing.assert_close(
        transform.inverse(s, length), x, atol=atol, rtol=1e-5 if atol == 1e-5 else 1e-12
    )


@pytest.mark.parametrize(("n_fft", "hop"), [(2048, 1024), (256, 192)])
def test_tail_is_not_lost_off_whole_hops(n_fft, hop):
    """The trap of torch.stft and torch.istft: 1e-2 and 2.4 off in float32."""
    x = noise(n_fft * 3 + hop - 1, dtype=torch.float32)
    transform = STFT(n_fft, hop)
    assert (transform.inverse(transform.forward(x), len(x)) - x).abs().max() < 1e-5


def test_is_scipy_on_whole_hops():
    n_fft, hop = 256, 128
    x = noise(hop * 20)
    window = scipy.signal.get_window("hamming", n_fft)
    _, _, theirs = scipy.signal.stft(x.numpy(), window=window, nperseg=n_fft, noverlap=n_fft - hop)
    ours = STFT(n_fft, hop, "hamming").forward(x).numpy()
    np.testing.assert_allclose(ours / window.sum(), theirs, atol=1e-13)


def test_is_the_definition():
    n_fft, hop, length = 9, 4, 23
    x = noise(length).numpy()
    ours = STFT(n_fft, hop, "hamming").forward(torch.from_numpy(x)).numpy()
    window = scipy.signal.get_window("hamming", n_fft)
    padded = np.concatenate([np.zeros(n_fft), x, np.zeros(2 * n_fft)])
    for t in range(1 + 6):
        piece = padded[n_fft + t * hop - n_fft // 2 :][:n_fft] * window
        for m in range(n_fft // 2 + 1):
            expected = np.sum(piece * np.exp(-2j * np.pi * m * np.arange(n_fft) / n_fft))
            assert ours[m, t] == pytest.approx(expected, abs=1e-12)


def test_odd_window_has_as_many_frames_as_an_even_one():
    x = noise(640)
    assert STFT(65, 16).forward(x).shape[-1] == STFT(64, 16).forward(x).shape[-1] == 41


def test_inverse_is_the_least_squares_one():
    transform, length = STFT(16, 4), 37
    s = torch.complex(noise(9, 11, seed=1), noise(9, 11, seed=2))
    pieces = torch.fft.irfft(s.mT, 16)
    columns = torch.eye(length, dtype=torch.float64)
    analysed = torch.fft.irfft(transform.forward(columns).mT, 16).reshape(length, -1).T  # window times piece
    expected = torch.linalg.lstsq(analysed, pieces.reshape(-1, 1)).solution[:, 0]
    torch.testing.assert_close(transform.inverse(s, length), expected, atol=1e-10, rtol=0)


def test_projection_is_inverse_then_forward():
    transform, length = STFT(30, 7), 100
    s = torch.complex(noise(3, 16, 16, seed=1), noise(3, 16, 16, seed=2))
    project = Projection(transform, s.mT.contiguous(), length)
    for _ in range(2):  # a second use must not see the first
        expected = transform.forward(transform.inverse(s, length))
        torch.testing.assert_close(project(s.mT.contiguous()).mT, expected, atol=1e-12, rtol=0)


def test_gradient_flows_both_ways():
    transform = STFT(16, 5)
    x = noise(2, 33).requires_grad_()
    assert torch.autograd.gradcheck(lambda x: torch.view_as_real(transform.forward(x)), x)
    s = torch.view_as_real(transform.forward(x.detach())).requires_grad_()
    assert torch.autograd.gradcheck(lambda s: transform.inverse(torch.view_as_complex(s), 33), s)


def test_overlap_add_sums_pieces():
    pieces = torch.ones(3, 5)
    assert overlap_add(pieces, 2).tolist() == [1, 1, 2, 2, 3, 2, 2, 1, 1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((64, 64, "hann"), "cannot be inverted"),
        ((256, 250, "hann"), "cannot be inverted"),
        ((64, 65), r"hop must be a whole number in 1\.\.64, got 65"),
        ((64, 0), "hop must be"),
        ((1, 1), "n_fft must be"),
        ((64, 16, "nonsense"), "window must be one that scipy knows, got 'nonsense'"),
    ],
)
def test_refuses_a_transform_that_has_no_inverse(arguments, message):
    with pytest.raises(ParameterError, match=message):
        STFT(*arguments)


def test_refuses_spectrograms_of_another_transform():
    transform = STFT(64, 16)
    with pytest.raises(ParameterError, match="at least one sample"):
        transform.forward(torch.zeros(2, 0))
    with pytest.raises(ParameterError, match=r"float32 or float64, got torch\.int64"):
        transform.forward(torch.zeros(10, dtype=torch.int64))
    with pytest.raises(ParameterError, match="100 samples are 8 frames, got 9"):
        transform.inverse(torch.zeros(33, 9, dtype=torch.complex64), 100)
    with pytest.raises(ParameterError, match="33 bins"):
        transform.inverse(torch.zeros(32, 8, dtype=torch.complex64), 100)
