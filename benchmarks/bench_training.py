"""A training step of `stroke_cnn` as a share of the machine's matrix-product rate, measured in the same run.

The rate is that of a 2048 x 2048 float32 product. The step's work is counted as three times the forward
multiplications and additions of its convolutions and dense layers; activations, normalisation and the optimiser are not
counted as work, but take time.
"""

import time
from statistics import median

import numpy as np
import torch

from tactogram.model import Example, SignalKind
from tactogram.models import find
from tactogram.signal import Signal


def run():
    rows = []
    for axes, rate, batch in ((1, 2500.0, 32), (3, 330.0, 32), (3, 330.0, 64)):
        random = np.random.default_rng(0)
        names = ("x", "y", "z")[:axes]
        data = [
            Example(str(i), Signal(random.standard_normal((axes, 12_000)), rate, "1", names), "ab"[i % 2])
            for i in range(8)
        ]
        facts = find("stroke_cnn")
        learner = facts.build(
            facts.config({"batch_size": batch}), SignalKind(rate, "1", names, ("a", "b")), seed=0
        )
        stage = learner.stages(data)[-1]
        batches = learner.batches(stage, data, seed=0)
        work = 3 * forward_work(learner) * batch
        steps, products = [], []
        for _ in range(4):
            products += [timed(product) for _ in range(3)]
            steps += [timed(learner.step, stage, next(batches)) for _ in range(4)]
        rate_matrix = 2 * 2048**3 / median(products[3:])
        rows.append(
            {
                "axes": axes,
                "batch": batch,
                "step (ms)": 1e3 * median(steps[4:]),
                "step (GFLOP/s)": work / median(steps[4:]) / 1e9,
                "matrix product (GFLOP/s)": rate_matrix / 1e9,
                "share": work / median(steps[4:]) / rate_matrix,
                "threads": torch.get_num_threads(),
            }
        )
    return rows


A = torch.randn(2048, 2048)


def product():
    return A @ A


def timed(function, *arguments):
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start


def forward_work(learner):
    """Return the multiplications and additions of one window's forward pass."""
    work = 0

    def count(module, _, output):
        nonlocal work
        taps = module.weight[0].numel()
        work += 2 * taps * output[0].numel()

    network = learner.network
    hooks = [
        m.register_forward_hook(count)
        for m in network.modules()
        if isinstance(m, torch.nn.Conv2d | torch.nn.Linear)
    ]
    with torch.no_grad():
        network.eval()(torch.zeros(1, len(learner.kind.axes), learner.config.window))
    network.train()
    for hook in hooks:
        hook.remove()
    return work
