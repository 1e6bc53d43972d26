"""Staircases: an intensity that follows the answers to two alternatives."""

from tactogram_study.designs.staircase.design import Staircase as Staircase, StaircaseTrack as StaircaseTrack
