"""Evoked words: what the sight of an image calls to mind."""

from tactogram.study.designs.evoked.design import EvokedWords as EvokedWords
