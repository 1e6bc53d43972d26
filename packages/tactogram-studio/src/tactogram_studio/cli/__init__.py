"""The verbs of tactogram-studio; imports nothing heavy."""

VERBS = {
    "studio": {
        "studio": "Open the studio in the browser: generate, touch, train, send, and run studies.",
        "study run": "Serve a study to participants and its progress to the experimenter; run again to continue.",
    }
}
"""Verbs and their help, by the module of this package that declares each in its own ``VERBS``."""
