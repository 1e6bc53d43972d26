"""The page Make: generate, see, hear, keep, compare."""
