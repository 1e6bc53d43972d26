"""A display's vibration from sensory words: one CGAN per cluster of surfaces."""

from tactogram.models.ultrasonic_cgan.config import Config as Config
from tactogram.models.ultrasonic_cgan.learner import build as build
