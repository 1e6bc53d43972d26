import pytest
from pydantic import BaseModel, ConfigDict

from tactogram.errors import ParameterError
from tactogram.validation import faults, validated, with_changes


def test_values_by_dotted_key_take_the_place_of_the_files():
    values = {"rate": 1, "linear": {"cap_db": 3, "over": "clip"}}
    changed = with_changes(values, {"linear.cap_db": 10, "rate": 2, "a.b.c": True})
    assert changed == {"rate": 2, "linear": {"cap_db": 10, "over": "clip"}, "a": {"b": {"c": True}}}
    assert values == {"rate": 1, "linear": {"cap_db": 3, "over": "clip"}}
    assert with_changes(values, None) == values


def test_a_key_through_a_value_is_refused():
    with pytest.raises(ParameterError, match=r"a\.b\.c: b is a value, not a table"):
        with_changes({"a": {"b": 1}}, {"a.b.c": 2})


class Plan(BaseModel):
    model_config = ConfigDict(extra="forbid")
    rate: float = 1


@pytest.mark.parametrize("values", [{"rate": "x" * 5000}, {"rate": ["x\n" * 5000]}, {"y" * 5000: 1}])
def test_a_wrong_value_is_not_repeated_in_full(values):
    with pytest.raises(ParameterError, match="^plan: ") as caught:
        validated(Plan, values, where="plan")
    assert len(str(caught.value)) < 250
    assert "\n" not in str(caught.value)


def test_faults_have_places_and_the_sentences_of_validated():
    values = {"rate": "fast", "colour": 1}
    found = faults(Plan, values, where="plan")
    assert [fault.place for fault in found] == [("rate",), ("colour",)]
    with pytest.raises(ParameterError) as raised:
        validated(Plan, values, where="plan")
    assert found[0].sentence == str(raised.value)
    assert found[1].sentence == "plan: unknown key 'colour'; known here: rate"
    assert faults(Plan, {"rate": 2}, where="plan") == ()


def test_an_unknown_key_is_a_value_with_its_choices():
    with pytest.raises(ParameterError) as refused:
        validated(Plan, {"rat": 2}, where="plan")
    assert (refused.value.value, refused.value.choices) == ("rat", ("rate",))
    with pytest.raises(ParameterError) as refused:
        validated(Plan, {"rate": "fast"}, where="plan")
    assert (refused.value.value, refused.value.choices) == ("fast", ())
