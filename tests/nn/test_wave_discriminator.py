"""Phase shuffle."""

import pytest
import torch
from torch.autograd import gradcheck, gradgradcheck

from tactogram.errors import ParameterError
from tactogram.nn import PhaseShuffle
from tactogram.nn.wave_discriminator import shift


def row(*values):
    return torch.tensor(values, dtype=torch.float).view(1, 1, 1, -1)


@pytest.mark.parametrize(
    ("by", "expected"),
    [
        (-2, [2, 3, 4, 5, 4, 3]),
        (-1, [1, 2, 3, 4, 5, 4]),
        (0, [0, 1, 2, 3, 4, 5]),
        (1, [1, 0, 1, 2, 3, 4]),
        (2, [2, 1, 0, 1, 2, 3]),
    ],
)
def test_ends_are_reflected(by, expected):
    assert shift(row(0, 1, 2, 3, 4, 5), torch.tensor([by])).flatten().tolist() == expected


def test_it_is_the_padding_and_cutting_of_wavegan():
    """As published: reflection padding on the one side, and a cut to the old length (Donahue et al., Sec. 3.3)."""
    x = torch.randn(1, 2, 3, 9)
    for by in range(-4, 5):
        padded = torch.nn.functional.pad(x, (max(by, 0), max(-by, 0), 0, 0), mode="reflect")
        cut = padded[..., max(-by, 0) : max(-by, 0) + 9]
        torch.testing.assert_close(shift(x, torch.tensor([by])), cut)


def test_all_axes_and_channels_of_an_item_move_alike_and_items_apart():
    ramp = torch.arange(12.0).view(1, 1, 1, 12)
    x = ramp + 100 * torch.arange(3).view(1, 3, 1, 1) + 1000 * torch.arange(4).view(1, 1, 4, 1)
    with torch.random.fork_rng():
        torch.manual_seed(0)
        y = PhaseShuffle(2)(x.expand(200, -1, -1, -1))
    moved = y - x
    assert torch.equal(moved, moved[:, :1, :1].expand_as(moved))
    shifts = -moved[:, 0, 0, 5]
    counts = torch.bincount((shifts + 2).long(), minlength=5)
    assert (counts > 20).all()
    assert counts.sum() == 200


def test_derivatives():
    x = torch.randn(5, 2, 3, 6, dtype=torch.double, requires_grad=True)
    shifts = torch.tensor([-2, -1, 0, 1, 2])
    assert gradcheck(lambda v: shift(v, shifts), x)
    assert gradgradcheck(lambda v: shift(v, shifts), x)


def test_reach_0_shifts_nothing():
    x = torch.randn(2, 1, 1, 4)
    assert PhaseShuffle(0)(x) is x


def test_a_shift_as_long_as_the_signal_is_refused():
    with pytest.raises(ParameterError, match="by up to 4 samples, of 4"):
        shift(row(1, 2, 3, 4), torch.tensor([4]))
