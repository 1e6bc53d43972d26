"""Saga et al.: a conditional WaveGAN that generates, and mixes, strokes over surfaces."""

from tactogram.models.stroke_gan.config import Config as Config
from tactogram.models.stroke_gan.learner import build as build
