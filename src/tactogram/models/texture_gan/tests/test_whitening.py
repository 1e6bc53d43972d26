import numpy as np
import pytest
from scipy.signal import coherence, lfilter, welch

from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind
from tactogram.models.texture_gan.config import Config
from tactogram.models.texture_gan.whitening import REACH, Whitening
from tactogram.signal import Signal

KIND = SignalKind(1000.0, "m/s^2", ("x", "y", "z"), ("cork", "tile"))
GRAVITY = np.array([[0], [0], [9.81]])
CONFIG = Config(channels=(4, 4, 4), order=12)


def surface(material, seed, length=6000):
    """Simulated: z is x through a filter, 5 samples later, and a little of its own; y is by itself."""
    x, y, z = np.random.default_rng(seed).standard_normal((3, length + 500))
    x = lfilter([1], [1, -1.2, 0.7] if material == "cork" else [1, 0.5], x)
    z = np.roll(lfilter([1, 0.5], [1, -0.6], x), 5) + 0.4 * z
    signal = np.array([x, lfilter([1], [1, -0.8], y), z])[:, 500:] * (0.1 if material == "cork" else 2.0)
    return Example(f"{material}{seed}", Signal(signal + GRAVITY, 1000.0, "m/s^2"), material)


@pytest.fixture(scope="module")
def fitted():
    whitening = Whitening(CONFIG, KIND)
    whitening.fit([surface(name, seed) for name in KIND.materials for seed in range(4)])
    return whitening


def noise(whitening, material, length=60_000):
    """What the filters make of white noise."""
    y = np.random.default_rng(0).standard_normal((3, whitening.settle + length)).astype(np.float32)
    return whitening.coloured(y, np.eye(2)[material])


@pytest.mark.parametrize("material", [0, 1])
def test_white_is_white_in_every_axis_and_between_them(fitted, material):
    example = surface(KIND.materials[material], 9)
    white = fitted.whitened(example.signal.samples, material).astype(np.float64)
    assert white.shape == (3, len(example.signal) - fitted.lead)
    assert white.std(1) == pytest.approx([1, 1, 1], rel=0.1)
    spectrum = np.fft.rfft(white)
    for i in range(3):
        for j in range(i + 1):
            r = np.fft.irfft(spectrum[i] * spectrum[j].conj()) / white.shape[1]
            r[0] -= i == j
            assert np.abs(np.concatenate((r[:60], r[-60:]))).max() < 0.09


@pytest.mark.parametrize("material", [0, 1])
def test_coloured_noise_has_spectrum_level_and_coherence_of_the_recordings(fitted, material):
    real, signal = surface(KIND.materials[material], 9, 60_000).signal, noise(fitted, material)
    assert len(signal) == 60_000
    assert signal.samples[2].mean() == pytest.approx(9.81, rel=0.05)
    for axis in range(3):
        _, a = welch(real.samples[axis], nperseg=256)
        _, b = welch(signal.samples[axis], nperseg=256)
        assert np.sqrt(np.mean((10 * np.log10(a[2:-2] / b[2:-2])) ** 2)) < 1.0
    for pair in ((0, 1), (0, 2), (1, 2)):
        _, a = coherence(*(real.samples[i] for i in pair), nperseg=256)
        _, b = coherence(*(signal.samples[i] for i in pair), nperseg=256)
        assert np.abs(a - b).mean() < 0.05
    assert REACH >= 5


def test_between_two_materials_the_level_is_between(fitted):
    levels = [noise(fitted, m).samples[0].std() for m in (0, 1)]
    y = np.random.default_rng(0).standard_normal((3, fitted.settle + 20_000)).astype(np.float32)
    half = fitted.coloured(y, np.array([0.5, 0.5])).samples[0].std()
    assert half == pytest.approx(np.sqrt(levels[0] * levels[1]), rel=0.1)


def test_a_silent_axis_stays_silent():
    random = np.random.default_rng(0)
    data = [
        Example(str(i), Signal(random.standard_normal((3, 2000)) * [[1], [0], [1]], 1000.0, "m/s^2"), name)
        for i, name in enumerate(KIND.materials)
    ]
    whitening = Whitening(CONFIG, KIND)
    whitening.fit(data)
    assert np.isfinite(whitening.whitened(data[0].signal.samples, 0)).all()
    signal = noise(whitening, 0, 500)
    assert np.isfinite(signal.samples).all()


def test_recordings_too_short_for_the_filters_are_refused():
    data = [surface(name, 0, 200) for name in KIND.materials]
    with pytest.raises(ParameterError, match="of cork must have more than 268 samples, got 200 at most"):
        Whitening(CONFIG, KIND).fit(data)
