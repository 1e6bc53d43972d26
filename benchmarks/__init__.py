"""Side-by-side measurements of speed, and experiments of our own; none is a test."""
