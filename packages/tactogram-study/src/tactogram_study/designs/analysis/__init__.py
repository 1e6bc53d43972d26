"""Analyses and power simulations of single designs, imported when they are called."""
