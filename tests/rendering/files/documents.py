"""Documents of haptic formats, read and written as `read_haptic` and `write_haptic` do, without files."""

from tactogram.errors import DataError
from tactogram.rendering.files.analysis import events_of
from tactogram.rendering.files.documents import DocumentHeader, Notes
from tactogram.rendering.files.reading import decoded
from tactogram.signal import Signal


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
