"""Settings of a recipe as fields: their values, widgets and entries."""

import pytest

from tactogram import models
from tactogram.errors import ParameterError
from tactogram.workflows.training.recipe_fields import assignments, parse_text, recipe_fields, text_of


@pytest.fixture(scope="module")
def fields():
    return {field.key: field for field in recipe_fields(models.find("stroke_cnn"), "tiny")}


def test_each_setting_has_its_value_and_that_of_the_paper(fields):
    assert (fields["config.window"].value, fields["config.window"].published) == (32, 200)
    assert (fields["seed"].value, fields["seed"].widget) == (0, "integer")
    assert fields["config.dropout"].widget == "number"
    assert fields["config.filters"].widget == "text"
    assert fields["config.schedule"].widget == "choice"
    assert "one-cycle" in fields["config.schedule"].choices
    assert {key.partition(".")[0] for key in fields} == {"seed", "prepare", "training", "config"}


def test_what_differs_is_assigned_as_on_the_command_line(fields):
    entries = {"seed": 3.0, "config.window": 32.0, "config.filters": "[8, 8]", "config.nothing": 1}
    assert assignments(list(fields.values()), entries) == ["seed=3", "config.filters=[8, 8]"]
    with pytest.raises(ParameterError, match=r"seed must be a whole number, got 0.5"):
        fields["seed"].read(0.5)


@pytest.mark.parametrize("value", [None, 3, [1, 2.5], "text", True])
def test_a_text_field_is_read_as_it_was_written(value):
    assert parse_text(text_of(value)) == value


def test_a_text_that_is_no_toml_is_itself():
    assert parse_text("cork, tile") == "cork, tile"
    assert parse_text("  ") is None
