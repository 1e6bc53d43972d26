"""Statistics of a stroke and a linear discriminant: a classifier in seconds."""

from tactogram.models.stroke_statistics.learner import Config as Config, build as build
