"""Neshov et al.: from a photograph to touch, by a class-conditional GAN."""

from tactogram.models.visual_tactile_gan.config import Config as Config
from tactogram.models.visual_tactile_gan.learner import build as build
