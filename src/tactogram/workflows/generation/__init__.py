"""Generation of signals and images from trained models."""
