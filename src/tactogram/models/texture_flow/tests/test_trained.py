"""The weights that come with the model: what they are of, and that a stroke or words are enough."""

import json

import numpy as np
import pytest
import torch
from scipy.signal import lfilter, welch

from tactogram import models
from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind, Stage
from tactogram.models.texture_flow import Config, build
from tactogram.signal import Signal
from tactogram.workflows.training.loaded_run import load_run

RUN = models.find("texture_flow").folder / models.SHIPPED
RATE = 2500.0


def stroke(seconds=2.0):
    """Simulated: a resonance at 200 Hz, 1 m/s^2."""
    x = lfilter(
        [1], [1, -1.9 * np.cos(2 * np.pi * 200 / RATE), 0.9025], np.random.default_rng(0).normal(size=9000)
    )
    x = x[1000 : 1000 + round(seconds * RATE)]
    return Signal((x / x.std())[None], RATE, "m/s^2", ("z",))


def spectrum(signal):
    return 10 * np.log10(welch(signal.samples[0], signal.rate, nperseg=128)[1][2:50])


def test_it_is_small_and_names_its_data_but_no_path():
    assert sum(file.stat().st_size for file in RUN.iterdir()) < 8e6
    data = json.loads((RUN / "data.json").read_text())
    assert (data["simulated"], data["licence"]) == (True, "CC0-1.0")
    assert "path" not in data
    assert load_run("texture_flow").kind.simulated


def test_a_stroke_of_an_unknown_surface_is_continued():
    run = load_run("texture_flow")
    vibration = run.prepare_vibration(stroke())
    signal = run.generator.generate({"vibration": vibration}, seconds=8, seed=0)
    assert signal.seconds == 8
    assert signal.samples.std() == pytest.approx(vibration.samples.std(), rel=0.3)
    assert np.sqrt(np.mean((spectrum(signal) - spectrum(vibration)) ** 2)) < 3


def test_a_faster_stroke_is_stronger():
    run = load_run("texture_flow")
    condition = {"vibration": run.prepare_vibration(stroke()), "vibration_speed_mm_s": 80.0}
    slow, fast = (
        run.generator.generate({**condition, "speed_mm_s": speed}, seconds=4, seed=0).samples.std()
        for speed in (50, 300)
    )
    assert fast > 1.5 * slow


def test_a_training_begins_with_its_weights():
    kind = SignalKind(RATE, "m/s^2", ("z",), ("a", "b"), simulated=True)
    examples = [Example(f"{name}{k}", stroke(), name) for name in "ab" for k in range(2)]
    learner = build(Config(start="texture_flow"), kind, seed=0)
    learner.step(Stage("fit", 1), examples)
    shipped = load_run("texture_flow").model.flow.average.network.state_dict()
    for weights in (learner.flow.network.state_dict(), learner.flow.average.network.state_dict()):
        assert all(torch.equal(weights[name], value) for name, value in shipped.items())
    narrow = build(Config(start="texture_flow", widths=(8, 16)), kind, seed=0)
    with pytest.raises(ParameterError, match="config.start must be a run of texture_flow of 1 axes, 64 bins"):
        narrow.step(Stage("fit", 1), examples)
