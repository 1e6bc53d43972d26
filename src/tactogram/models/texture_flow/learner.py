"""Learners by what they generate: signals of recordings, or images of rated images."""

from __future__ import annotations

import torch

from tactogram.model import ImageKind, Kind
from tactogram.models.texture_flow.config import Config
from tactogram.models.texture_flow.image_learner import ImageFlowLearner
from tactogram.models.texture_flow.signal_learner import SignalFlowLearner


def build(
    config: Config, kind: Kind, *, seed: int, device: str | torch.device = "cpu"
) -> SignalFlowLearner | ImageFlowLearner:
    """Return an untrained model for signals or images of ``kind``."""
    if isinstance(kind, ImageKind):
        return ImageFlowLearner(config, kind, seed=seed, device=device)
    return SignalFlowLearner(config, kind, seed=seed, device=device)
