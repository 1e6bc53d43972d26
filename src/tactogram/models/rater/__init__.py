"""What people would say of a signal or an image, from what they said of others."""

from tactogram.models.rater.config import Config as Config
from tactogram.models.rater.learner import build as build
