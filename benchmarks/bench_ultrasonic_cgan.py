"""Iterations per second of `ultrasonic_cgan` in the training loop, beside the bare arithmetic of the same iteration.

"loop": `fit` with everything around it (batches from memory, curves, the choice of the generator), on random data of
the size of the study: 10,080 sensor spectra, 39 display spectra, the published networks and batch. "bare": the same
networks, the same fused Adam and the same losses on one batch, with nothing around them. "plain": the bare arithmetic
with Adam as PyTorch has it by default, the generator run once for each network's update, and gradients of the
discriminator's weights in the generator's update. Each repetition runs the three in turn, on one thread; the table has
the medians. "minutes" is what 200,000 iterations take in the loop.
"""

import time
from statistics import median

import numpy as np
import torch
import torch.nn.functional as F
from torch import nn

from tactogram.model import SignalKind, Stage
from tactogram.models import find
from tactogram.models.ultrasonic_cgan.learner import TrainingSpectra
from tactogram.models.ultrasonic_cgan.networks import Discriminator, Generator
from tactogram.models.ultrasonic_cgan.spectra import SideSpectra
from tactogram.models.ultrasonic_cgan.surfaces import SurfaceTable
from tactogram.training.seeds import torch_seeded

REPETITIONS, ITERATIONS = 5, 20
WORDS = tuple("abcdefghij")


def run():
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        return [row()]
    finally:
        torch.set_num_threads(threads)


def row():
    steps = looped()
    jobs = {"loop": lambda: next(steps), "bare": bare(fused=True), "plain": bare(fused=False)}
    times = {name: [] for name in jobs}
    for repetition in range(REPETITIONS + 1):
        for name, job in jobs.items():
            start = time.perf_counter()
            job()
            if repetition:  # the first warms up
                times[name].append((time.perf_counter() - start) / ITERATIONS)
    loop, least, plain = (median(times[name]) for name in jobs)
    return {
        "loop (iterations/s)": 1 / loop,
        "bare (iterations/s)": 1 / least,
        "plain (iterations/s)": 1 / plain,
        "loop / bare": median(a / b for a, b in zip(times["loop"], times["bare"], strict=True)),
        "faster than plain": plain / loop,
        "minutes": 200_000 * loop / 60,
        "threads": 1,
    }


def looped():
    """Yield after each step of the loop, of `ITERATIONS` iterations."""
    facts = find("ultrasonic_cgan")
    config = facts.config({"clusters": 1, "iterations_per_step": ITERATIONS})
    plates = tuple(f"plate{n:02d}" for n in range(12))
    kind = SignalKind(10_000.0, "1", ("drive",), plates, words=WORDS, scale=(1.0, 7.0))
    learner = facts.build(config, kind, seed=0)
    sensor, display = side(plates, 10_080), side(tuple(f"signal{n:02d}" for n in range(39)), 39)
    examples = []
    learner._data = TrainingSpectra(examples, sensor, display)
    learner.surfaces = SurfaceTable.measured(sensor, display, config)
    stage = Stage("cluster-1", config.iterations // ITERATIONS)
    for step, batch in enumerate(learner.batches(stage, examples, seed=0)):
        with torch_seeded(0, "step", stage.name, 0, step):
            learner.step(stage, batch)
        yield


def side(items, count):
    rng = np.random.default_rng(0)
    return SideSpectra(
        spectra=rng.random((count, 1000), np.float32),
        item=np.arange(count) % len(items),
        place=np.zeros((count, 3), int),
        items=items,
        recordings=("r",),
        scores=tuple(rng.random((32, 10), np.float32) for _ in items),
        means=rng.random((len(items), 10)),
        filled=0.0,
    )


def bare(*, fused):
    """Return a function that runs `ITERATIONS` iterations on one batch."""
    config = find("ultrasonic_cgan").config()
    generator, discriminator = Generator(config, words=10), Discriminator(config, words=10)
    optimisers = [
        torch.optim.Adam(n.parameters(), lr=1e-3, fused=True)
        if fused
        else torch.optim.Adam(n.parameters(), lr=1e-3)
        for n in (generator, discriminator)
    ]
    x, display = torch.rand(64, 1010), torch.rand(64, 1010)
    truth = torch.cat((torch.ones(64, 1), torch.zeros(64, 1)))

    def lean():
        fake = torch.cat((generator(x), x[:, 1000:]), 1)
        descend(
            1, F.binary_cross_entropy_with_logits(discriminator(torch.cat((display, fake.detach()))), truth)
        )
        discriminator.requires_grad_(False)
        loss = F.binary_cross_entropy_with_logits(discriminator(fake), truth[:64])
        discriminator.requires_grad_(True)
        descend(0, loss)

    def plain():
        loss = nn.BCELoss()
        with torch.no_grad():
            fake = torch.cat((generator(x), x[:, 1000:]), 1)
        told, known = discriminator.probability(fake), discriminator.probability(display)
        descend(1, (loss(told, truth[64:]) + loss(known, truth[:64])) / 2)
        fake = torch.cat((generator(x), x[:, 1000:]), 1)
        descend(0, loss(discriminator.probability(fake), truth[:64]))

    def descend(which, loss):
        optimisers[which].zero_grad()
        loss.backward()
        optimisers[which].step()

    return lambda: [lean() if fused else plain() for _ in range(ITERATIONS)]
