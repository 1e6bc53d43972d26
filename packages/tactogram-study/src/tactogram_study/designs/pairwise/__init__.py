"""Pairwise preference, with the most informative pair next."""

from tactogram_study.designs.pairwise.design import PairwiseComparison as PairwiseComparison
