from pathlib import Path

import pytest

from tactogram.errors import Message, ParameterError, Remedy
from tactogram.models import available, find
from tactogram.recipe import parse_changes
from tactogram.workflows import TrainingRequest
from tactogram_studio.kit import in_fields
from tactogram_studio.pages.train.form import (
    PURPOSES,
    SPLITS,
    describe_model,
    purpose_of,
    training_arguments,
    training_options,
)

PLAIN = {
    "model": "stroke_cnn", "data": "data/x", "recipe": "quick", "name": "one", "split": "", "last": 2,
    "by": "recording", "label": "material", "where": "",
}  # fmt: skip
"""Entries of the form."""


def test_a_remedy_names_the_field_of_the_form():
    blocks = Message("too few", Remedy("test on a part of each instead,", "split", "blocks"))
    assert in_fields(blocks, {"split": "Split"}, SPLITS) == (
        "too few; test on a part of each instead, “Split”: last fifth of every recording as test part"
    )


def test_a_form_has_an_equivalent_command_line():
    assert (
        " ".join(training_arguments(PLAIN)) == "train stroke_cnn --data data/x --recipe quick --out runs/one"
    )
    others = {"split": "last", "last": 3, "by": "session", "label": "material+contactor"}
    entries = {**PLAIN, **others, "where": "contactor=pen session=a|b", "set": ["config.steps=5"]}
    more = "--split last=3 --by session --label material+contactor --where contactor=pen --where session=a|b"
    assert training_arguments(entries)[6:-2] == [*more.split(), "--set", "config.steps=5"]
    training = TrainingRequest("stroke_cnn", Path("d"), **training_options(entries))
    assert (training.split, training.where) == ("last=3", {"contactor": "pen", "session": "a|b"})
    assert training.changes == parse_changes(["config.steps=5"])


@pytest.mark.parametrize("name", ["", "../x", "a/b", ".hidden", "-x", "x" * 90])
def test_a_run_needs_a_valid_folder_name(name):
    with pytest.raises(ParameterError, match="Name: must be letters"):
        training_arguments(PLAIN | {"name": name})


def test_every_model_has_a_short_description():
    texts = {name: describe_model(facts) for name, facts in available().items()}
    assert texts["texture_gan"].startswith(
        "Generates signals from material, speed (optional) and force (optional); learns from recordings"
    )
    assert "with photographs" in describe_model(find("pix2pix"))
    assert all(len(text) < 400 for text in texts.values())


def test_every_model_is_for_a_purpose():
    purposes = {name: purpose_of(facts) for name, facts in available().items()}
    assert set(purposes.values()) == set(PURPOSES)
    assert purposes["stroke_cnn"] == "recognition"
    assert purposes["texture_flow"] == purposes["stroke_gan"] == "generate"
    assert purposes["frictgan"] == purposes["nearest_photo"] == "photograph"
    assert purposes["ultrasonic_cgan"] == "words"
    assert purposes["rater"] == "rating"
