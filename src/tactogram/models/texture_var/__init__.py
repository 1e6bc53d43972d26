"""Textures as modulated noise, its strength a vector autoregression fitted in closed form."""

from tactogram.models.texture_var.config import Config as Config
from tactogram.models.texture_var.learner import build as build
