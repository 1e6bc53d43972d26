"""`stroke_gan` and `texture_gan` as shares of the machine's matrix-product rate.

The rate is that of a 2048 x 2048 float32 product, measured in the same run. Work is what the convolutions and
dense layers need as published, labels as constant channels and all: with g and d for one forward pass of generator
and discriminator, an update of the discriminator is g + 10 d per signal (three forward passes, two of them
differentiated once, one twice), one of the generator 3 g + 2 d. Activations, phase shuffle, optimiser and data
take time but are not work; nor is what noise and statistics of `texture_gan` need. `generate` is counted by the
pieces that its signals last; its bands are not matched here.
"""

import time
from itertools import pairwise
from statistics import median

import numpy as np
import torch

from tactogram.model import Example, SignalKind
from tactogram.models import find
from tactogram.recipe import Recipe
from tactogram.signal import Signal

CASES = (
    ("texture_gan", "quick", 1, 2500.0, {}),
    ("texture_gan", "quick", 3, 1000.0, {}),
    ("stroke_gan", "paper", 3, 1000.0, {"batch_size": 8}),
)


def run():
    rows = []
    for model, recipe, axes, rate, changes in CASES:
        shaped = model == "texture_gan"
        learner, kind, data = built(model, recipe, axes, rate, changes)
        config = learner.config
        labels = len(kind.materials) + (len(config.conditions) if shaped else 0)
        g, d = work(learner, labels, bands=config.noise_bands if shaped else 0)
        updates = (1, 1) if shaped else (config.critic_updates, config.generator_updates)
        step = config.batch_size * (updates[0] * (g + 10 * d) + updates[1] * (3 * g + 2 * d))
        if shaped:
            learner.average = None
        stage = learner.stages(data)[1]
        batch = next(learner.batches(stage, data, seed=0))
        size = {"model": model, "recipe": recipe, "axes": axes, "batch": config.batch_size}
        jobs = {"step": (step, lambda: learner.step(stage, batch))}  # noqa: B023
        for seconds, label in ((None, "one piece"), (60.0, "60 s")):
            length = config.length / rate if seconds is None else seconds
            jobs[f"generate, {label}"] = (
                g * length * rate / config.length,
                lambda s=seconds: learner.generate({"material": "a"}, seconds=s, seed=0),  # noqa: B023
            )
        for job, (operations, do) in jobs.items():
            rows.append({**size, "job": job, **measured(do, operations)})
    return rows


def measured(do, operations, repetitions=5):
    """Return rates and the share; each repetition runs the product and the job in turn."""
    do(), product()
    times = {"matrix": [], "job": []}
    for _ in range(repetitions):
        times["matrix"].append(timed(product))
        times["job"].append(timed(do))
    rate = 2 * 2048**3 / median(times["matrix"])
    return {
        "ms": 1e3 * median(times["job"]),
        "matrix product (GFLOP/s)": rate / 1e9,
        "share": operations / median(times["job"]) / rate,
        "threads": torch.get_num_threads(),
    }


def built(model, recipe, axes, rate, changes):
    random = np.random.default_rng(0)
    names = ("x", "y", "z")[:axes]
    data = [
        Example(str(i), Signal(random.standard_normal((axes, 17_000)), rate, "1", names), "abcdefghi"[i % 9])
        for i in range(18)
    ]
    facts = find(model)
    kind = SignalKind(rate, "1", names, tuple("abcdefghi"))
    values = Recipe.load(facts.recipe(recipe)).config | changes
    learner = facts.build(facts.config(values), kind, seed=0)
    learner.step(learner.stages(data)[0], data)
    return learner, kind, data


def work(learner, labels, *, bands):
    """Return the multiplications and additions of a forward pass of each network for one signal."""
    config, axes = learner.config, len(learner.kind.axes)
    widths, time = config.channels, config.points
    first = axes * time * widths[0]
    generator, discriminator = 2 * (config.latent + labels) * first, 2 * first
    for coarse, fine in pairwise((*widths, 1 + bands)):
        generator += 2 * axes * time * config.kernel * coarse * fine
        time *= config.stride
    time = config.length
    for fine, coarse in pairwise((1 + labels, *reversed(widths))):
        time //= config.stride
        discriminator += 2 * axes * time * config.kernel * coarse * fine
    return generator, discriminator


A = torch.randn(2048, 2048)


def product():
    return A @ A


def timed(function):
    start = time.perf_counter()
    function()
    return time.perf_counter() - start
