"""Result of one cluster's training: the chosen networks, or none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import torch
from numpy.typing import NDArray

from tactogram.evaluation.checkpoint_selection import SelectedIteration
from tactogram.models.ultrasonic_cgan.config import Config
from tactogram.models.ultrasonic_cgan.networks import Discriminator, Generator, discriminator_of


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
        generator, discriminator = Generator(config, words=words), discriminator_of(config, words=words)
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
        made = self.generator(torch.cat((x, label), 1))
        probability = self.discriminator.probability(torch.cat((made, label), 1))
        return made.double().cpu().numpy(), probability[:, 0].double().cpu().numpy()
