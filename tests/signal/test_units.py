"""Units as files spell them."""

import pytest

from tactogram.errors import UnitError
from tactogram.signal.units import parse_unit


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("m/s²", ("m/s^2", 1)),
        ("µm", ("m", 1e-6)),
        ("mV", ("V", 1e-3)),
        ("G", ("m/s^2", 9.80665)),
        ("m/(sec^2)", ("m/s^2", 1)),
        (" N ", ("N", 1)),
        ("g/16384", ("m/s^2", 9.80665 / 16384)),
        ("g/0", None),
        ("kg", None),
    ],
)
def test_units_are_spelled_in_many_ways(text, expected):
    if expected is None:
        with pytest.raises(UnitError, match="unit must be one of"):
            parse_unit(text)
    else:
        assert parse_unit(text) == expected
