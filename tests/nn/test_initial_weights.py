import pytest
import torch

from tactogram.nn import MovingAverage


def constant(value):
    network = torch.nn.Linear(1, 1, bias=False)
    torch.nn.init.constant_(network.weight, value)
    return network


def test_average_by_hand():
    network = constant(0.0)
    average = MovingAverage(network, 0.5)
    expected = 0.0
    for update, value in enumerate((1.0, 1.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0), start=1):
        torch.nn.init.constant_(network.weight, value)
        average.update(network)
        decay = min(0.5, (1 + update) / (10 + update))
        expected = decay * expected + (1 - decay) * value
    assert decay == 0.5
    assert average.network.weight.item() == pytest.approx(expected)


def test_state_is_restored():
    one, other = MovingAverage(constant(1.0), 0.9), MovingAverage(constant(7.0), 0.9)
    one.update(constant(2.0))
    other.load_state(one.state())
    for average in (one, other):
        average.update(constant(3.0))
    torch.testing.assert_close(other.network.weight, one.network.weight)
    assert other.updates == 2
