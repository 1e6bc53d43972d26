"""Rater model: predicted word ratings of a signal or an image."""

from tactogram.models.rater.config import Config as Config
from tactogram.models.rater.learner import build as build
