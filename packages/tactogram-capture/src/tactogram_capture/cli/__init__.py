"""The verbs of tactogram-capture; imports nothing heavy."""

VERBS = {
    "capturing": {
        "capture": "Record a session by a plan, or continue one; every accepted take is stored at once.",
        "live": "Classify what a sensor touches, live.",
        "sources": "List the sources that can be recorded from, and what each lacks.",
        "device": "Test one device, and say how each way to it was tested.",
        "capture-log": "Import a sensor's log into files or a store, with its gaps.",
    },
}
"""Verbs and their help, by the module of this package that declares each in its own ``VERBS``."""
