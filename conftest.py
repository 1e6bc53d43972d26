"""What every test may use."""

import gc
import math
import os
import time
from functools import reduce
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import settings

# The same examples in every run: a failure is seen by whoever runs the tests next, and never by chance alone.
# Search further with HYPOTHESIS_PROFILE=search.
settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=40)
settings.register_profile("search", deadline=None, max_examples=500)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


def pytest_addoption(parser):
    parser.addoption("--regen", action="store_true", help="make the golden files anew; look at what changed")


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Look for tests without the collector of garbage, which would look at all that stays through the session."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


LONGEST = (
    "test_models.py",
    "test_tour.py",
    "pages/test_touch.py",
    "test_ray_cluster.py",
    "train/test_page.py",
)
SLOW = {"browser", "cluster"}
"""Fixtures that start a browser or a cluster, whose processes keep their own time."""


# First, since -m looks at the marks in this hook, too.
@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark what starts a browser or a cluster as slow, and begin with the files that take longest.

    Such a test may fail once where the machine is busy; the closing line counts these.
    Of several processes none is then left with one of these files when the others are done.
    """
    for item in items:
        if SLOW & set(item.fixturenames):
            item.add_marker("slow")
            item.add_marker(pytest.mark.flaky(reruns=1))
    items.sort(key=lambda item: not item.path.as_posix().endswith(LONGEST))


@pytest.fixture(scope="session")
def until():
    """Give a function that waits for what another process or thread does, and returns what it waited for."""

    def wait(condition, seconds=180.0):
        end = time.monotonic() + seconds
        while not (found := condition()):
            assert time.monotonic() < end, "it did not come to be"
            time.sleep(0.01)
        return found

    return wait


@pytest.fixture
def golden(request):
    """Give a function that returns a golden file's text; with --regen it is first made from ``made``."""

    def text(name: str, made: str) -> str:
        path = request.path.parent / "golden" / name
        if request.config.getoption("--regen"):
            path.parent.mkdir(exist_ok=True)
            path.write_text(made, encoding="utf-8")
        if not path.is_file():
            pytest.fail(f"no golden file {path.name}: make it with pytest --regen, look at it, commit it")
        return path.read_text(encoding="utf-8")

    return text


def real_data(name: str) -> Path:
    """Return the folder of a real data set, or skip: real recordings are not part of the project."""
    root = Path(os.environ.get("TACTOGRAM_REAL_DATA") or Path(__file__).parents[1] / "shared" / "data")
    folder = root / name
    if not folder.is_dir():
        pytest.skip(f"no real recordings at {name}: set TACTOGRAM_REAL_DATA to the folder that holds them")
    return folder


@pytest.fixture(name="real_data", scope="session")
def real_data_fixture():
    """Give `real_data` to tests."""
    return real_data


@pytest.fixture(name="write_log", scope="session")
def write_log_fixture():
    """Give `tactogram_capture.twelite.simulator.write_log`."""
    from tactogram_capture.twelite.simulator import write_log

    return write_log


# -- a small store of made-up textures that every job can be tried on, and a classifier trained on it ---------

POLES = {"cork": 0.95, "foam": 0.3, "tile": -0.8, "wool": -0.3}
TINY = {"config.steps": 60, "config.batch_size": 16, "config.learning_rate": 3e-3}


def texture(material, seed, *, seconds=3.0, rate=330.0):
    import numpy as np
    from scipy.signal import lfilter

    from tactogram.signal import Signal

    noise = np.random.default_rng(seed).standard_normal((3, int(seconds * rate)))
    gravity = np.array([[0], [0], [9.81]])
    return Signal(lfilter([1], [1, -POLES[material]], noise) + gravity, rate, "m/s^2")


def recordings(materials=tuple(POLES), count=10, first=0):
    from tactogram.datasets import Recording

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
    from tactogram.datasets import create_store

    path = tmp_path_factory.mktemp("data") / "store"
    create_store(path, recordings(), name="textures", licence="made in a test", simulated=True)
    return path


@pytest.fixture(scope="session")
def run(store, tmp_path_factory):
    """A classifier of three of the four materials."""
    from tactogram.workflows.training.train import train  # loads torch

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


@pytest.fixture
def command(capsys):
    """Give a function that runs a command line and returns its exit code, what it printed and what it complained."""
    from tactogram.cli import main

    def run(*arguments):
        capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        said = capsys.readouterr()
        return SimpleNamespace(returncode=code, stdout=said.out, stderr=said.err)

    return run


@pytest.fixture(scope="session")
def write_pairs():
    """Give a function that writes a table of voltage and friction of two people."""
    import numpy as np

    def write(path):
        random = np.random.default_rng(0)
        rows = ["person,voltage_v_rms,friction,normal_force_n"]
        for person, k_e in (("anna", 2e-5), ("ben", 4e-5)):
            for v in np.repeat([0, 40, 70, 100.0], 6):
                mu = 0.3 * (1 + k_e * v**2 / 0.5) + 0.005 * random.standard_normal()
                rows.append(f"{person},{v},{mu:.6f},0.5")
        path.write_text("\n".join(rows) + "\n")
        return path

    return write


class Script:
    """Motion by a function of time, sampled at a rate, without delay."""

    name = "script"
    simulated = True

    def __init__(self, place, force=lambda t: 0.5, *, rate=500.0, speed=None, end=math.inf):
        self._place, self._force, self._speed = place, force, speed
        self._step, self._next, self._end = 1 / rate, 0, end

    def poll(self, now_s):
        from tactogram.rendering import MotionSample

        found = []
        while (t := self._next * self._step) <= now_s:
            self._next += 1
            if t < self._end:
                x = self._place(t) if self._place else math.nan
                y = 0.0 if self._place else math.nan
                speed = self._speed(t) if self._speed else math.nan
                found.append(MotionSample(t, t, x, y, speed, self._force(t) if self._force else math.nan))
        return found

    def close(self):
        pass


@pytest.fixture(name="script", scope="session")
def script_fixture():
    return Script


@pytest.fixture
def double_precision(monkeypatch):
    """Compute in float64, so that two forms of one update differ by their formulas alone.

    Adam divides a gradient by its size: in float32, rounding decides where a weight goes whose gradient is 0.
    """
    import torch

    before = torch.get_default_dtype()
    torch.set_default_dtype(torch.float64)
    monkeypatch.setattr(torch.Tensor, "float", torch.Tensor.double)
    yield
    torch.set_default_dtype(before)


@pytest.fixture
def paper_values():
    """Return a function that reads the recipe ``paper`` of a model at dotted keys of its configuration."""
    from tactogram import models
    from tactogram.recipe import Recipe

    def read(name, keys):
        facts = models.find(name)
        config = facts.config(Recipe.load(facts.recipe("paper")).config)
        return {key: reduce(getattr, key.split("."), config) for key in keys}

    return read
