"""Training steps and generation of the networks: time, and how many matrix products take as long in the same run.

"ratio" is to the product of two 2048 x 2048 float32 matrices. Each repetition runs it and the job in turn; medians.
All data is noise, and photographs of noise. `stroke_gan` and `visual_tactile_gan` have smaller batches than published.
Generation includes phase recovery.
"""

import numpy as np
import torch

from benchmarks.timing import beside
from tactogram.model import Example, SignalKind
from tactogram.models import find
from tactogram.recipe import Recipe
from tactogram.signal import Image, Signal

REPETITIONS = 5
MATERIALS = tuple("abcdefghi")
CASES = (
    ("stroke_cnn", "quick", 1, 2500.0, {}, ()),
    ("stroke_cnn", "quick", 3, 330.0, {}, ()),
    ("texture_flow", "quick", 1, 2500.0, {}, (4.0, 60.0)),
    ("texture_flow", "quick", 3, 1000.0, {}, (4.0, 60.0)),
    ("texture_gan", "quick", 1, 2500.0, {}, (60.0,)),
    ("texture_gan", "quick", 3, 1000.0, {}, (60.0,)),
    ("stroke_gan", "paper", 3, 1000.0, {"batch_size": 8}, (60.0,)),
    ("frictgan", "quick", 1, 40.0, {}, (None,)),
    ("visual_tactile_gan", "bench", 1, 10_000.0, {"batch_size": 4}, (None,)),
)
"""Model, recipe, axes, rate in Hz, changes of the configuration, and lengths of what is generated in seconds."""

MATCHING = ("match",)
"""Names of stages after the training."""


def run():
    rows = []
    for model, recipe, axes, rate, changes, lengths in CASES:
        learner, data = built(model, recipe, axes, rate, changes)
        stage = [one for one in learner.stages(data) if one.name not in MATCHING][-1]
        batch = next(learner.batches(stage, data, seed=0))
        case = {"model": model, "recipe": recipe, "axes": axes, "batch": learner.config.batch_size}
        rows.append({**case, "job": "step", **measured(lambda: learner.step(stage, batch))})  # noqa: B023
        condition = {"image": picture(data[0])} if lengths == (None,) else {"material": "a"}
        for seconds in lengths:
            job = "generate from a photograph" if seconds is None else f"generate {seconds:g} s"
            options = {"seed": 0} if seconds is None else {"seed": 0, "seconds": seconds}
            made = measured(lambda: learner.generate(condition, **options))  # noqa: B023
            rows.append({**case, "job": job, **made})
    return rows


def built(model, recipe, axes, rate, changes):
    """Return a learner that has done the step of its first stage, and its data."""
    facts = find(model)
    config = facts.config(Recipe.load(facts.recipe(recipe)).config | changes)
    names = ("x", "y", "z")[:axes]
    friction = model == "frictgan"
    kind = SignalKind(rate, "1", names, MATERIALS, True, "displacement" if friction else "time")
    data = [example(number, kind, friction) for number in range(18)]
    learner = facts.build(config, kind, seed=0)
    learner.step(learner.stages(data)[0], (data,) if friction else data)
    return learner, data


def example(number, kind, friction):
    """Return noise, with a photograph of noise that friction is registered with."""
    random = np.random.default_rng(number)
    pixels = random.integers(0, 255, (320, 640, 3), dtype=np.uint8)
    if friction:
        samples = 0.4 + 0.1 * random.standard_normal((1, round(640 * 0.05 * kind.rate)))
        signal, image = Signal(samples, kind.rate, "1", kind.axes, "displacement"), Image(pixels, 0.05)
        return Example(str(number), signal, MATERIALS[number % 9], {"image": image})
    signal = Signal(random.standard_normal((len(kind.axes), 48_000)), kind.rate, "1", kind.axes)
    return Example(str(number), signal, MATERIALS[number % 9], photographs=(Image(pixels),))


def picture(given):
    return given.photographs[0] if given.photographs else given.condition["image"]


FACTORS = torch.randn(2, 2048, 2048)


def measured(do):
    """Return how many matrix products take as long as a job, and its time."""
    return beside(lambda: FACTORS[0] @ FACTORS[1], do, REPETITIONS) | {"threads": torch.get_num_threads()}
