"""Displays: descriptions, catalogue and measured responses."""
