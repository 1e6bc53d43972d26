import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.model import SignalKind, check_condition, material_weights
from tactogram.signal import Signal


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


def test_a_kind_refuses_another_rate():
    kind = SignalKind(330, "m/s^2", ("x", "y", "z"))
    kind.check(Signal(np.zeros((3, 4)), 330, "m/s^2"))
    with pytest.raises(ParameterError, match="signal must be 330 Hz.*got 1000 Hz, m/s\\^2, axes x,y,z$"):
        kind.check(Signal(np.zeros((3, 4)), 1000, "m/s^2"))


def test_a_kind_says_how_axes_of_other_names_are_read():
    kind = SignalKind(330, "m/s^2", ("x", "y", "z"))
    with pytest.raises(ParameterError, match=r"got .* axes ax,ay,az; read it with axes x,y,z if these"):
        kind.check(Signal(np.zeros((3, 4)), 330, "m/s^2", ("ax", "ay", "az")))


def test_a_kind_over_displacement_refuses_a_signal_over_time():
    kind = SignalKind(40, "1", ("friction",), domain="displacement")
    kind.check(Signal(np.zeros((1, 4)), 40, "1", ("friction",), "displacement"))
    with pytest.raises(ParameterError, match="must be 40 samples per mm.*got 40 Hz"):
        kind.check(Signal(np.zeros((1, 4)), 40, "1", ("friction",)))
    with pytest.raises(ParameterError, match="domain must be 'time' or 'displacement'"):
        SignalKind(40, "1", ("friction",), domain="space")
