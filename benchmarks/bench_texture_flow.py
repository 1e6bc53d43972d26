"""`texture_flow quick`: a training step as a share of the machine's matrix-product rate, and generation.

The rate is that of a 2048 x 2048 float32 product, measured in the same run. The step's work is three times the forward
multiplications and additions of its convolutions and dense layers; activations, normalisation, the optimiser, the
average of the weights and the spectra of the crops take time but are not work. Generation includes phase recovery.
"""

import torch

from benchmarks.bench_stroke_gan import built, measured


def run():
    rows = []
    for axes, rate in ((1, 2500.0), (3, 1000.0)):
        learner, _, data = built("texture_flow", "quick", axes, rate, {})
        stage = learner.stages(data)[-1]
        batch = next(learner.batches(stage, data, seed=0))
        network, config = learner.flow.network, learner.config
        shape = (axes, learner.spectra.bins, config.frames)
        label = batch[2][:1]
        forward = work(network, torch.zeros(1, *shape), torch.zeros(1), label)
        size = {"axes": axes, "batch": config.batch_size}
        step = measured(lambda: learner.step(stage, batch), 3 * forward * config.batch_size)  # noqa: B023
        rows.append({**size, "job": "step", **step})
        for seconds in (4.0, 60.0):
            frames = learner.spectra.frames(round(seconds * rate), config.multiple)
            operations = config.solver_steps * forward * frames / config.frames
            made = measured(
                lambda s=seconds: learner.generate({"material": "a"}, seconds=s, seed=0),  # noqa: B023
                operations,
            )
            rows.append({**size, "job": f"generate, {seconds:g} s", **made})
    return rows


def work(network, *inputs):
    """Return the multiplications and additions of a forward pass."""
    found = 0

    def count(module, given, output):
        nonlocal found
        # A transposed convolution spreads each input over its taps, every other layer gathers them for each output.
        spreads = isinstance(module, torch.nn.ConvTranspose2d)
        found += 2 * module.weight[0].numel() * (given[0] if spreads else output).numel()

    layers = torch.nn.Conv2d | torch.nn.ConvTranspose2d | torch.nn.Linear
    hooks = [m.register_forward_hook(count) for m in network.modules() if isinstance(m, layers)]
    with torch.no_grad():
        network(*inputs)
    for hook in hooks:
        hook.remove()
    return found
