"""Experiments of our own, of the same form as `tactogram.experiments`: no publication has their tables."""
