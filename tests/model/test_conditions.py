"""Weights of materials, and conditions that a model needs or takes."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.model import check_condition, material_weights


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
