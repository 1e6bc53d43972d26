"""Designs of studies, one file each."""

from collections.abc import Mapping

from tactogram.study.designs.abx import Abx
from tactogram.study.designs.design import Design as Design
from tactogram.study.designs.evoked import Evoked
from tactogram.study.designs.magnitude import Magnitude
from tactogram.study.designs.pairwise import Pairwise
from tactogram.study.designs.rating import Rating
from tactogram.study.designs.staircase import Staircase
from tactogram.study.designs.two_area import TwoArea

DESIGNS: Mapping[str, type[Design]] = {
    kind.model_fields["kind"].default: kind
    for kind in (TwoArea, Rating, Evoked, Abx, Staircase, Magnitude, Pairwise)
}
"""By the name that a study's file gives."""
