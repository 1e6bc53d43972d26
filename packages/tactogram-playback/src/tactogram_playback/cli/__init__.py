"""The verbs of tactogram-playback; imports nothing heavy."""

VERBS = {
    "playing": {
        "stream": "Play textures that follow a finger, and measure how late they are.",
        "play": "Play a rendered drive on a sound card, or an envelope on a generator that makes the carrier itself.",
        "sweep": "Write the sweep that measures a display's response.",
        "response": "Identify a display's response from a played sweep and its recording.",
        "calibrate": "Fit voltage to friction, person by person, for an electrovibration display.",
        "transducer": "Identify a transducer's resonance and Q from its measured admittance.",
        "track": "Keep a carrier at a transducer's resonance, by its measured voltage and current.",
    },
}
"""Verbs and their help, by the module of this package that declares each in its own ``VERBS``."""
