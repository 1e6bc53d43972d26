"""Three simulated plates and six signals of a display, all rated, and a small model trained on them."""

import numpy as np
import pytest

from tactogram.model import Example, ItemRatings, SignalKind
from tactogram.models.ultrasonic_cgan import Config, build
from tactogram.signal import Signal
from tactogram.training.loop import fit

RATE = 500.0
WORDS = ("rough", "sticky")
PLATES = ("plate01", "plate02", "plate03")
TINY = Config(
    clusters=2, bins=60, generator_widths=(12, 8), dropout_after=(2,), discriminator_widths=(6,), batch_size=8,
    iterations=24, smooth=4, rate_low=0.0, rate_high=1.0, stored=5, iterations_per_step=5,
)  # fmt: skip
KIND = SignalKind(RATE, "1", ("drive",), PLATES, simulated=True, words=WORDS, scale=(1.0, 7.0))


def rated(rough, sticky, seed, raters=4):
    """Simulated."""
    scores = np.random.default_rng(seed).normal((rough, sticky), 0.05, (raters, 2))
    return ItemRatings(WORDS, tuple(f"r{n}" for n in range(raters)), scores.clip(0, 1))


def measurement(plate, seed, rough, sticky):
    samples = np.random.default_rng([seed, plate]).standard_normal((4, 1250)) * (1 + plate) + 3
    signal = Signal(samples, RATE, "V", ("g1", "g2", "g3", "g4"))
    return Example(
        f"{PLATES[plate]}-m{seed}",
        signal,
        PLATES[plate],
        item=PLATES[plate],
        rated=rated(rough, sticky, plate),
    )


def display(number, rough, sticky, level=0.5):
    time = np.arange(500) / RATE
    signal = Signal(level * np.sin(2 * np.pi * (number + 1) * time), RATE, "1", ("drive",))
    return Example(f"d{number}", signal, item=f"signal{number:02d}", rated=rated(rough, sticky, number, 3))


def data(seeds=(0, 1)):
    scores = [(0.9, 0.1), (0.8, 0.2), (0.1, 0.9)]
    surfaces = [measurement(plate, seed, *scores[plate]) for plate in range(3) for seed in seeds]
    return surfaces + [display(n, n / 5, 1 - n / 5) for n in range(6)]


def trained(config=TINY, examples=None):
    learner = build(config, KIND, seed=0)
    fit(learner, examples or data(), seed=0)
    return learner


@pytest.fixture(scope="session")
def tiny():
    return TINY


@pytest.fixture(scope="session")
def kind():
    return KIND


@pytest.fixture(scope="session")
def learner():
    """Trained once for all: to look at, not to change."""
    return trained()


@pytest.fixture(scope="session", name="trained")
def trained_fixture():
    return trained


@pytest.fixture(scope="session", name="data")
def data_fixture():
    return data


@pytest.fixture(scope="session", name="measurement")
def measurement_fixture():
    return measurement


@pytest.fixture(scope="session", name="display")
def display_fixture():
    return display


@pytest.fixture(scope="session", name="rated")
def rated_fixture():
    return rated
