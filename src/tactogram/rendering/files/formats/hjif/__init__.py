"""HJIF, the JSON form of MPEG's haptics (ISO/IEC 23090-31), which holds the waveform itself."""

from tactogram.rendering.files.documents import has_key
from tactogram.rendering.files.format import HapticFormat
from tactogram.rendering.files.formats.hjif.rules import MODALITIES, validate
from tactogram.rendering.files.formats.hjif.waveform import HIGHEST_RATE, decode, encode

FORMAT = HapticFormat(
    name="hjif",
    title="HJIF (MPEG)",
    suffix=".hjif",
    holds="waveform",
    encode=encode,
    decode=decode,
    validate=validate,
    recognise=has_key("perceptions"),
    instead=".wav",
    modalities=MODALITIES,
    highest_rate=HIGHEST_RATE,
)
