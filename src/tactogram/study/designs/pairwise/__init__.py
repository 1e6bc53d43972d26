"""Pairwise preference, with pairs chosen by what their answers tell."""

from tactogram.study.designs.pairwise.design import Pairwise as Pairwise
