"""Choices of columns: to a mapping and back."""

from dataclasses import replace

import numpy as np
import pytest
from laboratory_files import lab, labelled

from tactogram.datasets.preview import preview_dataset
from tactogram.errors import ParameterError
from tactogram.signal.io import read_file
from tactogram.signal.io.content import TableLayout
from tactogram_studio.workspace.imports import ColumnChoices, by_key, timing_text

HEADINGS = ("t", "a", "b", "c", "note")


def choices(roles, units=("", "", "", "", ""), **more):
    return ColumnChoices(HEADINGS, tuple(roles), tuple(units), **more)


def test_a_column_of_labels_is_a_choice(tmp_path):
    labelled(tmp_path / "lab/all.csv")
    [facts] = preview_dataset("folder", tmp_path / "lab", workers=1)["layouts"]
    chosen = ColumnChoices.of(facts["columns"], [])
    assert chosen.roles == ("time", "x", "material")
    [layout] = chosen.layouts()
    assert (layout.material, ColumnChoices.of(facts["columns"], [layout]).roles) == ("surface", chosen.roles)
    [without] = chosen.with_role(2, "ignored").layouts()
    assert without.labels == {}
    with pytest.raises(
        ParameterError, match="material must be one column, got x .g., surface; choose another"
    ):
        replace(chosen, roles=("y", "material", "material")).layouts()


def test_choices_are_a_mapping_and_back():
    chosen = choices(["time", "y", "x", "force", "ignored"], ["ms", "g", "g", "mN", ""], rate=100.0)
    axes, force = chosen.layouts()
    assert axes == TableLayout(
        columns=HEADINGS,
        axes={"y": "a", "x": "b"},
        unit="g",
        time="t",
        time_unit="ms",
        rate=100.0,
        stream="acceleration",
    )
    assert (force.axes, force.unit, force.stream, force.rate) == ({"z": "c"}, "mN", "force", 100.0)
    columns = [{"heading": name, "role": "unclear", "unit": None} for name in HEADINGS]
    again = ColumnChoices.of(columns, [axes, force])
    assert (again.roles, again.units, again.layouts()) == (chosen.roles, chosen.units, [axes, force])


@pytest.mark.parametrize(
    ("roles", "says"),
    [
        (
            ["time", "ignored", "ignored", "unclear", "ignored"],
            "choose x, y, z, force or position for at least",
        ),
        (["time", "x", "x", "ignored", "ignored"], "x must be one column, got a, b; choose another"),
        (["time", "x", "time", "ignored", "ignored"], "time must be one column, got t, b; choose another"),
    ],
)
def test_choices_that_contradict_each_other_are_refused(roles, says):
    with pytest.raises(ParameterError, match=says):
        choices(roles).layouts()
    with pytest.raises(ParameterError, match="layout: rate: must be greater"):
        choices(["time", "x", "y", "z", "ignored"], rate=-1.0).layouts()


def test_a_stream_has_one_unit_and_time_another():
    chosen = choices(["time", "x", "y", "force", "ignored"]).with_unit(1, "g")
    assert chosen.units == ("", "g", "g", "", "")
    assert chosen.with_role(3, "z").units == ("", "g", "g", "g", "")
    assert chosen.with_role(1, "time").units == ("", "", "g", "", "")
    three = choices(["ignored", "force", "force", "force", "ignored"]).layouts()
    assert [layout.axes for layout in three] == [{"x": "a", "y": "b", "z": "c"}]


def test_the_unit_of_a_heading_stays_unless_another_is_chosen():
    chosen = ColumnChoices(("t (ms)", "a [g]"), ("ignored", "ignored"), ("", ""))
    assert chosen.with_role(0, "time").with_role(1, "x").units == ("ms", "g")
    assert chosen.with_role(1, "time").with_role(0, "x").units == ("", "")


def test_other_streams_of_a_saved_mapping_stay(tmp_path):
    layouts = [
        TableLayout(columns=HEADINGS, axes={"x": "a"}, time="t", stream="tap"),
        TableLayout(columns=HEADINGS, axes={"tip": "c"}, time="t", unit="N", stream="finger"),
    ]
    columns = [{"heading": name, "role": "ignored", "unit": None} for name in HEADINGS]
    chosen = ColumnChoices.of(columns, layouts)
    assert chosen.roles == ("time", "x", "ignored", "finger: tip", "ignored")
    assert chosen.layouts() == layouts


def test_what_a_preview_read_is_chosen_at_first(tmp_path):
    facts = preview_dataset("folder", lab(tmp_path / "lab"), workers=1)
    table, korks, matrix = facts["layouts"]
    chosen = ColumnChoices.of(table["columns"], [])
    assert (chosen.roles, chosen.units) == (("time", "x", "y", "z"), ("s", "g", "g", "g"))
    assert ColumnChoices.of(korks["columns"], []).roles == ("time", "ignored", "Kraft")
    assert ColumnChoices.of(matrix["columns"], []).roles == ("time", "x", "y", "z")
    assert timing_text(table).startswith("acceleration: x, y, z in m/s^2 · 500 Hz · time stamps: ")
    assert [*by_key([table, table])] == [repr(chosen.headings), table["example"]]
    mapped = read_file(tmp_path / "lab/felt/take_1.csv", layouts=chosen.layouts()).signal
    np.testing.assert_array_equal(mapped.samples, read_file(tmp_path / "lab/felt/take_1.csv").signal.samples)
