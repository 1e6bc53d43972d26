"""Rater model: predicted word ratings of a signal or an image."""

from tactogram.models.rater.learner import build as build
from tactogram.models.rater.regression import Config as Config
