"""Textures of any length from a small GAN behind autoregressive filters: our best generator."""

from tactogram.models.texture_gan.config import Config as Config
from tactogram.models.texture_gan.learner import build as build
