import json
from dataclasses import asdict, replace

import numpy as np
import pytest
import scipy.signal
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from tactogram.errors import ParameterError, UnitError
from tactogram.features import Spectrum
from tactogram.signal import Signal


def noise(*shape, seed=0, dtype=torch.float64):
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=dtype)


@settings(deadline=None, max_examples=100)
@given(st.integers(1, 3000), st.sampled_from([(torch.float32, 2e-5), (torch.float64, 1e-12)]))
def test_exact_for_every_length(length, precision):
    dtype, atol = precision
    spectrum = Spectrum(rate=1000, length=length, scaling="linear", ceil_db=20)
    x = noise(2, length, dtype=dtype)
    y = spectrum.decode(spectrum.encode(x), spectrum.angle(x))
    torch.testing.assert_close(y, x, atol=atol, rtol=0)


@settings(deadline=None, max_examples=100)
@given(st.data(), st.integers(1, 400))
def test_stable_whatever_the_phase(data, length):
    first = data.draw(st.integers(0, length // 2))
    spectrum = Spectrum(
        rate=1000,
        length=length,
        first=first,
        bins=data.draw(st.integers(1, length // 2 + 1 - first)),
        scaling=data.draw(st.sampled_from(["db", "linear", "power"])),
        phase=data.draw(st.sampled_from(["random", "minimum", "zero"])),
        ceil_db=20,
    )
    z = spectrum.encode(noise(3, length))
    assert z.shape == (3, spectrum.bins)
    torch.testing.assert_close(spectrum.encode(spectrum.decode(z, seed=7)), z, atol=1e-7, rtol=0)


@pytest.mark.parametrize("length", [1000, 999])
def test_values_are_amplitudes_in_the_unit(length):
    time = torch.arange(length, dtype=torch.float64) / length
    x = 0.5 + 3 * torch.cos(2 * torch.pi * 40 * time + 0.3) + 0.02 * torch.cos(2 * torch.pi * 333 * time)
    spectrum = Spectrum(rate=length, length=length, scaling="linear", low=0, high=10, ceil_db=20)
    z = spectrum.encode(x)
    assert z[[0, 40, 333]].tolist() == pytest.approx([0.5, 3, 0.02])
    assert float(z.sum()) == pytest.approx(3.52)
    assert spectrum.frequencies[333] == pytest.approx(333)


def test_half_the_rate_reads_its_amplitude():
    x = 2.0 * (-1.0) ** torch.arange(64, dtype=torch.float64)
    spectrum = Spectrum(rate=64, length=64, scaling="linear", low=0, high=10, ceil_db=20)
    assert float(spectrum.encode(x)[-1]) == pytest.approx(2)


def test_is_scipy_periodogram():
    x = noise(500)
    spectrum = Spectrum(rate=1000, length=500, scaling="power", low=0)
    _, power = scipy.signal.periodogram(
        x.numpy(), 1000, window="boxcar", detrend=False, scaling="spectrum", return_onesided=True
    )
    power[1:-1] *= 2  # mean square of a sinusoid to its squared amplitude
    np.testing.assert_allclose(spectrum.encode(x).numpy(), power, atol=1e-12)


@pytest.mark.parametrize("gain", [0.01, 1.0, 1000.0])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_level_is_kept(gain, dtype):
    spectrum = Spectrum(rate=1000, length=1000, ceil_db=80, floor_db=-160)
    x = gain * noise(1000, dtype=dtype)
    y = spectrum.decode(spectrum.encode(x))
    assert y.dtype == dtype
    assert float(y.std() / x.std()) == pytest.approx(1, rel=2e-3)


def test_bins_that_are_not_kept_are_silent():
    spectrum = Spectrum(rate=4000, length=4000, first=1, bins=1000)
    x = spectrum.decode(spectrum.encode(noise(4000) + 5))
    amplitude = torch.fft.rfft(x).abs()
    assert float(amplitude[0]) < 1e-9
    assert float(amplitude[1001:].max()) < 1e-9
    assert spectrum.frequencies[[0, -1]].tolist() == [1, 1000]


@pytest.mark.parametrize("length", [256, 255])
def test_minimum_phase_is_that_of_a_minimum_phase_filter(length):
    """An all-pole response is minimum phase: it must come back sample by sample."""
    impulse = np.zeros(length)
    impulse[0] = 1
    response = torch.from_numpy(scipy.signal.lfilter([1, 0.4], [1, -1.2, 0.6], impulse))
    spectrum = Spectrum(rate=1000, length=length, scaling="linear", phase="minimum")
    torch.testing.assert_close(spectrum.decode(spectrum.encode(response)), response, atol=1e-8, rtol=0)


def test_minimum_phase_is_scipys():
    mixed = np.convolve([1.0, -0.5, 0.3], [0.2, 1.0, -0.3, 0.4])
    padded = torch.from_numpy(np.pad(mixed, (0, 1024 - len(mixed))))
    spectrum = Spectrum(rate=1000, length=1024, phase="minimum", scaling="linear")
    y = spectrum.decode(spectrum.encode(padded)).numpy()
    theirs = scipy.signal.minimum_phase(mixed, method="homomorphic", n_fft=1024, half=False)
    np.testing.assert_allclose(y[: len(theirs)], theirs, atol=1e-6)


def test_random_phase_follows_the_seed():
    spectrum = Spectrum(rate=1000, length=300)
    z = spectrum.encode(noise(2, 300))
    assert torch.equal(spectrum.decode(z, seed=1), spectrum.decode(z, seed=1))
    assert not torch.allclose(spectrum.decode(z, seed=1), spectrum.decode(z, seed=2))


@pytest.mark.parametrize("phase", ["random", "minimum", "zero"])
def test_batch_is_item_by_item(phase):
    spectrum = Spectrum(rate=1000, length=301, phase=phase)
    x = noise(2, 3, 301)
    z = spectrum.encode(x)
    together = spectrum.decode(z)
    for i in range(2):
        for j in range(3):
            torch.testing.assert_close(z[i, j], spectrum.encode(x[i, j]))
            torch.testing.assert_close(together[i, j], spectrum.decode(z[i, j]), atol=1e-12, rtol=0)


def test_encode_and_decode_are_differentiable():
    spectrum = Spectrum(rate=1000, length=21, floor_db=-200, ceil_db=40)
    x = noise(2, 21).requires_grad_()
    assert torch.autograd.gradcheck(spectrum.encode, x)
    z = spectrum.encode(x.detach()).requires_grad_()
    assert torch.autograd.gradcheck(lambda z: spectrum.decode(z, seed=1), z)


def test_fields_in_json_are_enough_to_invert():
    spectrum = Spectrum(rate=1000, length=500, first=3, bins=100, unit="V", phase="minimum", floor_db=-50)
    again = Spectrum(**json.loads(json.dumps(asdict(spectrum))))
    assert again == spectrum
    z = spectrum.encode(noise(500))
    assert torch.equal(again.decode(z), spectrum.decode(z))


def test_signal_there_and_back():
    spectrum = Spectrum(rate=1000, length=600, unit="V", scaling="linear", ceil_db=30)
    signal = Signal(noise(3, 600).numpy(), 1000, "V")
    z = spectrum.encode_signal(signal)
    phase = spectrum.angle(torch.tensor(signal.samples))
    again = spectrum.decode_signal(z, phase, axes=signal.axes)
    np.testing.assert_allclose(again.samples, signal.samples, atol=5e-5)  # 1.6e-6 of the ceiling
    assert (again.rate, again.unit, again.axes) == (1000, "V", ("x", "y", "z"))
    with pytest.raises(UnitError, match="signal must be in V, got N"):
        spectrum.encode_signal(replace(signal, unit="N"))
    with pytest.raises(ParameterError, match=r"x must be \(\.\.\., 600 samples\), got \(3, 599\)"):
        spectrum.encode_signal(signal.cut(0, 599))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"length": 0}, "length must be"),
        ({"first": 51}, r"first must be a whole number in 0\.\.50, got 51"),
        ({"first": 10, "bins": 42}, r"bins must be a whole number in 1\.\.41, got 42"),
        ({"phase": "kept"}, "phase must be"),
        ({"rate": float("nan")}, "rate must be > 0"),
    ],
)
def test_refuses_fields_that_cannot_be(fields, message):
    with pytest.raises(ParameterError, match=message):
        Spectrum(**{"rate": 1000, "length": 100} | fields)


def test_refuses_what_is_no_spectrum():
    spectrum = Spectrum(rate=1000, length=100)
    with pytest.raises(ParameterError, match="51 bins"):
        spectrum.decode(torch.zeros(50))
    with pytest.raises(ParameterError, match="values must be finite"):
        spectrum.decode(torch.full((51,), torch.inf))
    with pytest.raises(ParameterError, match="phase must have the shape of z"):
        spectrum.decode(torch.zeros(2, 51), torch.zeros(51))
    with pytest.raises(ParameterError, match="float32 or float64"):
        spectrum.encode(torch.zeros(100, dtype=torch.int16))
