"""Displays that contradict themselves."""

import pytest

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import display_of, open_display


def test_a_display_without_dc_needs_both_signs():
    with pytest.raises(ParameterError, match="lowest must be below 0 where dc is forbidden"):
        open_display("voice-coil", changes={"lowest": 0.0})


@pytest.mark.parametrize("card_channels", [[3], [3, 3], [0, 1], [1, 2, 3]])
def test_every_channel_has_its_own_channel_of_the_card(card_channels):
    with pytest.raises(ParameterError, match="card_channels"):
        open_display("audio", changes={"card_channels": card_channels})


BASE = {
    "name": "a",
    "title": "a",
    "family": "linear",
    "rate": 1000,
    "channels": ["a"],
    "unit": "V",
    "limit": 1,
}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"colour": 1}, "unknown key 'colour'"),
        ({"linear": {"colour": 1}}, "linear: unknown key 'colour'"),
        ({"family": "magic"}, "family must be one of"),
        ({"limit": -1}, "limit"),
        ({"unit": "A"}, "unit"),
        ({"channels": ["a", "a"]}, "different names"),
        ({"band": [100, 20]}, "low < high"),
        ({"rest": 0.5}, "rest must be 0 where dc is forbidden"),
        ({"rest": 2, "dc": True}, "rest must lie within"),
        ({"settings": {}}, "belong in a table"),
        ({"response": {"kind": "flat", "unit": "m/s^2"}}, "gain"),
    ],
)
def test_a_wrong_display_is_refused_in_one_line(changes, message):
    with pytest.raises(ParameterError, match=message) as caught:
        display_of(BASE | changes, where="x.toml")
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("x.toml")
