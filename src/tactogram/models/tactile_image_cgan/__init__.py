"""Keio's conditional GAN that draws an image which evokes given sensory words."""

from tactogram.models.tactile_image_cgan.config import Config as Config
from tactogram.models.tactile_image_cgan.learner import build as build
