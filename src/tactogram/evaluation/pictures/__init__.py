"""Evaluation of generated spectrogram pictures and images."""
