import numpy as np
import pytest
import torch

from tactogram.models.texture_gan.texture_statistics import energy_distance, statistics


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
    real = statistics(bursts(128, 0.5, 0))
    scores = {
        depth: energy_distance(real, statistics(bursts(128, depth, 1)), statistics(bursts(128, depth, 2)))
        for depth in (0.0, 0.3, 0.5, 0.7, 0.95)
    }
    assert min(scores, key=scores.__getitem__) == 0.5


def test_energy_distance_by_hand():
    real, generated, again = (torch.tensor([[a, b]]) for a, b in ((0.0, 0.0), (3.0, 4.0), (0.0, 1.0)))
    expected = (5 + 1 - np.hypot(3, 3)) / np.sqrt(2)
    assert energy_distance(real, generated, again).item() == pytest.approx(expected)


def test_statistics_have_slopes_everywhere():
    x = bursts(4, 0.5, 0).requires_grad_()
    statistics(x).square().sum().backward()
    assert torch.isfinite(x.grad).all()
    silent = torch.zeros(1, 1, 1024, requires_grad=True)
    statistics(silent).sum().backward()
    assert torch.isfinite(silent.grad).all()
