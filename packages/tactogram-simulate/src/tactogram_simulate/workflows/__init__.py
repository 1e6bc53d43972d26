"""Workflows: what the verbs of this package do, one function each."""
