"""Fields of numbers, and the settings of tabs."""

import json

import pytest

from tactogram.errors import ParameterError
from tactogram_studio.kit import TabSettings, in_range
from tactogram_studio.kit.fields import MOST_TABS


def test_a_tab_keeps_its_settings_and_the_next_one_begins_with_the_last():
    stored = {"display": "audio", "listed": ["a"]}
    one, other = (TabSettings(stored, shared=("listed",)) for _ in range(2))
    one["display"] = "phone"
    one["listed"] = ["b", *one["listed"]]
    one["level"] = "peak"

    assert (other["display"], other.get("level")) == ("audio", None)
    assert other["listed"] == ["b", "a"]
    assert TabSettings(stored)["display"] == "phone"
    del one["level"]
    assert "level" not in stored


def test_a_reload_finds_the_settings_of_its_tab_by_their_key():
    stored = {"display": "audio", "past": [1]}
    one = TabSettings(stored, "")
    one["display"] = "phone"
    TabSettings(stored, "")["display"] = "voice-coil"
    stored = json.loads(json.dumps(stored))  # a restart

    assert dict(TabSettings(stored, one.key)) == {"display": "phone", "past": [1]}
    assert TabSettings(stored, "")["display"] == "voice-coil"
    for _ in range(MOST_TABS):
        TabSettings(stored, "")
    assert len(stored["tabs"]) == MOST_TABS
    assert TabSettings(stored, one.key)["display"] == "voice-coil"  # its own were dropped


@pytest.mark.parametrize(
    ("value", "bounds", "message"),
    [
        (-3.0, {"least": 0.1}, "Seconds must be at least 0.1, got -3"),
        (12.0, {"least": 0, "most": 9}, "Seconds must be 0 to 9, got 12"),
        (2.5, {"whole": True}, "Seconds must be a whole number, got 2.5"),
        (float("nan"), {"least": 0}, "Seconds must be at least 0, got nan"),
    ],
)
def test_a_number_out_of_range_is_refused_and_not_altered(value, bounds, message):
    with pytest.raises(ParameterError, match=f"^{message}$"):
        in_range("Seconds", value, **bounds)
    assert in_range("Seconds", 1.0, **bounds) == 1.0
    assert in_range("Seconds", None, **bounds) is None
