"""A baseline: recorded segments of each material, joined by crossfades."""

from tactogram.models.replay.config import Config as Config
from tactogram.models.replay.learner import build as build
