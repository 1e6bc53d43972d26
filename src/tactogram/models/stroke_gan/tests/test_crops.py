import numpy as np
import pytest
import torch

from tactogram.model import Example
from tactogram.models.stroke_gan.config import Config
from tactogram.models.stroke_gan.crops import Crops
from tactogram.models.stroke_gan.texture_statistics import energy_distance, statistics
from tactogram.signal import Signal
from tactogram.signal.joining import repeat, seam_excess_db

LENGTH = 1024
PAPER = Config(channels=(1, 1, 1), repetition="repeat")
BETTER = Config(channels=(1, 1, 1), repetition="crossfade")


def noise(length, seed=0):
    x = np.cumsum(np.random.default_rng(seed).standard_normal((2, length)), axis=1)
    return Signal(x - np.linspace(x[:, 0], x[:, -1], length).T, 1000.0, "m/s^2", ("x", "y"))


def crops(config, *signals, lead=0):
    return Crops([Example(str(i), s, "a") for i, s in enumerate(signals)], config, lead)


def test_a_long_recording_is_cropped_anywhere():
    signal = Signal(np.arange(2000.0), 10.0, "1")
    found = [crops(PAPER, signal, lead=7).cut(signal, np.random.default_rng(i)) for i in range(200)]
    assert all(x.shape == (1, LENGTH + 7) for x in found)
    assert all((np.diff(x) == 1).all() for x in found)
    starts = [x[0, 0] for x in found]
    assert 0 <= min(starts) < 30
    assert 2000 - LENGTH - 7 - 30 < max(starts) <= 2000 - LENGTH - 7


def test_a_short_recording_is_repeated_ten_times_as_published():
    """Sec. III-B: repeated ten times, and the network's length cut from that at random."""
    signal = noise(250)
    whole = repeat(signal, 10).samples
    for seed in range(20):
        x = crops(PAPER, signal).cut(signal, np.random.default_rng(seed))
        start = int(np.random.default_rng(seed).integers(2500 - LENGTH + 1))
        np.testing.assert_array_equal(x, whole[:, start : start + LENGTH])


def test_more_often_where_ten_do_not_reach():
    signal = noise(50)
    assert crops(PAPER, signal).cut(signal, np.random.default_rng(0)).shape == (2, LENGTH)


def test_repetition_jumps_at_its_seams_and_crossfades_do_not():
    signal = noise(400).with_samples(noise(400).samples + np.linspace(0, 30, 400))
    repeated = repeat(signal, 10)
    assert seam_excess_db(repeated, range(400, 4000, 400)) > 15
    rng = np.random.default_rng(0)
    worst = [np.abs(np.diff(crops(BETTER, signal).cut(signal, rng))).max() for _ in range(20)]
    jump = np.abs(np.diff(repeated.samples)).max()
    assert max(worst) < jump / 3


def test_a_crossfaded_recording_is_the_recording_elsewhere():
    signal = noise(900)
    x = crops(BETTER, signal).cut(signal, np.random.default_rng(3))
    assert x.shape == (2, LENGTH)
    place = int(np.flatnonzero((signal.samples == x[:, :1]).all(0))[0])
    np.testing.assert_array_equal(x[:, :128], signal.samples[:, place : place + 128])


def test_crops_depend_on_seed_and_number_alone():
    data = crops(PAPER, noise(300), noise(1500), noise(4000))
    assert data.epoch([300, 1500, 4000]).tolist() == [0, 1, 2, 2, 2]
    all_of_them = data.draw(0, 12, seed=4)
    for start, count in ((0, 5), (5, 7), (11, 1)):
        part = data.draw(start, count, seed=4)
        for (one, x), (other, y) in zip(all_of_them[start : start + count], part, strict=True):
            assert one.id == other.id
            np.testing.assert_array_equal(x, y)
    assert sorted(e.id for e, _ in all_of_them[:5]) == ["0", "1", "2", "2", "2"]


# -- texture statistics ---------------------------------------------------------------------------------------


def bursts(count, depth, seed, rate=40):
    random = np.random.default_rng(seed)
    phase = random.uniform(0, 2 * np.pi, (count, 1, 1))
    gain = 1 + depth * np.sin(2 * np.pi * rate * np.arange(2048) / 2048 + phase)
    return torch.from_numpy((gain * random.standard_normal((count, 2, 2048))).astype(np.float32))


def test_statistics_do_not_see_phase_but_fluctuation():
    even, again, rough = (statistics(bursts(64, d, s)) for d, s in ((0.0, 0), (0.0, 1), (0.9, 2)))
    spread = even.std(0)
    assert (((even.mean(0) - again.mean(0)) / spread).abs() < 0.8).all()
    assert ((even.mean(0) - rough.mean(0)) / spread).abs().max() > 3


def test_energy_distance_is_least_for_the_same_process():
    """Gneiting & Raftery 2007: a proper score. The part that depends on the real ones alone is left out."""
    real = statistics(bursts(256, 0.5, 0))
    scores = {
        depth: energy_distance(real, statistics(bursts(256, depth, 1)), statistics(bursts(256, depth, 2)))
        for depth in (0.0, 0.3, 0.5, 0.7, 0.95)
    }
    assert min(scores, key=scores.__getitem__) == 0.5


def test_energy_distance_by_hand():
    real, made, again = (torch.tensor([[a, b]]) for a, b in ((0.0, 0.0), (3.0, 4.0), (0.0, 1.0)))
    expected = (5 + 1 - np.hypot(3, 3)) / np.sqrt(2)
    assert energy_distance(real, made, again).item() == pytest.approx(expected)


def test_statistics_have_slopes_everywhere():
    x = bursts(4, 0.5, 0).requires_grad_()
    statistics(x).square().sum().backward()
    assert torch.isfinite(x.grad).all()
    silent = torch.zeros(1, 1, 1024, requires_grad=True)
    statistics(silent).sum().backward()
    assert torch.isfinite(silent.grad).all()
