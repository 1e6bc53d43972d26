"""Requested levels."""

import pytest

from tactogram.errors import ParameterError
from tactogram.rendering.level import Level, parse_level


@pytest.mark.parametrize(
    ("text", "level"),
    [
        ("physical", Level("physical")),
        ("sensation", Level("sensation")),
        ("sensation=-3", Level("sensation", -3)),
        (" gain = 2.5 ", Level("gain", 2.5)),
        ("peak=0.8", Level("peak", 0.8)),
    ],
)
def test_a_level_is_read_and_written(text, level):
    assert parse_level(text) == level
    assert parse_level(str(level)) == level


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("loud", "level must be one of physical"),
        ("", "level must be one of physical"),
        ("gain", "write gain=2"),
        ("gain=0", "factor of 1e-12 to"),
        ("gain=x", "needs a number after ="),
        ("gain=", "needs a number after ="),
        ("gain=inf", "finite"),
        ("peak=1.5", "share in 0 to 1"),
        ("physical=2", "use gain=2"),
        ("sensation=nan", "finite"),
    ],
)
def test_a_level_that_is_none_is_refused(text, message):
    with pytest.raises(ParameterError, match=message):
        parse_level(text)
