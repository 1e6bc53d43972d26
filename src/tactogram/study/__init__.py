"""Experiments with people."""
