"""Magnitude estimation: a number for how strong something feels."""

from tactogram_study.designs.magnitude.design import MagnitudeEstimation as MagnitudeEstimation
