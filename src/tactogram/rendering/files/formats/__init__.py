"""Haptic file formats, one module each."""
