"""The verbs of tactogram-study; imports nothing heavy."""

GROUPS = {
    "study": "experiments with people: check, run, simulate, export, analyse",
}
VERBS = {
    "studying": {
        "study list": "List the studies that come with the package.",
        "study designs": "List the designs that a study can have, with their margins and power tables.",
        "study languages": "List the languages of participants' pages, or print the texts of one.",
        "study copy": "Copy a study into a file of your own, to be edited.",
        "study check": "Check a study's file and describe what it asks of a participant.",
        "study simulate": "Let simulated participants take a study, with or without an effect.",
        "study export": "Write the answers of a session as a tidy table or a BIDS folder.",
        "study withdraw": "Delete a participant and all their data; export tables again afterwards.",
        "study progress": "Show the progress of each participant in a session.",
        "study note": "Add an experimenter's note to a session.",
        "study abort": "End a participant's session now; the answers so far are kept.",
        "study end": "End a study: nobody can join, and unfinished participants cannot continue.",
        "study analyse": "Analyse answers, as published and with repeated measures, with intervals and verdicts.",
        "study power": "Compute the power of a study before it is run: exactly, and with simulated participants.",
    },
}
"""Verbs and their help, by the module of this package that declares each in its own ``VERBS``."""
