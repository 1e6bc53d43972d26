"""Experiments with people: designs, the session store, and the analysis of answers."""
