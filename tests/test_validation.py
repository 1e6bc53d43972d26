import pytest

from tactogram.errors import ParameterError
from tactogram.validation import with_changes


def test_values_by_dotted_key_take_the_place_of_the_files():
    values = {"rate": 1, "linear": {"cap_db": 3, "over": "clip"}}
    changed = with_changes(values, {"linear.cap_db": 10, "rate": 2, "a.b.c": True})
    assert changed == {"rate": 2, "linear": {"cap_db": 10, "over": "clip"}, "a": {"b": {"c": True}}}
    assert values == {"rate": 1, "linear": {"cap_db": 3, "over": "clip"}}
    assert with_changes(values, None) == values


def test_a_key_through_a_value_is_refused():
    with pytest.raises(ParameterError, match=r"a\.b\.c: b is a value, not a table"):
        with_changes({"a": {"b": 1}}, {"a.b.c": 2})
