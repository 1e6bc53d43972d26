"""Tactogram learns, generates, judges and renders touch."""
