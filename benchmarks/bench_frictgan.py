"""`frictgan` as a share of the machine's matrix-product rate, beside the plainest training step, and its loader.

The rate is that of a 2048 x 2048 float32 product, measured in the same run. Work is what convolutions and dense layers
need, counted layer by layer: with g and d for one forward pass of generator and critic, an update of the critic is
g + 6 d per pair (two passes, differentiated by the weights and passed back), one of the generator 3 g + 2 d. Padding,
normalisation, optimiser and phase recovery take time but are not work. "plain" is the step with no graph left out: the
gradients of both networks are computed in the updates of either. `paper` is measured with one critic update per step
instead of five. The loader cuts windows from simulated photographs that lie decoded; "load / step" below 1 feeds more
than the step can eat. "growth" is by how much the largest memory is larger after an epoch of 64 fabrics than of 16.
"""

import resource
import time
from statistics import median

import numpy as np
import torch
from torch import nn

from tactogram.features import registered_pairs
from tactogram.features.registered_pairs import RegisteredPairs
from tactogram.model import Example, SignalKind
from tactogram.models import find
from tactogram.models.frictgan.learner import grouped
from tactogram.recipe import Recipe
from tactogram.signal import Image, Signal

KIND = SignalKind(40.0, "1", ("along",), ("a", "b"), True, "displacement")
CASES = (("quick", {}, 5), ("paper", {"critic_updates": 1, "protocol": "examples"}, 3))


def run():
    rows = [{"job": "memory of an epoch", **memory()}]  # first: the networks take more
    for recipe, changes, repetitions in CASES:
        facts = find("frictgan")
        config = facts.config(Recipe.load(facts.recipe(recipe)).config | changes)
        learner = facts.build(config, KIND, seed=0)
        data = fabrics(2, config.pixels)
        learner.step(learner.stages(data)[0], (data,))
        stage = learner.stages(data)[-1]
        batch = next(learner.batches(stage, data, seed=0))
        g, d = work(learner)
        size = config.batch_size
        step = size * (config.critic_updates * (g + 6 * d) + 3 * g + 2 * d)
        condition = {"image": data[0].condition["image"]}
        jobs = {
            "step": (step, lambda: learner.step(stage, batch), lambda: plain_step(learner, stage, batch)),  # noqa: B023
            "photo to signal": (g, lambda: learner.generate(condition, seed=0), None),  # noqa: B023
        }
        seconds = {}
        for job, (operations, ours, plain) in jobs.items():
            row = compare(ours, plain, operations, repetitions)
            seconds[job] = row["ms"] / 1e3
            rows.append({"recipe": recipe, "batch": size, "job": job, **row})
        rows.append(
            {"recipe": recipe, "batch": size, "job": "load", **loading(learner, data, seconds["step"])}
        )
    return rows


def compare(ours, plain, operations, repetitions):
    """Return rates and shares; each repetition runs the product, ours and the plain form in turn."""
    times = {"matrix": [], "ours": [], "plain": []}
    for repetition in range(repetitions + 1):
        for name, do in (("matrix", product), ("ours", ours), ("plain", plain)):
            if do is not None:
                start = time.perf_counter()
                do()
                if repetition:  # the first warms up
                    times[name].append(time.perf_counter() - start)
    rate = 2 * 2048**3 / median(times["matrix"])
    row = {
        "ms": 1e3 * median(times["ours"]),
        "matrix product (GFLOP/s)": rate / 1e9,
        "share": operations / median(times["ours"]) / rate,
        "threads": torch.get_num_threads(),
    }
    if plain is not None:
        row |= {
            "plain (ms)": 1e3 * median(times["plain"]),
            "faster than plain": median(times["plain"]) / median(times["ours"]),
        }
    return row


