"""AHAP, Apple's haptic patterns (Core Haptics): an envelope, its sharpness, and transients.

"Representing haptic patterns in AHAP files", Apple developer documentation. As in Meta's exporter (haptic_data, MIT),
intensity is the square root of the amplitude. A curve acts on all events at once: intensity is multiplied, sharpness
added (Apple; the MPEG reference software does the same).
"""

from tactogram.rendering.files.documents import has_key
from tactogram.rendering.files.format import HapticFormat
from tactogram.rendering.files.formats.ahap.reading import decode as decode
from tactogram.rendering.files.formats.ahap.rules import validate as validate
from tactogram.rendering.files.formats.ahap.writing import encode as encode
from tactogram.rendering.files.formats.ahap.writing import encode_envelope as encode_envelope

FORMAT = HapticFormat(
    name="ahap",
    title="AHAP (Apple)",
    suffix=".ahap",
    holds="envelope",
    encode=encode,
    encode_envelope=encode_envelope,
    decode=decode,
    validate=validate,
    recognise=has_key("Pattern"),
)
