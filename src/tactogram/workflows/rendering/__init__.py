"""Rendering to displays and devices."""
