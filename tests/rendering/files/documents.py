"""Documents of haptic formats, read and written as `read_haptic` and `write_haptic` do, without files."""

import json

import numpy as np

from tactogram.errors import DataError
from tactogram.rendering.files import read_haptic, write_haptic
from tactogram.rendering.files.analysis import envelope_of, events_of
from tactogram.rendering.files.documents import DocumentHeader, Notes
from tactogram.rendering.files.reading import decoded
from tactogram.signal import Signal

RATE = 2000


def read(module, document):
    """Return the content of a document that players accept."""
    notes = Notes()
    file = decoded(document, module.FORMAT, notes)
    if notes.problems:
        raise DataError(notes.problems[0])
    return file


def problems(module, document):
    """Return what a document that is written must not have: what no player accepts, then what players forgive."""
    notes = Notes()
    decoded(document, module.FORMAT, notes)
    return [*notes.problems, *notes.warnings]


def written_by(module, content, header=None):
    """Return the document of a signal or of events."""
    kind, header = module.FORMAT, header or DocumentHeader()
    if not isinstance(content, Signal):
        return kind.encode(content, header)
    if kind.encode_waveform:
        return kind.encode_waveform(content, header)
    return kind.encode(events_of(content, kind.bands), header)


def bursts(*spans, seconds=1.0, hz=150, strength=0.8):
    """Return a sine that is on in some spans of time, s."""
    t = np.arange(round(seconds * RATE)) / RATE
    on = np.zeros(len(t), bool)
    for start, stop in spans:
        on |= (t >= start) & (t < stop)
    return Signal(np.where(on, strength * np.sin(2 * np.pi * hz * t), 0.0), RATE, "1")


def level(document, module, time):
    """Return the amplitude of a document at some times, s."""
    found = envelope_of(read(module, document).signal)
    return np.interp(time, found.times, found.amplitude)


def again(folder, document, format):
    """Return the document of a file's conversion to a format, and what is said about it."""
    (folder / "one.json").write_text(json.dumps(document))
    found = write_haptic(folder / "two.json", read_haptic(folder / "one.json"), format=format)
    return json.loads((folder / "two.json").read_text()), found
