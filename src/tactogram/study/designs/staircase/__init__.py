"""Staircases: an intensity that follows the answers to two alternatives."""

from tactogram.study.designs.staircase.design import Staircase as Staircase
from tactogram.study.designs.staircase.design import StaircaseTrack as StaircaseTrack
