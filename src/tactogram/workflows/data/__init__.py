"""Data sets: simulating, importing, converting, rating."""
