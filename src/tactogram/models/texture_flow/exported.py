"""The flow for other runtimes: its velocity, all steps of its solver, phase recovery, and prediction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import torch
from torch import Tensor, nn

from tactogram.features.phase import recover
from tactogram.features.phase_network import PhaseRecovery, convergence_db
from tactogram.model import ExportedNetwork, Port
from tactogram.models.texture_flow.config import Config
from tactogram.models.texture_flow.flow import solve, times_of
from tactogram.models.texture_flow.flow_model import FlowModel, guided
from tactogram.models.texture_flow.surface_prediction import SurfacePredictor
from tactogram.models.texture_flow.surfaces import SurfaceSpectra
from tactogram.nn.bare_and_fixed import for_export
from tactogram.training.seeds import child_generator

DRAWN = 1
"""Spectra or images in a batch of typical inputs."""


def exported_flow(
    flow: FlowModel,
    size: tuple[int, ...],
    label: tuple[int, ...],
    *,
    axes: tuple[str, ...],
    output: str,
    free: tuple[str, ...],
    facts: Mapping[str, Any],
) -> dict[str, ExportedNetwork]:
    """Return the velocity and the whole solver, from noise of ``size`` and labels of the shape ``label``."""
    network, config = for_export(flow.average.network), flow.config
    steps = 1 if config.straightening_steps else config.solver_steps
    label_axes = ("batch", *(("frame",) if len(label) == 2 else ()), "label")

    def draw(seed: int) -> tuple[Tensor, Tensor]:
        random = child_generator(seed, "export")
        noise = torch.randn(DRAWN, *size, generator=random)
        return noise, torch.randn(DRAWN, *label, generator=random).clamp(-1, 1)

    def draw_at_times(seed: int) -> tuple[Tensor, Tensor, Tensor]:
        noise, given = draw(seed)
        return noise, torch.rand(DRAWN, generator=child_generator(seed, "time")), given

    inputs = {
        "x": Port(axes, "noise on its way to data"),
        "time": Port(("batch",), "flow time, 0 (noise) to 1 (data)"),
        "label": Port(label_axes, "condition; zeros are none"),
    }
    known = {**facts, "solver_times": times_of(steps)}
    noise = Port(axes, "standard normal random numbers")
    return {
        "velocity": ExportedNetwork(
            network, draw_at_times, inputs, {"velocity": Port(axes, "velocity of x")}, free=free, facts=known
        ),
        "sampler": ExportedNetwork(
            Sampler(network, config),
            draw,
            {"noise": noise, "label": inputs["label"]},
            {"data": Port(axes, output)},
            free=free,
            facts=known,
        ),
    }


def exported_recovery(spectra: SurfaceSpectra, frames: int, unit: str) -> ExportedNetwork:
    """Return the phase recovery of the sources of a surface, each by itself."""
    transform, iterations = spectra.transform, spectra.iterations
    shape = DRAWN, transform.bins, frames

    def draw(seed: int) -> tuple[Tensor, Tensor]:
        random = child_generator(seed, "phase")
        noise = torch.randn(DRAWN, transform.length(frames), generator=random)
        return transform.forward(noise).abs(), math.tau * torch.rand(shape, generator=random)

    column = ("batch", "bin", "frame")
    return ExportedNetwork(
        PhaseRecovery(transform, frames, iterations).eval(),
        draw,
        {
            "magnitude": Port(column, "magnitudes of a source", unit),
            "phase": Port(column, "phase to start from", "rad"),
        },
        {"signal": Port(("batch", "time"), "signal of a source", unit)},
        free=(),
        reference=lambda magnitude, phase: recover(
            magnitude, transform, transform.length(frames), start=phase, iterations=iterations
        ),
        convergence=lambda magnitude, phase, samples: convergence_db(magnitude, transform, samples),
        note="the package starts from phase gradient heap integration, which has no graph: draw phases at random; "
        "the surface's spectrum and the mix of its sources to axes are not networks",
        facts={"iterations": iterations, "n_fft": transform.n_fft, "hop": transform.hop},
    )


def exported_predictor(predictor: SurfacePredictor) -> ExportedNetwork:
    """Return the prediction of a surface's components at another speed and force."""
    network = for_export(predictor)
    components, label = len(network.spread), network.linear.in_features
    drawn = 2

    def draw(seed: int) -> tuple[Tensor]:
        return (torch.randn(drawn, label, generator=child_generator(seed, "export")),)

    return ExportedNetwork(
        Components(network),
        draw,
        {"label": Port(("batch", "label"), "stroke, speed and force, those wanted, and words, standardised")},
        {"components": Port(("batch", "component"), "principal components of the surface, standardised")},
        facts={"conditions": list(network.conditions), "components": components},
    )


class Sampler(nn.Module):
    """All steps of the solver, unrolled."""

    def __init__(self, network: nn.Module, config: Config) -> None:
        super().__init__()
        self.network, self.config = network, config

    def forward(self, noise: Tensor, label: Tensor) -> Tensor:
        """Return data that ``noise`` flows to."""
        if self.config.straightening_steps:
            return solve(lambda x, time: self.network(x, time, label), noise, 1)
        return solve(guided(self.network, label, self.config.guidance), noise, self.config.solver_steps)


class Components(nn.Module):
    """Perceptron and linear map of a predictor."""

    def __init__(self, predictor: SurfacePredictor) -> None:
        super().__init__()
        self.linear, self.perceptron = predictor.linear, predictor.perceptron

    def forward(self, label: Tensor) -> Tensor:
        """Return standardised components, (batch, component)."""
        found: Tensor = self.linear(label) + self.perceptron(label)
        return found
