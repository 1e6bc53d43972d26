"""Signals into devices and haptic files."""
