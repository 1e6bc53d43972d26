"""Engines without the transients of landings, for tests of what else they render."""

import numpy as np
from scipy import signal as dsp

from tactogram_playback.streaming.contact import ContactSettings
from tactogram_playback.streaming.engine import Engine

RATE, MOST = 8000.0, 40
SILENT = ContactSettings(gain=0)


def engine(textures, motion, **options):
    return Engine(textures, motion, rate=RATE, most=MOST, contact=options.pop("contact", SILENT), **options)


def peak_hz(samples, rate=RATE):
    frequency, power = dsp.welch(samples, rate, nperseg=2048)
    return float(frequency[np.argmax(power)])
