"""Saga et al.: a convolutional network that classifies stroked materials."""

from tactogram.models.stroke_cnn.config import Config as Config
from tactogram.models.stroke_cnn.learner import build as build
