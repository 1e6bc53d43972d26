"""Drives: from a signal to the input of a display."""
