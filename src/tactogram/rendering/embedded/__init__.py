"""Textures for microcontrollers, as C headers."""
