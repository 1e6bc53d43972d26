"""Saga et al.: a convolutional network that names what is being stroked."""

from tactogram.models.stroke_cnn.config import Config as Config
from tactogram.models.stroke_cnn.learner import build as build
