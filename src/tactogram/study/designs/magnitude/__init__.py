"""Magnitude estimation: a number for how strong something feels."""

from tactogram.study.designs.magnitude.design import MagnitudeEstimation as MagnitudeEstimation
