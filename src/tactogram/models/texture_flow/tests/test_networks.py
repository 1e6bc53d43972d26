"""The network: its reach, labels that change over columns, and its start."""

import torch

from tactogram.models.texture_flow.networks import VelocityUNet
from tactogram.models.texture_flow.tests.test_signal_learner import SMALL, trained


def test_what_is_far_away_does_not_matter():
    network = trained().flow.average.network
    noise = torch.randn(1, 2, 32, 256, generator=torch.Generator().manual_seed(0))
    changed = noise.clone()
    changed[..., 160:] = 0
    time, label = torch.tensor([0.3]), trained()._label(trained().known.surfaces[0], {}, None)[None]
    with torch.no_grad():
        one, other = network(noise, time, label), network(changed, time, label)
    torch.testing.assert_close(one[..., :96], other[..., :96], atol=1e-5, rtol=1e-4)
    assert not torch.allclose(one[..., 159], other[..., 159], atol=1e-3)


def test_a_label_may_change_over_columns():
    network = trained().flow.average.network
    noise = torch.randn(1, 2, 32, 256, generator=torch.Generator().manual_seed(0))
    one, other = (trained()._label(surface, {}, None) for surface in trained().known.surfaces)
    time = torch.tensor([0.3])
    with torch.no_grad():
        velocities = [network(noise, time, label[None]) for label in (one, other)]
        same = network(noise, time, one.expand(1, 256, -1))
        both = network(noise, time, torch.cat((one.expand(128, -1), other.expand(128, -1)))[None])
    torch.testing.assert_close(same, velocities[0], atol=1e-5, rtol=1e-4)
    torch.testing.assert_close(both[..., :64], velocities[0][..., :64], atol=1e-5, rtol=1e-4)
    torch.testing.assert_close(both[..., 192:], velocities[1][..., 192:], atol=1e-5, rtol=1e-4)
    assert not torch.allclose(velocities[0], velocities[1], atol=1e-2)


def test_an_untrained_network_gives_no_velocity():
    network = VelocityUNet(SMALL, channels=2, labels=3)
    assert not network(torch.randn(2, 2, 32, 16), torch.rand(2), torch.rand(2, 3)).any()
