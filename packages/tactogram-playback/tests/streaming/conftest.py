"""Textures and motion to stream in tests; all simulated."""

import sys
from pathlib import Path

import numpy as np
import pytest

from tactogram.rendering.motion.recorded_motion import SimulatedHand
from tactogram.signal.autoregressive import AutoregressiveModel
from tactogram.signal.texture_map import TextureMap
from tactogram_playback.streaming.engine import Engine
from tactogram_playback.streaming.texture_table import TextureTable
from tactogram_playback.streaming.textures import AutoregressiveTexture

HERE = Path(__file__)
sys.path += [str(HERE.parent), str(HERE.parents[4] / "tests" / "signal")]  # quiet_engine, seams

RATE = 8000.0
MOST = 40


def resonance(frequency, *, rms=1.0, rate=RATE, radius=0.99):
    """A model with one peak, of given rms."""
    polynomial = [1, -2 * radius * np.cos(2 * np.pi * frequency / rate), radius**2]
    flat = AutoregressiveModel.from_coefficients([polynomial], [1.0], rate=rate, unit="m/s^2")
    return AutoregressiveModel.from_coefficients(
        [polynomial], [rms**2 / flat.power[0]], rate=rate, unit="m/s^2"
    )


def sloping_map(*, rate=RATE):
    """A surface whose peak lies at 2 Hz per mm/s and whose rms is 1 + force."""
    conditions = [(v, f) for v in (50.0, 150.0, 300.0) for f in (0.2, 1.0)]
    return TextureMap([resonance(2 * v, rms=1 + f, rate=rate) for v, f in conditions], conditions)


def rendered(engine, seconds):
    """Everything an engine renders, and the speed at the end of each block."""
    blocks, speeds = [], []
    for number in range(round(seconds * engine.rate / engine.most)):
        blocks.append(engine.render(number * engine.most / engine.rate).copy())
        speeds.append(engine.tracker.block.speed_mm_s[engine.most - 1])
    return np.concatenate(blocks, axis=1), np.array(speeds)


@pytest.fixture(name="rendered")
def rendered_fixture():
    return rendered


@pytest.fixture(name="resonance")
def resonance_fixture():
    return resonance


@pytest.fixture(scope="session")
def sloping():
    return sloping_map()


@pytest.fixture(scope="session")
def table(sloping):
    return TextureTable(sloping)


@pytest.fixture(name="texture")
def texture_fixture(table):
    def make(name="slope", seed=0):
        return AutoregressiveTexture(name, table, rate=RATE, most=MOST, seed=seed)

    return make


@pytest.fixture(name="engine", scope="session")
def engine_fixture(table):
    def make(motion=None, *, count=1, rate=RATE, most=MOST):
        textures = [AutoregressiveTexture(f"t{n}", table, rate=rate, most=most, seed=n) for n in range(count)]
        return Engine(textures, motion or SimulatedHand(3, seed=0), rate=rate, most=most)

    return make
