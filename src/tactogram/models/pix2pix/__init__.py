"""Isola et al.: pictures to pictures by a conditional GAN; a baseline of visual_tactile_gan."""

from tactogram.models.pix2pix.config import Config as Config
from tactogram.models.pix2pix.learner import build as build
