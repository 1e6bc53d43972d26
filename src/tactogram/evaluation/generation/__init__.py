"""Evaluation protocol of signal generators."""
