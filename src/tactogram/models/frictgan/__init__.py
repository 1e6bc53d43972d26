"""FrictGAN: friction over displacement from a photograph of a fabric."""

from tactogram.models.frictgan.config import Config as Config
from tactogram.models.frictgan.learner import build as build
