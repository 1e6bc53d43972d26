import json
from dataclasses import asdict, replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings, strategies as st
from scipy.signal import get_window

from tactogram.errors import ParameterError, UnitError
from tactogram.features import Spectrogram, spectral_convergence
from tactogram.features.spectrogram import AmplitudeSpectrogram
from tactogram.signal import Signal


def noise(*shape, seed=0, dtype=torch.float64):
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=dtype)


def tone(length, *, frequency=120.0, rate=1000, amplitude=1.0, dtype=torch.float64):
    time = torch.arange(length, dtype=torch.float64) / rate
    return (amplitude * torch.sin(2 * torch.pi * frequency * time)).to(dtype)


@st.composite
def spectrograms(draw):
    n_fft = draw(st.sampled_from([64, 65, 66, 256, 2048]))
    hop = draw(st.integers(max(1, n_fft // 20), 3 * n_fft // 4))
    return Spectrogram(
        rate=1000,
        n_fft=n_fft,
        hop=hop,
        window=draw(st.sampled_from(["hann", "hamming"])),
    )


@settings(deadline=None, max_examples=100)
@given(spectrograms(), st.integers(1, 5000), st.sampled_from([(torch.float32, 1e-5), (torch.float64, 1e-12)]))
def test_exact(spectrogram, length, precision):
    dtype, atol = precision
    x = noise(2, length, dtype=dtype)
    s = spectrogram.stft(x)
    assert s.shape == (2, spectrogram.n_fft // 2 + 1, spectrogram.frames(length))
    torch.testing.assert_close(spectrogram.istft(s, length), x, atol=atol, rtol=0)


@settings(deadline=None, max_examples=60)
@given(spectrograms(), st.integers(1, 3000), st.integers(0, 3))
def test_encode_and_decode_keep_shape_and_range(spectrogram, length, seed):
    spectrogram = replace(spectrogram, iterations=2)
    x = noise(2, length, seed=seed)
    z = spectrogram.encode(x)
    assert z.shape == (2, spectrogram.n_fft // 2 + 1, spectrogram.frames(length))
    assert float(z.min()) >= -1
    assert float(z.max()) <= 1
    y = spectrogram.decode(z, length)
    assert y.shape == (2, length)
    assert bool(torch.isfinite(y).all())


@pytest.mark.parametrize(("n_fft", "hop"), [(256, 25), (256, 64), (255, 64)])
def test_stable(n_fft, hop):
    spectrogram = Spectrogram(rate=1000, n_fft=n_fft, hop=hop, ceil_db=6)
    z = spectrogram.encode(tone(2048) + 0.1 * noise(2048))
    again = spectrogram.encode(spectrogram.decode(z, 2048))
    assert (again - z).abs().mean() < 0.03


def test_stable_where_levels_are_clipped():
    spectrogram = Spectrogram(rate=1000, floor_db=-30, ceil_db=-10)
    z = spectrogram.encode(0.5 * noise(2000))
    target = spectrogram.magnitude(z)
    assert spectral_convergence(spectrogram.decode(z, 2000), target, spectrogram.transform) < -10


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("gain", [0.001, 0.01, 0.1, 1.0])
def test_level_is_kept(gain, dtype):
    spectrogram = Spectrogram(rate=1000, ceil_db=6, floor_db=-120)
    x = tone(4096, amplitude=gain, dtype=dtype)
    y = spectrogram.decode(spectrogram.encode(x), 4096)
    assert y.dtype == dtype
    assert float(y[512:-512].std() / x[512:-512].std()) == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize(("n_fft", "window"), [(250, "hann"), (256, "hamming"), (125, "hann")])
def test_values_are_amplitudes_of_sinusoids(n_fft, window):
    spectrogram = Spectrogram(rate=1000, n_fft=n_fft, hop=50, window=window)
    m = 30
    s = spectrogram.stft(tone(4000, frequency=m * 1000 / n_fft, amplitude=3.0))
    middle = spectrogram.amplitudes(s)[m, 10:-10]
    torch.testing.assert_close(middle, torch.full_like(middle, 3.0), atol=1e-6, rtol=0)
    s = spectrogram.stft(torch.full((4000,), 2.5, dtype=torch.float64))
    constant = spectrogram.amplitudes(s)[0, 10:-10]
    torch.testing.assert_close(constant, torch.full_like(constant, 2.5), atol=1e-6, rtol=0)


def test_values_are_their_formula():
    amplitude = torch.tensor([0.0, 0.001, 0.1, 1.0, 10.0], dtype=torch.float64)
    db = Spectrogram(rate=1000, floor_db=-40, ceil_db=0)
    assert db.value(amplitude).tolist() == pytest.approx([-1, -1, 0, 1, 1])
    assert db.amplitude(db.value(amplitude)).tolist() == pytest.approx([0, 0, 0.1, 1, 1])


def test_floor_is_silence():
    spectrogram = Spectrogram(rate=1000)
    assert torch.equal(spectrogram.decode(-torch.ones(2, 129, 9), 500), torch.zeros(2, 500))


def test_batch_is_item_by_item():
    spectrogram = Spectrogram(rate=1000, iterations=6)
    x = torch.stack([noise(700, seed=k) for k in range(3)])
    together = spectrogram.encode(x)
    torch.testing.assert_close(together, torch.stack([spectrogram.encode(item) for item in x]))
    alone = torch.stack([spectrogram.decode(z, 700, seed=2) for z in together])
    torch.testing.assert_close(spectrogram.decode(together, 700, seed=2), alone, atol=1e-8, rtol=0)


def test_encode_is_differentiable():
    spectrogram = Spectrogram(rate=1000, n_fft=16, hop=4, floor_db=-200, ceil_db=40)
    x = noise(2, 30).requires_grad_()
    assert torch.autograd.gradcheck(spectrogram.encode, x)
    silence = torch.zeros(30, requires_grad=True)
    spectrogram.encode(silence).sum().backward()
    assert bool(torch.isfinite(silence.grad).all())


def test_fields_in_json_are_enough_to_invert():
    spectrogram = Spectrogram(
        rate=2500, unit="V", n_fft=128, hop=32, window=("kaiser", 8.0), floor_db=-60, iterations=5
    )
    again = Spectrogram(**json.loads(json.dumps(asdict(spectrogram))))
    assert again == spectrogram
    z = spectrogram.encode(noise(999))
    assert torch.equal(again.decode(z, 999, seed=4), spectrogram.decode(z, 999, seed=4))


def test_signal_round_trip():
    spectrogram = Spectrogram(rate=1000, unit="N", ceil_db=6)
    signal = Signal(torch.stack([tone(1000), tone(1000, frequency=55)]).numpy(), 1000, "N", ("x", "y"))
    z = spectrogram.encode_signal(signal)
    assert z.shape == (2, 129, 17)
    assert z.dtype == torch.float32
    again = spectrogram.decode_signal(z, len(signal), axes=signal.axes)
    assert (again.rate, again.unit, again.axes, len(again)) == (1000, "N", ("x", "y"), 1000)
    np.testing.assert_allclose(again.samples[:, 200:800].std(1), 0.5**0.5, rtol=0.02)
    assert len(spectrogram.decode_signal(z[0])) == 1024  # all that 17 frames hold


def test_friction_over_displacement():
    spectrogram = Spectrogram(rate=20, unit="1", domain="displacement", n_fft=512, hop=128, window="hamming")
    friction = Signal(0.4 + 0.1 * noise(1280).numpy(), 20, "1", domain="displacement")
    z = spectrogram.encode_signal(friction)
    assert z.shape == (1, 257, 11)  # FrictGAN's 257 x 11
    assert spectrogram.decode_signal(z, 1280).domain == "displacement"


def test_refuses_another_unit_domain_and_rate():
    spectrogram = Spectrogram(rate=1000)
    with pytest.raises(UnitError, match=r"signal must be in m/s\^2, got V"):
        spectrogram.encode_signal(Signal(np.ones(100), 1000, "V"))
    with pytest.raises(UnitError, match="signal must be over time"):
        spectrogram.encode_signal(Signal(np.ones(100), 1000, "m/s^2", domain="displacement"))
    with pytest.raises(ParameterError, match="signal must have rate 1000, got 999; resample it first"):
        spectrogram.encode_signal(Signal(np.ones(100), 999, "m/s^2"))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"n_fft": 64, "hop": 64}, "cannot be inverted"),
        ({"n_fft": 64, "hop": 80}, "hop must be"),
        ({"rate": 0}, "rate must be > 0"),
        ({"floor_db": 0.0}, "floor_db must be < ceil_db"),
        ({"unit": "g"}, "unit must be one of"),
        ({"iterations": -1}, "iterations must be >= 0"),
        ({"start": "best"}, "start must be"),
        ({"iteration": "best"}, "iteration must be one of"),
        ({"domain": "space"}, "domain must be"),
    ],
)
def test_refuses_invalid_fields(fields, message):
    with pytest.raises(ParameterError, match=message):
        Spectrogram(**{"rate": 1000} | fields)


def test_refuses_invalid_pictures():
    spectrogram = Spectrogram(rate=1000, n_fft=14, hop=4)
    with pytest.raises(ParameterError, match="100 samples are 26 frames, got 9"):
        spectrogram.decode(torch.zeros(8, 9), 100)
    with pytest.raises(ParameterError, match=r"z must be \(\.\.\., 8 bins, frame\), got \(9, 8\)"):
        spectrogram.decode(torch.zeros(9, 8), 100)
    with pytest.raises(ParameterError, match="values must be finite"):
        spectrogram.decode(torch.full((8, 8), torch.nan), 100)
    with pytest.raises(ParameterError, match="float32 or float64"):
        spectrogram.decode(torch.zeros(8, 8, dtype=torch.float16), 100)


@pytest.mark.real_data
def test_a_real_recording_is_recovered_better_than_by_random_griffin_lim(real_data):
    """BioTac vibration is rectified: most of it is an offset, where a drifting phase shows."""
    with np.load(real_data("biotac_slide") / "mat01.npz") as archive:
        x = archive["pac"][: int(archive["lengths"][0])].reshape(-1)
    spectrogram = Spectrogram(rate=2200, unit="1", floor_db=-40, ceil_db=80, iterations=32)
    z = spectrogram.encode(torch.from_numpy(x.astype(np.float32)))
    target = spectrogram.magnitude(z)
    plain = replace(spectrogram, start="random", iteration="fast_griffin_lim")
    ours, theirs = (
        float(spectral_convergence(s.decode(z, x.size), target, s.transform)) for s in (spectrogram, plain)
    )
    assert ours < -25
    assert ours < theirs - 6


PUBLISHED = AmplitudeSpectrogram()
SMALL = AmplitudeSpectrogram(n_fft=64, hop=16, frames=11)
T = torch.arange(1280, dtype=torch.float64)


def test_published_size():
    """Cai et al. 2020, Sec. 4: "the size of 257 × 11 amplitude spectrogram"."""
    assert (PUBLISHED.bins, PUBLISHED.frames, PUBLISHED.length) == (257, 11, 1280)
    assert PUBLISHED.encode(torch.ones(2, 1280)).shape == (2, 257, 11)


def test_amplitudes_are_those_of_frames_with_mirrored_ends():
    """Cai et al. 2020, Sec. 4: "a 512-hamming window and a 128-hop size"."""
    x = 0.4 + 0.1 * torch.randn(1280, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    mirrored = np.pad(x.numpy(), 256, mode="reflect")
    frames = [get_window("hamming", 512) * mirrored[128 * k :][:512] for k in range(11)]
    np.testing.assert_allclose(PUBLISHED.encode(x), np.abs(np.fft.rfft(frames)).T, atol=1e-10)


@settings(max_examples=10, deadline=None)
@given(
    level=st.floats(0.1, 1.5),
    ripple=st.floats(0.0, 0.9),
    cycles=st.floats(0.02, 0.4),
    seed=st.integers(0, 99),
)
def test_a_constant_plus_ripple_is_recovered_with_its_mean(level, ripple, cycles, seed):
    """Cai et al. 2020, Sec. 3.1: the spectrogram "is converted into the wave format by the Griffin-Lin algorithm"."""
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
