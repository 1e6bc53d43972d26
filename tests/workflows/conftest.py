"""A small store of made-up textures that every job can be tried on, and a classifier trained on it."""

import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram.datasets import Recording, create_store
from tactogram.signal import Signal
from tactogram.workflows.training.train import train

POLES = {"cork": 0.95, "foam": 0.3, "tile": -0.8, "wool": -0.3}
TINY = {"config.steps": 60, "config.batch_size": 16, "config.learning_rate": 3e-3}


def texture(material, seed, *, seconds=3.0, rate=330.0):
    noise = np.random.default_rng(seed).standard_normal((3, int(seconds * rate)))
    gravity = np.array([[0], [0], [9.81]])
    return Signal(lfilter([1], [1, -POLES[material]], noise) + gravity, rate, "m/s^2")


def recordings(materials=tuple(POLES), count=10, first=0):
    for number in range(first, first + count):
        for place, name in enumerate(materials):
            yield Recording(
                streams={"acceleration": texture(name, 1000 * place + number)},
                material=name,
                contactor=("finger", "pen")[number % 2],
                speed_mm_s=(100.0, 200.0)[number % 2],
                labels={"recording": str(number)},
                source=f"{name}/{number}",
                simulated=True,
            )


@pytest.fixture(scope="session", name="texture")
def texture_fixture():
    return texture


@pytest.fixture(scope="session", name="recordings")
def recordings_fixture():
    return recordings


@pytest.fixture(scope="session")
def tiny():
    return TINY


@pytest.fixture(scope="session")
def store(tmp_path_factory):
    path = tmp_path_factory.mktemp("data") / "store"
    create_store(path, recordings(), name="textures", licence="made in a test", simulated=True)
    return path


@pytest.fixture(scope="session")
def run(store, tmp_path_factory):
    """A classifier of three of the four materials."""
    out = tmp_path_factory.mktemp("runs") / "cnn"
    return train(
        "stroke_cnn",
        store,
        recipe="tiny",
        changes=TINY,
        where={"material": "!wool"},
        out=out,
        accelerator="cpu",
    )
