"""Textures as modulated noise, its strength a vector autoregression fitted in closed form."""

from tactogram.models.texture_var.learner import Config as Config, build as build
