"""Culbertson et al.: a texture as filtered noise, its filter mixed over speed, force and material."""

from tactogram.models.ar_texture.config import Config as Config
from tactogram.models.ar_texture.learner import build as build
