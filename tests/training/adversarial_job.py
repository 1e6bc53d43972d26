"""Training of a small GAN in double precision, for test_averaging.py, which runs this."""

import json
import os
import sys
from pathlib import Path

import torch
from torch import nn

from tactogram.model import BatchShare
from tactogram.nn.adversarial_networks import gradient_penalty
from tactogram.nn.initial_weights import bare, fixed
from tactogram.recipe import TrainingSettings
from tactogram.training.device import make_fabric
from tactogram.training.loop import mean_over_processes

STEPS, BATCH = 12, 8


class Critic(nn.Module):
    """``last`` scales the last row of a batch alone, ``unused`` nothing."""

    def __init__(self):
        super().__init__()
        self.layers = nn.Sequential(nn.Conv1d(3, 6, 3), nn.Tanh(), nn.Flatten(), nn.Linear(36, 1))
        self.last, self.unused = nn.Parameter(torch.ones(1)), nn.Parameter(torch.ones(1))

    def forward(self, x, *, last=False):
        score = self.layers(x)[:, 0]
        return torch.cat((score[:-1], score[-1:] * self.last)) if last else score


def train(devices):
    """Return the mean losses of each step, and the weights."""
    fabric = make_fabric(TrainingSettings(precision="32-true"), accelerator="cpu", devices=devices)
    share = BatchShare.of_process(fabric)
    draw = torch.Generator().manual_seed(1)
    torch.manual_seed(fabric.global_rank)  # weights of the first process count
    generator = nn.Sequential(nn.Linear(4, 24), nn.Tanh(), nn.Unflatten(1, (3, 8)))
    networks = [generator.double(), Critic().double()]
    pairs = [fabric.setup(network, torch.optim.Adam(network.parameters(), lr=1e-2)) for network in networks]
    (generator, for_generator), (critic, for_critic) = pairs
    losses = []
    for _ in range(STEPS):
        real, noise, mixed = (
            torch.randn(BATCH, *size, generator=draw).double() for size in ((3, 8), (4,), ())
        )
        real, noise, mixed = (x[share.places(range(BATCH), BATCH)] for x in (real, noise, mixed))
        with torch.no_grad():
            made = generator(noise)
        penalty = gradient_penalty(bare(critic), real, made, mixed)
        last = share.number == share.of - 1
        loss = critic(made).mean() - critic(real, last=last).mean() + 10 * penalty
        for_critic.zero_grad()
        fabric.backward(loss)
        nn.utils.clip_grad_norm_(critic.parameters(), 1.0)
        for_critic.step()
        with fixed(critic):
            against = -critic(generator(noise)).mean()
        for_generator.zero_grad()
        fabric.backward(against)
        for_generator.step()
        losses.append(mean_over_processes({"critic": loss.item(), "generator": against.item()}, fabric))
    weights = {k: v.tolist() for network in (generator, critic) for k, v in network.state_dict().items()}
    return {"losses": losses, "weights": weights}


if __name__ == "__main__":  # Fabric starts this again for the second process
    found = train(2)
    if os.environ.get("LOCAL_RANK", "0") == "0":
        Path(sys.argv[1]).write_text(json.dumps(found), encoding="utf-8")
