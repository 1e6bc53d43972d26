"""Culbertson et al.: a texture as filtered noise, its filter mixed over speed, force and material."""

from tactogram.models.ar_texture.learner import Config as Config, build as build
