"""Mapping files that are refused."""

import pytest

from tactogram.datasets.mapping import read_mapping
from tactogram.errors import ParameterError

LAB = """
[[layout]]
columns = ["ticks", "left", "right"]
time = "ticks"
time_unit = "us"
unit = "g"
stream = "tap"
axes.x = "right"
axes.y = "left"
"""


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"us"', '"fortnights"', "layout.0: time_unit must be s, ms, us or ns, got 'fortnights'"),
        ('time = "ticks"', 'time = "tick"', "time must be one of the columns ticks, left, right, got 'tick'"),
        ('"right"\n', '"left"\n', "a column must be used once, got left, left, ticks"),
        ('"g"', '"furlong"', "unit must be one of m/s.2, .* got 'furlong'"),
        ("stream", "streem", "unknown key 'layout.0.streem'; known here: axes, columns, material"),
        ('unit = "g"', "rate = -4", "layout.0.rate: must be greater than .* got -4"),
        ("[[layout]]", "[layout]", "layout: must be a list"),
        (LAB, LAB + LAB, "two layouts have the columns ticks, left, right; keep one of them, or name"),
    ],
)
def test_a_wrong_mapping_is_refused_in_one_line(tmp_path, old, new, says):
    (tmp_path / "m.toml").write_text(LAB.replace(old, new))
    with pytest.raises(ParameterError, match=says):
        read_mapping(tmp_path / "m.toml")
