import pytest
import torch

from tactogram.nn import gradient_penalty


def test_penalty_of_a_linear_critic_by_hand():
    """The slope of w.x is w everywhere: (|w| - 1)^2, here (5 - 1)^2."""
    w = torch.tensor([3.0, 4.0])
    found = gradient_penalty(lambda x: x @ w, torch.randn(7, 2), torch.randn(7, 2))
    assert found.item() == pytest.approx(16.0, rel=1e-5)


def test_the_penalty_is_evaluated_between_real_and_generated():
    """The slope of x^2 / 2 is x: at a quarter of the way from 0 to 8 it is 2, at three quarters 6."""
    real, made = torch.full((2, 1), 8.0), torch.zeros(2, 1)
    share = torch.tensor([0.25, 0.75])
    found = gradient_penalty(lambda x: x.square() / 2, real, made, share)
    assert found.item() == pytest.approx(((2 - 1) ** 2 + (6 - 1) ** 2) / 2)


def test_the_penalty_has_a_gradient_for_the_critic():
    """d/dw (|w| - 1)^2 = 2 (|w| - 1) w / |w|."""
    w = torch.tensor([3.0, 4.0], requires_grad=True)
    gradient_penalty(lambda x: x @ w, torch.randn(7, 2), torch.randn(7, 2)).backward()
    torch.testing.assert_close(w.grad, 2 * 4 * torch.tensor([0.6, 0.8]))


def test_signals_of_several_axes_have_one_slope():
    w = torch.full((2, 3), 1.0)
    found = gradient_penalty(lambda x: (x * w).sum((1, 2)), torch.randn(4, 2, 3), torch.randn(4, 2, 3))
    assert found.item() == pytest.approx((6**0.5 - 1) ** 2, rel=1e-5)
