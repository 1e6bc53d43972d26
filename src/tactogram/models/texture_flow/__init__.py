"""Textures by conditional flow matching: on log-magnitude spectrograms, and on pixels."""

from tactogram.models.texture_flow.config import Config as Config
from tactogram.models.texture_flow.signal_learner import build as build