def plain_step(learner, stage, batch):
    """Do the step with no graph left out."""
    photos, frictions, _ = batch
    real = learner.as_learned(frictions)
    size = learner.config.batch_size
    for first in range(0, len(photos), size):
        part = slice(first, first + size)
        made = learner._make(photos[part])
        scores = learner.discriminator(photos[part], real[part]), learner.discriminator(photos[part], made)
        learner.descend(1, scores[1].mean() - scores[0].mean())
        with torch.no_grad():
            for weight in learner.discriminator.parameters():
                weight.clamp_(-learner.config.clip, learner.config.clip)
    made = learner._make(photos[part])
    loss = (
        learner.config.l1 * (made - real[part]).abs().mean()
        - learner.discriminator(photos[part], made).mean()
    )
    learner.descend(0, loss)


def loading(learner, data, step_s):
    """Return how long the pairs of a step take to load."""
    pairs = learner.pairs(data)
    count = learner.config.batch_size * learner.config.critic_updates
    groups = grouped(pairs.order(0), count)
    pairs.batch(next(groups))
    times = []
    for _ in range(10):
        start = time.perf_counter()
        pairs.batch(next(groups))
        times.append(time.perf_counter() - start)
    return {
        "ms": 1e3 * median(times),
        "pairs/s": count / median(times),
        "load / step": median(times) / step_s,
    }


def memory():
    """Return the growth of the largest memory from an epoch of 16 fabrics to one of 64, none kept by the caller."""
    windows = find("frictgan").config(Recipe.load(find("frictgan").recipe("quick")).config).photo_windows()
    held, registered_pairs.CACHED_BYTES = registered_pairs.CACHED_BYTES, 16 * 1024 * 1024
    try:
        peaks = []
        for count in (16, 64):
            pairs = RegisteredPairs(Made(count), windows, part="train")
            order = pairs.order(0)
            for _ in range(len(pairs) // 16):
                pairs.batch([next(order) for _ in range(16)])
            peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    finally:
        registered_pairs.CACHED_BYTES = held
    return {"growth (MB)": peaks[1] - peaks[0], "photographs (MB)": 48 * 512 * 1024 * 3 / 2**20}


class Made:
    """Fabrics that are made when asked for, as a store's are read."""

    def __init__(self, count):
        self.count = count

    def __len__(self):
        return self.count

    def __getitem__(self, number):
        if number >= self.count:
            raise IndexError(number)
        return fabric(number, 512, 1024)


def fabrics(count, pixels):
    return [fabric(number, pixels, 2 * pixels) for number in range(count)]


def fabric(number, rows, columns):
    random = np.random.default_rng(number)
    image = Image(random.integers(0, 255, (rows, columns, 3), dtype=np.uint8), 0.05)
    x = np.arange(round(columns * 0.05 * KIND.rate)) / KIND.rate
    felt = 0.4 + 0.1 * np.sin(2 * np.pi * (1 + number % 3) * x) + 0.01 * random.standard_normal(len(x))
    signal = Signal(felt, KIND.rate, "1", ("along",), "displacement")
    return Example(str(number), signal, "ab"[number % 2], {"image": image})


def work(learner):
    """Return the multiplications and additions of a forward pass of each network for one pair."""
    config, counted = learner.config, []

    def count(layer, given, made):
        if isinstance(layer, nn.Linear):
            counted.append(2 * layer.in_features * layer.out_features)
        else:
            area = made if isinstance(layer, nn.Conv2d) else given[0]
            counted.append(2 * layer.weight.numel() * area.shape[2] * area.shape[3])

    photo = torch.zeros(1, 3, config.pixels, config.pixels)
    spectrogram = torch.zeros(1, 1, config.bins, config.frames)
    totals = []
    for network, given in (
        (learner.generator, (photo, torch.zeros(1, config.noise))),
        (learner.discriminator, (photo, spectrogram)),
    ):
        hooks = [
            layer.register_forward_hook(count)
            for layer in network.modules()
            if isinstance(layer, nn.Conv2d | nn.ConvTranspose2d | nn.Linear)
        ]
        counted.clear()
        network.eval()
        with torch.no_grad():
            network(*given)
        network.train()
        totals.append(sum(counted))
        for hook in hooks:
            hook.remove()
    return totals


FACTORS = torch.randn(2, 2048, 2048)


def product():
    return FACTORS[0] @ FACTORS[1]
