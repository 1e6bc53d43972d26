"""Parameters of a function: what its signature and docstring say, and what its arguments must be."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Literal

import pytest

from tactogram.errors import ParameterError
from tactogram.parameters import Positive, Share, checked, parameters, summary


def stroke(
    rate: Positive,
    *,
    axis: Literal["x", "y"] = "x",
    share: Share | None = None,
    progress: Callable[[int], None] | None = None,
) -> tuple[float, str, float | None]:
    """Stroke a surface.

    Parameters
    ----------
    rate : float
        Rate,
        Hz.
    axis, share : str or float
        Axis, or share.
    """
    return rate, axis, share


def lift(rate: Positive) -> float:
    """Lift a finger. And more.

    Parameters
    ----------
    rate : float
        As of `stroke`.
    """
    return rate


def test_parameters_are_those_with_a_text_in_the_docstring():
    rate, axis, share = parameters(stroke)
    assert [one.name for one in (rate, axis, share)] == ["rate", "axis", "share"]
    assert (rate.text, rate.positional, rate.default) == ("Rate, Hz.", True, inspect.Parameter.empty)
    assert (axis.text, axis.positional, axis.default) == ("Axis, or share.", False, "x")
    assert (share.annotation, share.default) == ("Share", None)


def test_a_text_may_be_that_of_another_function():
    assert parameters(lift)[0].text == "Rate, Hz."
    assert summary(lift) == "Lift a finger. And more."


def test_arguments_are_converted_and_none_stays_the_default():
    assert checked(stroke)("2.5") == (2.5, "x", None)
    assert checked(stroke)(1, axis="y", share=0.5) == (1.0, "y", 0.5)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rate": 0}, "rate must be greater than 0, got 0"),
        ({"rate": float("nan")}, "rate must be a finite number, got nan"),
        ({"rate": 1, "axis": "z"}, "axis must be 'x' or 'y', got 'z'"),
        ({"rate": 1, "share": 1.5}, "share must be less than or equal to 1, got 1.5"),
        ({"rate": [1]}, "rate must be Positive, got [1]"),
    ],
)
def test_an_argument_of_another_type_or_out_of_bounds_is_refused_by_its_name(arguments, message):
    with pytest.raises(ParameterError) as error:
        checked(stroke)(**arguments)
    assert str(error.value) == message
    assert error.value.parameter == next(name for name in message.split() if name)
    assert error.value.value is arguments[error.value.parameter]
