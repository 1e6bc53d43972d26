"""A baseline: what was recorded on the surface that looks most like the one in the photograph."""

from tactogram.models.nearest_photo.learner import Config as Config, build as build
