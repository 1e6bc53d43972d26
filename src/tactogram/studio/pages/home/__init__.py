"""The first page, and something to play with."""
