"""A baseline: what was recorded on the surface that looks most like the one in the photograph."""

from tactogram.models.nearest_photo.config import Config as Config
from tactogram.models.nearest_photo.learner import build as build
