import pytest

from tactogram.errors import ParameterError
from tactogram.parameters import parameters
from tactogram.workflows import reading_parameters
from tactogram_studio.kit.parameters import value_of
from tactogram_study.workflows.analysis import analyse_study
from tactogram_study.workflows.power import study_power

POWER = {one.name: one for one in parameters(study_power)}
READING = {one.name: one for one in reading_parameters()}


def test_entries_are_read_as_the_verb_declares_them():
    analysis = {one.name: one for one in parameters(analyse_study)}
    assert value_of(POWER["participants"], "10, 20") == (10, 20)
    assert value_of(POWER["effect"], "1.5") == 1.5
    assert value_of(READING["axes"], "x, y") == ("x", "y")
    assert value_of(analysis["columns"], "participant=subject, value = hit") == {
        "participant": "subject",
        "value": "hit",
    }
    assert value_of(analysis["margins"], "which=0.1") == {"which": 0.1}


@pytest.mark.parametrize(
    ("parameter", "entry", "message"),
    [
        (POWER["participants"], "ten", "needs whole numbers separated by commas, got 'ten'"),
        (READING["rate"], "-1", "rate must be greater than 0, got '-1'"),
        (READING["part"], "1.5", "part must be"),
        (POWER["margin"], "wide", "margin must be float, got 'wide'"),
    ],
)
def test_other_entries_are_refused_by_name(parameter, entry, message):
    with pytest.raises(ParameterError, match=message):
        value_of(parameter, entry)
