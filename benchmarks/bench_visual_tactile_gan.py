"""`visual_tactile_gan` as a share of the machine's matrix-product rate, beside the plainest PyTorch form of its step.

The rate is that of a 2048 x 2048 float32 product, measured in the same run. Work is what the convolutions need: with g
and d for one forward pass of the generator and of all discriminators, a step is 3 g + 8 d per pair (real and made, each
forward and back for the discriminators: 6 d; once more forward, and back to the picture alone, for the generator: 2 d).
"plain": the losses as they are written down, each network called and differentiated wherever it appears, the gradients
of the discriminators' weights from the generator's loss computed and thrown away. "pairs": how many pairs a second
the loader gives, once crops are in memory, beside what a step eats. "photo to signal" is a crop, a forward pass and the
phase; its share counts the forward pass alone. Published sizes, fewer pairs in a batch than the 32 of the paper.
"""

import time
from statistics import median

import numpy as np
import torch
import torch.nn.functional as F
from torch import nn

from tactogram.model import Example, SignalKind
from tactogram.models import find
from tactogram.signal import Image, Signal

RATE, BATCH, REPETITIONS = 10_000.0, 4, 3
MATERIALS = tuple("abcdefghi")


def run():
    learner, data = built()
    stage = learner.stages(data)[-1]
    learner.step(learner.stages(data)[0], data)
    batches = learner.batches(stage, data, seed=0)
    batch = next(batches)
    g, d = work(learner.gan.generator, 1), work(learner.gan.discriminator, 2)
    condition = {"image": data[0].photographs[0]}
    jobs = {
        "step": (
            BATCH * (3 * g + 8 * d),
            lambda: learner.step(stage, batch),
            lambda: plain_step(learner, batch),
        ),
        "photo to signal": (g, lambda: learner.generate(condition, seed=0), None),
        "photo to picture": (g, lambda: learner.gan.bare_generator(batch[1][:1], label(1)), None),
    }
    rows = []
    for name, (operations, ours, plain) in jobs.items():
        with torch.set_grad_enabled(name == "step"):
            rows.append(
                {"job": name, "batch": BATCH if name == "step" else 1, **measure(operations, ours, plain)}
            )
    eaten = BATCH / (rows[0]["ms"] / 1000)
    for _ in range(len(learner.translation.pairs(data)) // BATCH):
        next(batches)  # every crop made once
    seconds = timed(lambda: [next(batches) for _ in range(20)])
    rows.append(
        {"job": "pairs", "batch": BATCH, "pairs/s": 20 * BATCH / seconds, "eaten by a step (pairs/s)": eaten}
    )
    return rows


def built():
    random = np.random.default_rng(0)
    data = [
        Example(
            f"{name}{k}",
            Signal(random.standard_normal((1, 48_000)), RATE, "m/s^2"),
            name,
            photographs=(Image(random.integers(0, 256, (320, 480, 3), np.uint8)),),
        )
        for name in MATERIALS
        for k in range(2)
    ]
    facts = find("visual_tactile_gan")
    values = {
        "predictor": {"trunk": "own"},
        "batch_size": BATCH,
        "label": "true",
        "choose_by": "row_statistics",
        "pairs": {"repeats": 1},
    }
    kind = SignalKind(RATE, "m/s^2", ("z",), MATERIALS, simulated=True)
    return facts.build(facts.config(values), kind, seed=0), data


def work(network, channels):
    """Return the multiplications and additions of a forward pass for one photograph, by every convolution."""
    total = 0

    def count(layer, given, out):
        nonlocal total
        places = given[0] if isinstance(layer, nn.ConvTranspose2d) else out
        total += 2 * layer.weight.numel() * places.shape[-2] * places.shape[-1]

    hooks = [
        layer.register_forward_hook(count)
        for layer in network.modules()
        if isinstance(layer, nn.Conv2d | nn.ConvTranspose2d)
    ]
    network.eval()
    with torch.no_grad():
        x = torch.zeros(1, channels, 256, 256)
        network(x, label(1)) if channels == 1 else network(x)
    for hook in hooks:
        hook.remove()
    return total


def label(count):
    return torch.eye(len(MATERIALS))[:1].expand(count, -1)


def plain_step(learner, batch):
    gan, config = learner.gan, learner.config
    photo, picture, true = batch[1:4]
    gan.train(0.0)
    y = F.one_hot(true, len(MATERIALS)).float()
    made = gan.generator(photo, y)

    def judge(x):
        return gan.discriminator(torch.cat((photo, x), 1))

    def bce(judged, value):
        return sum(F.binary_cross_entropy_with_logits(f[-1], torch.full_like(f[-1], value)) for f in judged)

    loss_d = bce(judge(picture), 1.0) + bce(judge(made.detach()), 0.0)
    judged, real = judge(made), judge(picture)
    pairs = [
        (a, b)
        for ours, theirs in zip(judged, real, strict=True)
        for a, b in zip(ours[:-1], theirs[:-1], strict=True)
    ]
    matching = sum(F.l1_loss(a, b) for a, b in pairs) / len(pairs)
    loss_g = bce(judged, 1.0) + config.l1 * F.l1_loss(made, picture) + config.feature_matching * matching
    gan.optimisers[0].zero_grad()
    loss_g.backward()
    gan.optimisers[0].step()
    gan.optimisers[1].zero_grad()
    loss_d.backward()
    gan.optimisers[1].step()


def measure(operations, ours, plain):
    """Return rates and shares; each repetition runs the product, ours and the plain form in turn."""
    ours(), product()
    times = {"matrix": [], "ours": [], "plain": []}
    for _ in range(REPETITIONS):
        times["matrix"].append(timed(product))
        times["ours"].append(timed(ours))
        if plain:
            times["plain"].append(timed(plain))
    rate, took = 2 * 2048**3 / median(times["matrix"]), median(times["ours"])
    row = {
        "ms": 1e3 * took,
        "matrix product (GFLOP/s)": rate / 1e9,
        "share": operations / took / rate,
        "threads": torch.get_num_threads(),
    }
    if plain:
        slow = median(times["plain"])
        row |= {
            "plain (ms)": 1e3 * slow,
            "faster than plain": slow / took,
            "plain share": operations / slow / rate,
        }
    return row


A = torch.randn(2048, 2048)


def product():
    return A @ A


def timed(function):
    start = time.perf_counter()
    function()
    return time.perf_counter() - start
