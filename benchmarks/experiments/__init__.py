"""Experiments of our own, of the same form as `tactogram_benchmark.experiments`: no publication has their tables."""
