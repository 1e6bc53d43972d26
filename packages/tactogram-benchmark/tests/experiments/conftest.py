"""Workflows that take hours, replaced by made-up ones."""

import numpy as np
import pytest
from made_up_signals import MATERIALS
from scipy.signal import lfilter

from tactogram.datasets import Recording, create_store
from tactogram.signal import Signal


@pytest.fixture
def stand_in(monkeypatch):
    """Put the methods of an object in the place of the workflows of those names; refuses one that no module imports."""

    def put(made_up, *modules):
        for name in (name for name in vars(type(made_up)) if not name.startswith("_")):
            users = [module for module in modules if name in vars(module)]
            assert users, f"no experiment imports a workflow called {name}"
            for module in users:
                monkeypatch.setattr(module, name, getattr(made_up, name))
        return made_up

    return put


@pytest.fixture
def folder(tmp_path):
    """A folder with strokes of nine made-up textures where the simulated ones would be."""

    def strokes():
        for number in range(8):
            for place, name in enumerate(MATERIALS):
                noise = np.random.default_rng([place, number]).standard_normal((3, 1200))
                # The last two are so alike that nothing can be mixed of them.
                pole, gain = 0.95 - 0.2 * min(place, 7), 1.6 ** min(place, 7)
                yield Recording(
                    streams={"acceleration": Signal(gain * lfilter([1], [1, -pole], noise), 600, "m/s^2")},
                    material=name,
                    source=f"{name}/{number}",
                    simulated=True,
                )

    create_store(tmp_path / "data", strokes(), name="made up", licence="-", simulated=True)
    return tmp_path
