"""Conditions: one declaration, from which options, columns and models' promises follow."""

import sys

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.errors import ParameterError
from tactogram.model import (
    check_condition,
    check_values,
    condition_options,
    condition_types,
    material_weights,
)
from tactogram.models import find
from tactogram.signal.io import read_metadata, read_signal
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.training.train import train

CONDITION = """
from tactogram.model import ConditionOption, ConditionType

CONDITION = ConditionType(
    "temperature_c",
    "temperature of the finger, °C",
    (ConditionOption("temperature", float, "temperature of the finger, °C"),),
    "°C",
)
"""
FACTS = """
title = "A constant of the finger's temperature"
authors = ["Me"]
year = 2026
task = "generation"
gives = "signal"
needs = ["material"]
takes = ["temperature_c"]
"""
CODE = """
import numpy as np

from tactogram.model import Model, ModelConfig, check_condition


class Config(ModelConfig):
    pass


class Warm(Model):
    saved = ("materials",)

    def step(self, stage, batch):
        return {}

    def generate(self, condition, *, seconds=None, seed):
        check_condition(condition, needs=("material",), takes=("temperature_c",))
        return self.kind.signal(np.full((len(self.kind.axes), 100), condition.get("temperature_c", 0.0)))


build = Warm
"""


@pytest.fixture
def warm(store, tmp_path, monkeypatch):
    """Give a run of a model that takes a condition of a file."""
    folder = tmp_path / "models" / "warm"
    (folder / "recipes").mkdir(parents=True)
    (tmp_path / "temperature.py").write_text(CONDITION, encoding="utf-8")
    (folder / "model.toml").write_text(FACTS)
    (folder / "__init__.py").write_text(CODE)
    (folder / "recipes" / "quick.toml").write_text('model = "warm"\n')
    with pytest.raises(ParameterError, match="unknown 'temperature_c'"):
        find("warm", [folder.parent])
    monkeypatch.setenv("TACTOGRAM_CONDITIONS", str(tmp_path / "temperature.py"))
    yield train("warm", store, out=tmp_path / "run", accelerator="cpu", model_folders=[folder.parent])
    for name in ("warm", "temperature"):
        sys.modules.pop(name, None)


def test_a_condition_of_one_file_is_an_option_a_column_and_a_promise(warm, tmp_path, capsys):
    assert find("warm", [tmp_path / "models"]).takes == ("temperature_c",)
    main(["generate", "--help"])
    assert "--temperature FLOAT" in capsys.readouterr().out
    made = tmp_path / "x.npz"
    told = ["generate", str(warm.folder), "--material", "cork", "--out"]
    assert main([*told, str(made), "--temperature", "31.5"]) == 0
    assert (read_signal(made).samples == 31.5).all()
    assert read_metadata(made)["temperature_c"] == 31.5
    (tmp_path / "table.csv").write_text("material,temperature,file\ncork,30,warm.npz\ncork,,cold.npz\n")
    table = ["--conditions", str(tmp_path / "table.csv"), "--processes", "1"]
    assert main(["generate", str(warm.folder), "--out", str(tmp_path / "all"), *table]) == 0
    levels = [read_signal(tmp_path / "all" / name).samples.max() for name in ("warm.npz", "cold.npz")]
    assert levels == [30, 0]
    assert main([*told, str(made), "--temperature", "nan"]) == 1
    assert "--temperature must be a finite number, got nan" in capsys.readouterr().err


@pytest.mark.parametrize("value", ["warm", np.nan, [1.0]])
def test_a_number_of_a_condition_is_checked_in_python_too(warm, value):
    with pytest.raises(ParameterError, match="temperature_c must be a finite number, °C") as refused:
        list(generate(warm.folder, {"material": "cork", "temperature_c": value}))
    assert refused.value.parameter == "temperature_c"


def test_a_second_condition_of_one_name_is_refused(tmp_path, monkeypatch):
    (tmp_path / "other_speed.py").write_text(CONDITION.replace('"temperature"', '"speed"'), encoding="utf-8")
    monkeypatch.setenv("TACTOGRAM_CONDITIONS", str(tmp_path / "other_speed.py"))
    with pytest.raises(ParameterError, match="rename 'speed', which is another condition's"):
        condition_types()
    sys.modules.pop("other_speed", None)


def test_every_option_states_a_condition():
    options = condition_options()
    assert options["mix"][0] is options["material"][0]
    assert {one.name for one, _ in options.values()} == condition_types().keys() - {"latent"}


def test_weights_are_kept_as_given():
    weights = material_weights({"material": {"tile": 0.4, "cork": 1.0}}, ("cork", "foam", "tile"))
    np.testing.assert_array_equal(weights, [1.0, 0.0, 0.4])
    np.testing.assert_array_equal(material_weights({"material": "foam"}, ("cork", "foam")), [0, 1])


@pytest.mark.parametrize(
    ("material", "message"),
    [
        ({"glass": 1}, "material must be one of cork, tile, got 'glass'"),
        ({"cork": -1}, "weight of cork must be finite and >= 0, got -1"),
        ({"cork": float("nan")}, "weight of cork must be finite"),
        ({"cork": 0, "tile": 0}, "at least one material needs a weight > 0"),
        (None, "condition 'material' is needed"),
    ],
)
def test_weights_that_mean_nothing_are_refused(material, message):
    with pytest.raises(ParameterError, match=message):
        material_weights({"material": material}, ("cork", "tile"))


def test_conditions_are_checked():
    check_condition({"material": "cork", "force_n": None}, needs=("material",))
    with pytest.raises(ParameterError, match="'speed_mm_s' is needed: stroking speed"):
        check_condition({}, needs=("speed_mm_s",))
    with pytest.raises(ParameterError, match=r"'force_n' is not one this model takes \(material\)"):
        check_condition({"material": "cork", "force_n": 1.0}, needs=("material",))


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        (
            {"material": ["cork"]},
            r"material must be str or Mapping \(weight per material.*\), got \['cork'\]",
        ),
        ({"image": "photo.jpg"}, r"image must be Image"),
        ({"vibration": np.zeros((3, 100))}, r"vibration must be Signal"),
        ({"motion": "simulated"}, r"motion must be Motion"),
        ({"speed_mm_s": "fast"}, r"speed_mm_s must be a finite number, mm/s, got 'fast'"),
    ],
)
def test_a_value_of_another_type_is_refused_by_the_name_of_its_condition(condition, message):
    with pytest.raises(ParameterError, match=message):
        check_values(condition)
