import numpy as np
import pytest
import torch
from scipy.signal import butter, get_window, hilbert, sosfilt

from tactogram.errors import ParameterError
from tactogram.features import STFT, recover, spectral_convergence
from tactogram.features.phase import gradient_phase, window_gamma

HANN = STFT(256, 64)


def texture(seconds=2.0, *, rate=2500, seed=0, offset=0.0, dtype=torch.float64):
    """Return simulated texture: noise of 40-400 Hz whose level goes up and down as in strokes."""
    random = np.random.default_rng(seed)
    n = int(seconds * rate)
    x = sosfilt(butter(2, [40, 400], "bandpass", fs=rate, output="sos"), random.standard_normal(n))
    x *= 0.2 + np.abs(np.sin(np.pi * np.arange(n) / rate))
    return torch.from_numpy(x + offset).to(dtype)


def consistency(x, transform=HANN, **how):
    magnitude = transform.forward(x).abs()
    return float(spectral_convergence(recover(magnitude, transform, len(x), **how), magnitude, transform))


def test_spectral_convergence_is_its_formula():
    x, y = texture(0.3), texture(0.3, seed=1)
    a, b = HANN.forward(x).abs(), HANN.forward(y).abs()
    expected = 20 * torch.log10(torch.linalg.norm(b - a) / torch.linalg.norm(a))
    torch.testing.assert_close(spectral_convergence(y, a, HANN), expected)
    assert spectral_convergence(x, a, HANN) < -250


def test_each_method_is_as_good_as_it_is_known_to_be():
    x = texture()
    random = {
        name: consistency(x, start="random", iteration=name, iterations=32)
        for name in ("griffin_lim", "fast_griffin_lim", "admm")
    }
    assert random["griffin_lim"] < -14
    assert random["fast_griffin_lim"] < random["griffin_lim"] - 3
    assert random["admm"] < random["griffin_lim"] - 3
    assert consistency(x, start="gradient", iterations=0) < -12
    assert consistency(x, iterations=32) < random["fast_griffin_lim"] - 3
    assert consistency(x, iterations=32) < consistency(x, start="gradient", iteration="griffin_lim") - 2


def test_griffin_lim_never_gets_worse():
    """Neshov et al. 2026, Sec. 4.1: signals "can be reconstructed … using … the Griffin–Lim algorithm"."""
    x = texture(0.5)
    errors = [consistency(x, start="random", iteration="griffin_lim", iterations=k) for k in range(1, 12)]
    assert (np.diff(errors) < 0).all()


@pytest.mark.parametrize("n_fft", [256, 255])
def test_offset_is_recovered(n_fft):
    """A rectified sensor or a friction coefficient is mostly at 0 Hz, where the phase must not drift."""
    x = texture(offset=4 * float(texture().std()))
    assert consistency(x, STFT(n_fft, 32), iterations=0) < -20
    assert consistency(x, STFT(n_fft, 32), iterations=16) < -30


@pytest.mark.parametrize(
    ("window", "published"), [("hann", 0.25645), ("hamming", 0.29794), ("blackman", 0.17954)]
)
def test_window_gamma_is_the_published_constant(window, published):
    assert window_gamma(window, 1024) / 1024**2 == pytest.approx(published, rel=0.02)


def test_gamma_of_a_gaussian_is_its_own():
    assert window_gamma(("gaussian", 50.0), 1024) == pytest.approx(2 * np.pi * 50**2, rel=1e-3)
    assert get_window(("gaussian", 50.0), 1024).max() == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("n_fft", [256, 255])
def test_gradient_phase_of_a_tone_is_the_tones(n_fft):
    """With a Gaussian window theory is exact: only one global phase is free."""
    transform = STFT(n_fft, 16, ("gaussian", 32.0))
    time = torch.arange(4000, dtype=torch.float64)
    s = transform.forward(torch.cos(2 * torch.pi * 0.11 * time))
    magnitude = s.abs().mT[None, 20:-20]
    phase = gradient_phase(magnitude, transform)[0]
    strong = magnitude[0] > 1e-2 * magnitude.max()
    rest = torch.polar(torch.ones_like(phase), phase - s.angle().mT[20:-20])[strong]
    assert (rest - rest.mean()).abs().max() < 0.05


def test_gradient_phase_of_an_impulse_puts_it_where_it_was():
    transform = STFT(256, 16, ("gaussian", 32.0))
    x = torch.zeros(2000, dtype=torch.float64)
    x[1003] = 1
    magnitude = transform.forward(x).abs()
    y = recover(magnitude, transform, 2000, iterations=0).numpy()
    envelope = np.abs(hilbert(y))  # one global phase is free
    assert envelope.argmax() == 1003
    assert envelope.max() > 0.9
    assert np.abs(y[1003 - 4 : 1003 + 5]).sum() > 0.5 * np.abs(y).sum()


@pytest.mark.parametrize("iteration", ["admm+fast_griffin_lim", "admm", "fast_griffin_lim", "griffin_lim"])
@pytest.mark.parametrize("start", ["gradient", "random"])
def test_batch_is_item_by_item(start, iteration):
    x = torch.stack([texture(0.3, seed=k) * 10.0 ** (-k) for k in range(3)]).reshape(3, 1, -1)
    magnitude = HANN.forward(x).abs()
    how = {"start": start, "iteration": iteration, "iterations": 6, "seed": 3}
    together = recover(magnitude, HANN, 750, **how)
    assert together.shape == (3, 1, 750)
    for k in range(3):
        alone = recover(magnitude[k, 0], HANN, 750, **how)
        torch.testing.assert_close(together[k, 0], alone, atol=1e-9 * 10.0 ** (-k), rtol=0)


def test_same_seed_same_signal():
    magnitude = HANN.forward(texture(0.3)).abs()
    first, again, other = (recover(magnitude, HANN, 750, start="random", seed=k) for k in (1, 1, 2))
    assert torch.equal(first, again)
    assert not torch.allclose(first, other)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("gain", [2.0**-40, 0.01, 1e6])
def test_level_is_kept(dtype, gain):
    magnitude = HANN.forward(texture(0.3, dtype=dtype)).abs()
    x, scaled = recover(magnitude, HANN, 750), recover(gain * magnitude, HANN, 750)
    assert scaled.dtype == dtype
    torch.testing.assert_close(scaled / gain, x, atol=2e-2 * float(x.abs().max()), rtol=0)
    assert float(scaled.std() / x.std()) == pytest.approx(gain, rel=1e-3)


def test_silence_stays_silent():
    assert torch.equal(recover(torch.zeros(2, 129, 8), HANN, 448), torch.zeros(2, 448))


def test_no_gradient_flows():
    magnitude = HANN.forward(texture(0.3)).abs().requires_grad_()
    assert not recover(magnitude, HANN, 750, iterations=1).requires_grad


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"magnitude": -torch.ones(129, 8)}, "finite and >= 0"),
        ({"magnitude": torch.full((129, 8), torch.nan)}, "finite and >= 0"),
        ({"magnitude": torch.ones(129, 8, dtype=torch.float16)}, "float32 or float64"),
        ({"length": 512}, "512 samples are 9 frames, got 8"),
        ({"length": 0}, "length must be >= 1"),
        ({"start": "best"}, "start must be"),
        ({"iteration": "best"}, "iteration must be one of"),
        ({"iterations": -1}, "iterations must be >= 0, got -1"),
    ],
)
def test_refuses_invalid_magnitudes(change, message):
    arguments = {"magnitude": torch.ones(129, 8), "transform": HANN, "length": 448} | change
    with pytest.raises(ParameterError, match=message):
        recover(**arguments)
