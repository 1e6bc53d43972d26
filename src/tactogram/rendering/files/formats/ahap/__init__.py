"""AHAP, Apple's haptic patterns (Core Haptics): vibrations, transients, and the curves that act on both.

"Representing haptic patterns in AHAP files", Apple developer documentation. As in Meta's exporter (haptic_data, MIT),
intensity is the square root of the amplitude. Events that overlap play together; their powers are added.
"""

from tactogram.rendering.files.documents import has_key
from tactogram.rendering.files.format import HapticFormat
from tactogram.rendering.files.formats.ahap.reading import decode as decode
from tactogram.rendering.files.formats.ahap.writing import encode as encode

FORMAT = HapticFormat(
    name="ahap",
    title="AHAP (Apple)",
    suffix=".ahap",
    holds="envelope",
    encode=encode,
    decode=decode,
    recognise=has_key("Pattern"),
)
