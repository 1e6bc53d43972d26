"""CGAN of a cluster: its networks in training, the choice of the generator, and the result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Self

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor, nn

from tactogram.evaluation.checkpoint_selection import IterationSelector, SelectedIteration, SelectionRule
from tactogram.models.ultrasonic_cgan.config import Config
from tactogram.models.ultrasonic_cgan.networks import Discriminator, Generator
from tactogram.models.ultrasonic_cgan.spectra import felt_features
from tactogram.nn.adversarial_networks import AdversarialNetworks
from tactogram.nn.initial_weights import bare, fixed
from tactogram.nn.score_regression import ScoreRegression
from tactogram.training.seeds import torch_seeded

CURVES = ("generator_loss", "discriminator_loss", "correct_rate")
"""Figures of every iteration, in this order."""


class ClusterNetworks(AdversarialNetworks):
    """Networks in training, cluster after cluster, each from its initial weights, and the best weights so far."""

    def __init__(self, config: Config, *, words: int, seed: int, device: torch.device) -> None:
        self.config, self.words, self.seed = config, words, seed
        rates = (config.learning_rate, config.discriminator_learning_rate or config.learning_rate)
        # Fused: one pass over the weights instead of a dozen, 3 ms in place of 13 on one core.
        adam = partial(torch.optim.Adam, betas=config.betas, eps=config.epsilon, fused=True)
        super().__init__(*self._initial(0), rates=rates, optimiser=adam, device=device)
        self.regression: ScoreRegression | None = None  # of display signals, with `Config.words_weight`
        self.rule = SelectionRule(config.rate_low, config.rate_high, config.smooth, config.choose_after)
        self.begin(0)

    def begin(self, cluster: int) -> None:
        self.cluster = cluster
        for network, fresh in zip(self._bare, self._initial(cluster), strict=True):
            network.load_state_dict(fresh.state_dict())
            network.train()
        if "optimisers" in vars(self):
            self.load_optimisers([optimiser.state_dict() | {"state": {}} for optimiser in self.optimisers])
        self.selector = IterationSelector(self.rule)
        self.best: tuple[dict[str, Tensor], ...] = ()
        self.curves: list[NDArray[np.float32]] = []

    def iterate(self, sensor: Tensor, display: Tensor) -> dict[str, float]:
        """Update both networks once for each batch, and return the means of the figures.

        ``sensor`` and ``display`` are scaled spectra with their scores: float32, shape (iteration, batch, bin + word).
        """
        batch = sensor.shape[1]
        truth = torch.cat((torch.ones(batch, 1), torch.zeros(batch, 1))).to(sensor.device)
        truly = truth > 0.5
        self.curves.append(
            np.array(
                [self._update(x, y, truth, truly) for x, y in zip(sensor, display, strict=True)], np.float32
            ).T
        )
        figures = dict(zip(CURVES, self.curves[-1].mean(axis=1).tolist(), strict=True))
        rate = self.selector.rate
        return figures if np.isnan(rate) else figures | {"correct_rate_smoothed": rate}

    def _update(self, x: Tensor, display: Tensor, truth: Tensor, truly: Tensor) -> list[float]:
        """One iteration of Sec. IV-C: the discriminator, then the generator by the updated discriminator.

        The cross-entropy is E(t, y) = -t log y - (1 - t) log(1 - y): Eq. (2) has log(1 - t) as its last factor, which
        does not depend on y, and is infinite at t = 1. The generator's counts its spectra as training data.
        """
        bins = self.config.bins
        fake = torch.cat((self.generator(x), x[:, bins:]), 1)  # B, bins + words
        logits = self.discriminator(torch.cat((display, fake.detach()))).float()  # 2 B, 1
        loss = F.binary_cross_entropy_with_logits(logits, truth)
        self.descend(1, loss)
        with fixed(self.discriminator):
            verdict = self.discriminator(fake).float()  # B, 1
        generator_loss = F.binary_cross_entropy_with_logits(verdict, truth[: len(x)])
        if self.regression is not None:
            error = self.regression.loss(felt_features(fake[:, :bins].float()), x[:, bins:])
            generator_loss = generator_loss + self.config.words_weight * error
        right = ((logits > 0) == truly).float().mean()
        # Only here does the host wait for the device: the choice needs the figures before the update.
        figures: list[float] = torch.stack((generator_loss.detach(), loss.detach(), right)).tolist()
        if self.selector.update(figures[0], figures[2]):
            self._store_best()
        self.descend(0, generator_loss)
        return figures

    def _store_best(self) -> None:
        """Copy the current weights, of which the generator's loss was computed."""
        if not self.best:
            self.best = tuple(
                {name: x.detach().clone() for name, x in network.state_dict().items()}
                for network in self._bare
            )
            return
        for best, network in zip(self.best, self._bare, strict=True):
            for name, x in network.state_dict().items():
                best[name].copy_(x)

    @property
    def _bare(self) -> tuple[nn.Module, nn.Module]:
        """Both networks without Fabric around them."""
        return bare(self.generator), bare(self.discriminator)

    def _initial(self, cluster: int) -> tuple[Generator, Discriminator]:
        with torch_seeded(self.seed, "weights", cluster):
            return Generator(self.config, words=self.words), Discriminator(self.config, words=self.words)

    def outcome(self) -> dict[str, Any]:
        """Return the result of the cluster's training: the chosen weights, or none if it failed, and the curves."""
        chosen = self.selector.chosen
        return {
            "chosen": None if chosen is None else [chosen.iteration, chosen.loss, chosen.rate],
            "generator": self.best[0] if self.best else None,
            "discriminator": self.best[1] if self.best else None,
            "curves": np.concatenate((np.zeros((3, 0), np.float32), *self.curves), axis=1),
        }

    def state(self) -> dict[str, Any]:
        return {
            "cluster": self.cluster,
            "now": [network.state_dict() for network in self._bare],
            "adam": self.optimiser_state(),
            "outcome": self.outcome(),
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        self.begin(state["cluster"])
        for network, weights in zip(self._bare, state["now"], strict=True):
            network.load_state_dict(weights)
        self.load_optimisers(state["adam"])
        outcome = state["outcome"]
        curves = np.asarray(outcome["curves"], np.float32)
        self.curves = [curves]
        rates = tuple(curves[2, -self.rule.window :].tolist())
        chosen = outcome["chosen"]
        best = (
            None if chosen is None else SelectedIteration(int(chosen[0]), float(chosen[1]), float(chosen[2]))
        )
        self.selector = IterationSelector(self.rule, best, rates, curves.shape[1])
        if best is not None:
            self.best = tuple(
                {name: x.to(self.device) for name, x in outcome[key].items()}
                for key in ("generator", "discriminator")
            )


@dataclass(frozen=True, eq=False)
class TrainedCluster:
    """A cluster after its training.

    Parameters
    ----------
    chosen : SelectedIteration, optional
        None: the training failed, as Sec. IV-C defines it.
    curves : float32 array, shape (3, iteration)
        Loss of the generator, loss of the discriminator, correct rate of the discriminator; not smoothed.
    generator, discriminator : optional
        With the weights of the chosen iteration, in evaluation mode; None if the training failed.
    """

    chosen: SelectedIteration | None
    curves: NDArray[np.float32]
    generator: Generator | None
    discriminator: Discriminator | None

    @classmethod
    def of(cls, outcome: Mapping[str, Any], config: Config, *, words: int, device: torch.device) -> Self:
        curves = np.asarray(outcome["curves"], np.float32)
        if outcome["chosen"] is None:
            return cls(None, curves, None, None)
        iteration, loss, rate = outcome["chosen"]
        generator, discriminator = Generator(config, words=words), Discriminator(config, words=words)
        generator.load_state_dict(outcome["generator"])
        discriminator.load_state_dict(outcome["discriminator"])
        return cls(
            SelectedIteration(int(iteration), float(loss), float(rate)),
            curves,
            generator.eval().to(device),
            discriminator.eval().to(device),
        )

    def state(self) -> dict[str, Any]:
        return {
            "chosen": self.chosen and [self.chosen.iteration, self.chosen.loss, self.chosen.rate],
            "generator": self.generator and self.generator.state_dict(),
            "discriminator": self.discriminator and self.discriminator.state_dict(),
            "curves": self.curves,
        }

    @torch.inference_mode()
    def answers(
        self, spectra: NDArray[np.floating], scores: NDArray[np.floating]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return display spectra of sensor spectra, and the discriminator's probability of training data.

        Parameters
        ----------
        spectra : array, shape (spectrum, bin)
            Divided by the sensor's scale.
        scores : array, shape (word,), 0 to 1

        Returns
        -------
        generated : float64 array, shape (spectrum, bin)
            Not yet multiplied by the display's scale; may be negative.
        probability : float64 array, shape (spectrum,)
        """
        if self.generator is None or self.discriminator is None:
            raise RuntimeError("a failed training has no networks")
        device = next(self.generator.parameters()).device
        x = torch.tensor(np.asarray(spectra, np.float32), device=device)
        label = torch.tensor(np.asarray(scores, np.float32), device=device).expand(len(x), -1)
        output = self.generator(torch.cat((x, label), 1))
        probability = self.discriminator.probability(torch.cat((output, label), 1))
        return output.double().cpu().numpy(), probability[:, 0].double().cpu().numpy()
