"""Side-by-side measurements; each is a ratio taken in one run, none is a test."""
