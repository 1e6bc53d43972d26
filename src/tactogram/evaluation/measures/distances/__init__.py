"""Distances between two sets of signals: one module each, with its formula and source."""
