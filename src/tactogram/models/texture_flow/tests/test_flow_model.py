"""Loss, solver and straightening of a flow, on flows known in closed form."""

import numpy as np
import pytest
import torch

from tactogram.models.texture_flow.flow_model import flow_loss, solve, straightening_loss


def test_the_loss_of_the_true_velocity_is_zero():
    data = torch.full((64, 2, 3), 0.8)

    def true(x, time):
        return (data - x) / (1 - time)[:, None, None]

    torch.manual_seed(0)
    assert flow_loss(true, data).item() == pytest.approx(0, abs=1e-6)
    assert flow_loss(lambda x, t: true(x, t) + 0.5, data).item() == pytest.approx(0.25, abs=1e-4)


def test_a_large_element_does_not_outweigh_the_others():
    torch.manual_seed(0)
    data = torch.randn(400, 50)
    large = torch.cat((data[:200], 30 * data[200:]))
    losses = [flow_loss(lambda x, time: torch.zeros_like(x), x).item() for x in (data, large)]
    assert losses[0] == pytest.approx(1.9, abs=0.1)
    assert losses[1] == pytest.approx(1.45, abs=0.1)  # half of it 1, not 900


def test_the_solver_is_of_second_order():
    """dx/dt = cos(3 t) x has the solution exp(sin(3 t) / 3)."""
    start = torch.ones(1, 1, dtype=torch.float64)
    errors = [
        abs(
            solve(lambda x, time: torch.cos(3 * time)[:, None] * x, start, steps).item()
            - np.exp(np.sin(3) / 3)
        )
        for steps in (16, 32)
    ]
    assert errors[0] < 0.02
    assert errors[1] < 0.3 * errors[0]


def test_the_solver_evaluates_the_velocity_once_per_step_and_misses_only_its_change_in_the_first():
    """dx/dt = 2 t has the solution t^2, of which Euler's first step, to 1/8, finds nothing."""
    times = []

    def velocity(x, time):
        times.append(time[0].item())
        return 2 * time[:, None] * torch.ones_like(x)

    solution = solve(velocity, torch.zeros(1, 1, dtype=torch.float64), 4)
    assert solution.item() == pytest.approx(1 - 1 / 64)
    assert times == pytest.approx([0, (1 / 4) ** 1.5, (2 / 4) ** 1.5, (3 / 4) ** 1.5])


def test_one_step_is_straight_where_it_ends_with_the_teacher():
    """The teacher flows from every noise to four times its value, dx/dt = 3 x / (1 + 3 t), which bends no path."""
    torch.manual_seed(0)
    noise = 0.1 * torch.randn(5, 2, 3)
    slope = torch.tensor(3.0, requires_grad=True)

    def teacher(x, time):
        return slope * x / (1 + 3 * time)[:, None, None]

    def loss(velocity):
        return straightening_loss(velocity, teacher, noise, 6)

    assert loss(lambda x, time: 3 * x).item() == pytest.approx(0, abs=1e-9)
    assert loss(lambda x, time: 3 * x + 0.5 + time[:, None, None]).item() == pytest.approx(0.25, abs=1e-4)
    assert not loss(lambda x, time: 3 * x).requires_grad
