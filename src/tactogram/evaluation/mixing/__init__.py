"""Evaluation of mixes of two materials."""
