"""`stroke_gan` and `texture_gan`: shares of the matrix-product rate, beside the plainest PyTorch form of the networks.

The rate is that of a 2048 x 2048 float32 product, measured in the same run. Work is what the convolutions and
dense layers need as published, labels as constant channels and all: with g and d for one forward pass of generator
and discriminator, an update of the discriminator is g + 10 d per signal (three forward passes, two of them
differentiated once, one twice), one of the generator 3 g + 2 d. Activations, phase shuffle, optimiser and data
take time but are not work; nor is what noise and statistics of `texture_gan` need. `generate` is counted by the
pieces that its signals last; its bands are not matched here, which would cost both forms the same. "plain":
`Conv2d` and `ConvTranspose2d` on (batch, channel, axis, time), constant channels made, phase shuffle by `roll`; the
same weights, and the same training step around them.
"""

import time
from itertools import pairwise
from statistics import median

import numpy as np
import torch
import torch.nn.functional as F
from torch import nn

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
        ours, kind, data = built(model, recipe, axes, rate, changes)
        plain, _, _ = built(model, recipe, axes, rate, changes)
        plain.generator = (PlainShapedGenerator if shaped else PlainGenerator)(ours.generator)
        plain.discriminator = PlainDiscriminator(ours.discriminator)
        plain.optimisers = [
            torch.optim.Adam(network.parameters(), lr=1e-4)
            for network in (plain.generator, plain.discriminator)
        ]
        config = ours.config
        labels = len(kind.materials) + (len(config.conditions) if shaped else 0)
        check(ours, plain, labels, bands=config.noise_bands if shaped else 0)
        g, d = work(ours, labels, bands=config.noise_bands if shaped else 0)
        updates = (1, 1) if shaped else (config.critic_updates, config.generator_updates)
        step = config.batch_size * (updates[0] * (g + 10 * d) + updates[1] * (3 * g + 2 * d))
        if shaped:
            plain.average = ours.average = None
        stage = ours.stages(data)[1]
        batch = next(ours.batches(stage, data, seed=0))
        size = {"model": model, "recipe": recipe, "axes": axes, "batch": config.batch_size}
        jobs = {"step": (step, lambda learner: learner.step(stage, batch))}  # noqa: B023
        for seconds, label in ((None, "one piece"), (60.0, "60 s")):
            length = config.length / rate if seconds is None else seconds
            jobs[f"generate, {label}"] = (
                g * length * rate / config.length,
                lambda learner, s=seconds: learner.generate({"material": "a"}, seconds=s, seed=0),
            )
        for job, (operations, do) in jobs.items():
            rows.append({**size, "job": job, **compare(do, ours, plain, operations)})
    return rows


def compare(do, ours, plain, operations, repetitions=5):
    """Return rates and shares; each repetition runs the product, ours and the plain form in turn."""
    do(ours), do(plain), product()
    times = {"matrix": [], "ours": [], "plain": []}
    for _ in range(repetitions):
        times["matrix"].append(timed(product))
        times["ours"].append(timed(do, ours))
        times["plain"].append(timed(do, plain))
    rate = 2 * 2048**3 / median(times["matrix"])
    return {
        "ms": 1e3 * median(times["ours"]),
        "plain (ms)": 1e3 * median(times["plain"]),
        "faster than plain": median(times["plain"]) / median(times["ours"]),
        "matrix product (GFLOP/s)": rate / 1e9,
        "share": operations / median(times["ours"]) / rate,
        "plain share": operations / median(times["plain"]) / rate,
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


class PlainGenerator(nn.Module):
    """The generator of `stroke_gan` by PyTorch's own layers; holds copies of the weights of ours."""

    def __init__(self, ours):
        super().__init__()
        self.leak, self.shape, self.dense = ours.leak, ours.shape, ours.dense
        self.layers = nn.ModuleList(plain(nn.ConvTranspose2d, layer) for layer in ours.layers)

    def forward(self, latent, label):
        """Return signals."""
        h = self.dense(torch.cat((latent, label), 1)).unflatten(1, self.shape).permute(0, 3, 1, 2)
        for layer in self.layers:
            h = layer(F.leaky_relu(h, self.leak))
        return torch.tanh(h[:, 0])


class PlainShapedGenerator(PlainGenerator):
    """The generator of `texture_gan` by PyTorch's own layers."""

    def __init__(self, ours):
        super().__init__(ours)
        self.plain, self.periodic = ours.plain, ours.periodic

    def forward(self, latent, label, noise):
        """Return signals."""
        h = self.dense(torch.cat((latent[:, : self.plain], label), 1))
        h = h.unflatten(1, self.shape).permute(0, 3, 1, 2)
        hidden, tones = self.periodic(latent[:, self.plain :], label)
        for layer in self.layers:
            if layer is self.layers[-1]:
                h = h + hidden.permute(0, 3, 1, 2)
            h = layer(F.leaky_relu(h, self.leak))
        gains = 3.0 * torch.tanh(h[:, 1:] / 3.0)
        return h[:, 0] + (gains.exp() * noise.permute(0, 3, 1, 2)).sum(1) + tones


class PlainDiscriminator(nn.Module):
    """The discriminator by PyTorch's own layers."""

    def __init__(self, ours):
        super().__init__()
        self.leak, self.reach, self.dense = ours.leak, ours.shuffle.reach, ours.dense
        self.layers = nn.ModuleList(plain(nn.Conv2d, layer) for layer in (ours.first, *ours.layers))

    def forward(self, x, label):
        """Return scores."""
        constant = label[:, :, None, None].expand(-1, -1, *x.shape[1:])
        h = self.layers[0](torch.cat((x[:, None], constant), 1))
        for layer in self.layers[1:]:
            h = layer(self.shuffle(F.leaky_relu(h, self.leak)))
        return self.dense(F.leaky_relu(h, self.leak).permute(0, 2, 3, 1).flatten(1))

    def shuffle(self, h):
        """Move each item by a few samples, round the end."""
        shifts = torch.randint(-self.reach, self.reach + 1, (len(h),)).tolist()
        return torch.stack([item.roll(k, 2) for item, k in zip(h, shifts, strict=True)])


def plain(kind, layer):
    kernel, fine, coarse = layer.weight.shape
    up = kind is nn.ConvTranspose2d
    channels = (coarse, fine) if up else (fine, coarse)
    more = {"output_padding": (0, 1)} if up else {}
    made = kind(*channels, (1, kernel), stride=(1, layer.stride), padding=(0, 11), **more)
    with torch.no_grad():
        made.weight.copy_(layer.weight.permute(2, 1, 0)[:, :, None])
        made.bias.copy_(layer.bias)
    return made


@torch.no_grad()
def check(ours, plain, labels, *, bands):
    """Stop if the two forms are not the same networks."""
    label, config = torch.eye(labels)[:2], ours.config
    latent = torch.rand(2, config.latents if bands else config.latent)
    noise = (torch.randn(2, len(ours.kind.axes), config.length, bands),) if bands else ()
    made, expected = ours.generator(latent, label, *noise), plain.generator(latent, label, *noise)
    torch.testing.assert_close(made, expected, atol=1e-3, rtol=1e-3)
    reach = plain.discriminator.reach
    plain.discriminator.reach = ours.discriminator.shuffle.reach = 0
    expected = plain.discriminator(made, label)
    torch.testing.assert_close(ours.discriminator(made, label), expected, atol=1e-2, rtol=1e-3)
    plain.discriminator.reach = ours.discriminator.shuffle.reach = reach


A = torch.randn(2048, 2048)


def product(*_):
    return A @ A


def timed(function, *arguments):
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start
