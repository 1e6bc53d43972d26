"""The verbs of tactogram-studio; imports nothing heavy."""

VERBS = {
    "studio": {
        "studio": "Open the studio in the browser: generate, touch, train, send, and run studies.",
        "study run": "Serve a study to participants and its progress to the experimenter; run again to continue.",
        "touch": "Write a texture as JSON, for <tactogram-pad> in a page of your own and for engines.",
    }
}
"""Verbs and their help, by the module of this package that declares each in its own ``VERBS``."""
