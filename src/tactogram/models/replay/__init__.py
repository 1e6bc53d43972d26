"""A baseline: recorded segments of each material, joined by crossfades."""

from tactogram.models.replay.learner import Config as Config, build as build
