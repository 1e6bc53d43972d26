"""The verbs of tactogram-simulate; imports nothing heavy."""

VERBS = {
    "simulating": {
        "demo": "Simulate, classify, search, generate and evaluate surfaces, and write a report.",
        "data simulate": "Simulate a data set of surfaces.",
    },
}
"""Verbs and their help, by the module of this package that declares each in its own ``VERBS``."""
