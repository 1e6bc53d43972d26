"""Designs of studies, one file each."""

from collections.abc import Mapping

from tactogram.study.designs.abx import Abx
from tactogram.study.designs.design import Design as Design
from tactogram.study.designs.evoked import Evoked
from tactogram.study.designs.magnitude import MagnitudeEstimation
from tactogram.study.designs.pairwise import PairwiseComparison
from tactogram.study.designs.rating import Rating
from tactogram.study.designs.staircase import Staircase
from tactogram.study.designs.two_area import TwoArea

DESIGNS: Mapping[str, type[Design]] = {
    kind.model_fields["kind"].default: kind
    for kind in (TwoArea, Rating, Evoked, Abx, Staircase, MagnitudeEstimation, PairwiseComparison)
}
"""By the name that a study's file gives."""
