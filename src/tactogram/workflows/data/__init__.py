"""Data sets: importing, converting, rating."""
