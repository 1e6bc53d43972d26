"""Rules of the request guard: origins and settings."""

import pytest

from tactogram.errors import ParameterError
from tactogram_studio.server.guard_rules import (
    GuardSettings,
    is_same_origin,
)


@pytest.mark.parametrize(
    ("origin", "host", "own"),
    [
        ("https://lab.example", "lab.example", True),
        ("http://lab.example", "lab.example:80", True),
        ("http://[::1]:81", "[::1]:81", True),
        ("http://lab.example:81", "lab.example", False),
        ("ftp://lab.example", "lab.example", False),
        ("lab.example", "lab.example", False),
        ("", "", False),
    ],
)
def test_an_origin_is_compared_with_its_scheme_s_port(origin, host, own):
    assert is_same_origin(origin, host) is own


@pytest.mark.parametrize(
    ("values", "message"), [({"loopback": False}, "needs a token"), ({"token": "short"}, "at least 16")]
)
def test_settings_that_guard_nothing_are_refused(values, message):
    with pytest.raises(ParameterError, match=message):
        GuardSettings(**values)
