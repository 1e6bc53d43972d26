"""Streaming of textures under a moving finger."""
