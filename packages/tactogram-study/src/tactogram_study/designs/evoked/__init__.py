"""Evoked words: the words that the sight of an image evokes."""

from tactogram_study.designs.evoked.design import EvokedWords as EvokedWords
