"""Ratings in sensory words."""
