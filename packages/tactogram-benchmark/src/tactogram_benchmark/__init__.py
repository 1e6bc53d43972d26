"""Benchmark: tasks on fixed data and splits, answered by any model, judged alike, and ranked."""
