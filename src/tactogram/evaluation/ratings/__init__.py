"""Evaluation against ratings in sensory words."""
