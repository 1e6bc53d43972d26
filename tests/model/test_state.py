"""State of an object: its named attributes, those of its parts, and the types they come back with."""

import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.model.state import Saved


class Part(Saved):
    saved = ("level",)

    def __init__(self):
        self.level = 0.0


class Whole(Saved):
    saved = ("materials", "steps", "spectrum", "part", "network=_network", "chosen")

    def __init__(self, materials=("cork", "tile")):
        self.materials = materials
        self.steps = 0
        self.spectrum = np.zeros(3, np.float32)
        self.part = Part()
        self._network = torch.nn.Linear(2, 1)
        self.chosen = None


def test_a_state_comes_back_with_the_types_of_the_attributes():
    one, other = Whole(), Whole()
    one.steps, one.spectrum, one.chosen = 7, np.arange(3, dtype=np.float32), {"step": 2}
    one.part.level = 0.5
    state = one.state()
    assert set(state) == {"materials", "steps", "spectrum", "part", "network", "chosen"}
    # As from a file: arrays are tensors, and a whole number may be a float.
    other.load_state({**state, "spectrum": torch.from_numpy(one.spectrum), "steps": 7.0})
    assert (other.steps, type(other.steps)) == (7, int)
    assert other.spectrum.dtype == np.float32
    np.testing.assert_array_equal(other.spectrum, [0, 1, 2])
    assert (other.part.level, other.chosen) == (0.5, {"step": 2})
    torch.testing.assert_close(other._network.weight, one._network.weight)


def test_names_are_compared_and_not_replaced():
    state = Whole().state()
    assert state["materials"] == ["cork", "tile"]
    with pytest.raises(ParameterError, match="state is of cork, tile; expected cork, felt"):
        Whole(("cork", "felt")).load_state(state)
