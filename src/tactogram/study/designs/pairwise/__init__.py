"""Pairwise preference, with pairs chosen by what their answers tell."""

from tactogram.study.designs.pairwise.design import PairwiseComparison as PairwiseComparison
